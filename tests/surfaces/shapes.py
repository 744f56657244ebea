"""Design surfaces with closed forms that the tests of this room share."""

import numpy as np

from fabgeo.surfaces.formula import FormulaSurface

TURN = 2.0 * np.pi


def sphere(radius=3.0):
    return FormulaSurface(
        "r*cos(u)*cos(v)", "r*sin(u)*cos(v)", "r*sin(v)",
        (0.0, TURN), (-np.pi / 2, np.pi / 2), {"r": radius},
    )  # fmt: skip


def cylinder(radius=2.0, height=5.0):
    return FormulaSurface("r*cos(u)", "r*sin(u)", "v", (0.0, TURN), (0.0, height), {"r": radius})


def torus(big=5.0, small=2.0):
    return FormulaSurface(
        "(R + r*cos(v))*cos(u)", "(R + r*cos(v))*sin(u)", "r*sin(v)",
        (0.0, TURN), (0.0, TURN), {"R": big, "r": small},
    )  # fmt: skip


def hypar(size=1.0):
    return FormulaSurface("u", "v", "u*v", (-size, size), (-size, size))
