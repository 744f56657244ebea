"""Fitting strip models: objectives, least squares, Levenberg-Marquardt, starts."""

from fabgeo.fitting.fit import FitResult, Progress, fit
from fabgeo.fitting.options import FitOptions, Weights

__all__ = ["FitOptions", "FitResult", "Progress", "Weights", "fit"]
