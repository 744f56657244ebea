"""Fitting strip models: objectives, least squares, Levenberg-Marquardt, starts."""
