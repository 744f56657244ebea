"""The terms of the functional, paper eq. (2), one a file: residuals and exact Jacobians.

All residuals are in the fit's unit (the mean ruling length), so weights have no dimension; each
term is a mean of squares over the model, so that weights do not depend on its size either.
"""
