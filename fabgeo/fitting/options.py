"""What a user may ask of a fit; every default serves a canopy of 2 m and a roof of 300 m."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

from fabgeo.arrays import Array, checked, checked_count, checked_number, shown
from fabgeo.errors import InputError
from fabgeo.fitting.objectives.towards import Shapes

type BoundaryChoice = Literal["auto", "edges", "ends", "all", "none"]
type Continuation = Literal["auto", "followed", "faded"]
type Aim = Literal["rms", "max"]
type Solver = Literal["auto", "banded", "pardiso", "superlu"]

CHOICES = {
    "boundary": BoundaryChoice,
    "continuation": Continuation,
    "minimise": Aim,
    "solver": Solver,
}
COUNTS = {  # the least and the most that may be asked for
    "levels": (0, 100),
    "across": (0, 100),
    "refinements": (0, 20),
    "iterations": (1, 1_000_000),
    "stages": (1, 1_000_000),
}
FASTEST = 1e6  # growth of a weight
HEAVIEST = 1e12  # weight of a term


@dataclass(frozen=True)
class Weights:
    """Weights of the terms of paper eq. (2): each multiplies a mean of squared lengths.

    The unit of length is the mean ruling length of the start.

    Attributes
    ----------
    proximity : float
        Distance to the surface, at edges and at the middles of rulings.
    boundary : float
        Distance of held edges and ends to the boundary.
    cover : float
        How far a border that overhangs the boundary draws in towards it, beyond a margin.
    points : float
        Distance of edges to given points.
    fair_edges, fair_rulings : float
        Bending of edge curves and ruling polygons, tangential to the surface.
    towards : float
        Distance of strips to the shapes they are drawn to.
    widths : float
        Difference of neighbouring ruling lengths.
    anchor : float
        Tangential distance to the start; only where nothing else holds a model in its domain. It
        falls as developability rises.
    normal_share : float
        How much of the normal part of a bending counts: the surface dictates it.
    boundary_normal_share : float
        How much of the distance to the boundary counts along the surface's normal.
    """

    proximity: float = 1.0
    boundary: float = 10.0
    cover: float = 0.02
    points: float = 10.0
    towards: float = 1.0
    fair_edges: float = 1e-4
    fair_rulings: float = 1e-4
    widths: float = 1e-4
    anchor: float = 1e-3
    normal_share: float = 0.03
    boundary_normal_share: float = 0.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if checked_number(f"Weights.{name}", value, least=0.0) > HEAVIEST:
                raise InputError(f"Weights.{name}", f"expected {HEAVIEST:g} at most")


@dataclass(frozen=True)
class FitOptions:
    """Limits, weights and the way of a fit.

    Attributes
    ----------
    twist_limit_deg : float
        The fit goes on until strips twist no more than this, or nothing helps any more.
    kind_limit_deg : float
        The same for the defect angle of conical, circular and geodesic models.
    weights : Weights
    boundary : {"auto", "edges", "ends", "all", "none"}
        What is held on the surface's boundary: the first and last edge curve, the ends u = 0 and
        u = m, all or nothing. "auto" holds whatever lies on the boundary in the start; a conical
        or circular model is never held at its ends, as its net is the surface's own.
    continuation : {"auto", "followed", "faded"}
        Whether what overhangs a surface keeps to its continuation, or is let go farther and farther
        from the boundary. "auto" lets conical, circular and geodesic models go, and general ones
        where the continuation keeps them from the limits.
    points : (k, 3) array or None
        Mounting points that edge curves are to pass through, in the surface's unit.
    towards : Shapes or None
        Shapes that strips are drawn to, piece by piece.
    minimise : {"rms", "max"}
        Whether the root mean square or the largest deviation is made small.
    levels : int or None
        Times that the start is coarsened along u before the fit refines it again exactly; None
        chooses by the number of segments.
    across : int
        Times that neighbouring strips are taken together before the fit, and halved again after.
    refinements : int
        Times that knot spans are halved beyond the start's, where the limits are not reached; more
        than once only where they are near. A fit that ends near them, if knots may be halved at
        all, is made again with three times the steps, and once more halved.
    iterations : int
        Steps of Levenberg-Marquardt that one stage may take.
    stages : int
        Times that the weight of developability may grow.
    growth : float
        Factor by which it grows.
    solver : {"auto", "banded", "pardiso", "superlu"}
        How the normal equations are solved; "auto" goes by their size.
    """

    twist_limit_deg: float = 0.002
    kind_limit_deg: float = 0.005
    weights: Weights = field(default_factory=Weights)
    boundary: BoundaryChoice = "auto"
    continuation: Continuation = "auto"
    points: Array | None = None
    towards: Shapes | None = None
    minimise: Aim = "max"
    levels: int | None = None
    across: int = 0
    refinements: int = 1
    iterations: int = 20
    stages: int = 12
    growth: float = 10.0
    solver: Solver = "auto"

    def __post_init__(self) -> None:
        for name, choice in CHOICES.items():
            words, found = get_args(choice.__value__), getattr(self, name)
            if not isinstance(found, str) or found not in words:
                raise InputError(
                    f"FitOptions.{name}", f"expected one of {words}, found {shown(found)}"
                )
        for name in ("twist_limit_deg", "kind_limit_deg"):
            checked_number(f"FitOptions.{name}", getattr(self, name), above=0.0)
        for name, (least, most) in COUNTS.items():
            if name != "levels" or self.levels is not None:
                checked_count(f"FitOptions.{name}", getattr(self, name), least, most)
        if checked_number("FitOptions.growth", self.growth, above=1.0) > FASTEST:
            raise InputError("FitOptions.growth", f"expected {FASTEST:g} at most")
        if not isinstance(self.weights, Weights):
            raise InputError("FitOptions.weights", f"expected Weights, found {shown(self.weights)}")
        if self.towards is not None and not hasattr(self.towards, "lanes"):
            raise InputError("FitOptions.towards", f"expected Shapes, found {shown(self.towards)}")
        if self.points is not None:
            none = isinstance(self.points, list) and not self.points
            points = checked(
                "FitOptions.points", np.empty((0, 3)) if none else self.points, (None, 3)
            )
            object.__setattr__(self, "points", points)
