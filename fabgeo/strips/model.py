"""The developable strip model (paper section 1, eq. 1) and its patches.

Glossary
--------
edge curve p_i(u)
    Cubic B-spline on uniform integer knots, i = 0..n (i = 0..n-1 where the model is closed in i).
strip i
    The ruled surface x_i(u, v) = (1 - v) p_i(u) + v p_{i+1}(u).
ruling
    The segment u = const of a strip; the rulings of one u over all strips: a ruling polygon.
patch
    The part of a strip between two rulings: what a panel, a cell or a wall is made on.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, get_args

import numpy as np

from fabgeo import spline
from fabgeo.arrays import (
    FARTHEST,
    Array,
    as_numbers,
    checked_count,
    checked_flag,
    checked_number,
    set_frozen,
    shown,
    unit,
)
from fabgeo.errors import InputError

type Kind = Literal["general", "conical", "circular", "geodesic"]
KINDS: tuple[str, ...] = get_args(Kind.__value__)
FINEST = 1000  # parameters a knot span
MOST_PARTS = 10_000  # that one strip may be divided into
MOST_STRIPS = 100_000  # in all
MOST_PARAMETERS = 10_000_000  # of one patch


@dataclass(frozen=True)
class StripModel:
    """Edge curves that share a parameter, and the strips between neighbours.

    Attributes
    ----------
    control : (edges, c, 3) array
        Control points b[i, j]. Open in u: c = m + 3 for m segments. Closed in u: c = m.
    closed_u : bool
        Every edge curve is a closed curve (a tower's floors).
    closed_i : bool
        The last edge is joined to the first by one more strip (a ring of strips).
    kind : str
        "general", "conical", "circular" or "geodesic": which property the model was fitted to.
    info : mapping
        What is worth keeping about its origin (start, weights, fit history); plain data.
    """

    control: Array
    closed_u: bool = False
    closed_i: bool = False
    kind: Kind = "general"
    info: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("closed_u", "closed_i"):
            object.__setattr__(self, name, checked_flag(f"StripModel.{name}", getattr(self, name)))
        set_frozen(self, "control", ("edges", "c", 3), most=FARTHEST)
        spline.checked_control("StripModel.control", self.control, self.closed_u)
        least = 3 if self.closed_i else 2
        if self.edges < least:
            raise InputError(
                "StripModel.control", f"needs {least} edge curves or more, found {self.edges}"
            )
        if not isinstance(self.kind, str) or self.kind not in KINDS:
            raise InputError(
                "StripModel.kind", f"expected one of {KINDS}, found {shown(self.kind)}"
            )
        if not isinstance(self.info, Mapping):
            raise InputError("StripModel.info", f"expected a mapping, found {shown(self.info)}")

    @property
    def edges(self) -> int:
        """Number of edge curves."""
        return self.control.shape[0]

    @property
    def strips(self) -> int:
        """Number of strips."""
        return self.edges if self.closed_i else self.edges - 1

    @property
    def segments(self) -> int:
        """Number m of knot spans; u runs over [0, m]."""
        return spline.segments_of(self.control.shape[1], self.closed_u)

    def points(self, u: Array, derivative: int = 0) -> Array:
        """Points or u-derivatives of all edge curves: (edges, k, 3) for u (k,)."""
        return spline.evaluate(self.control, u, self.closed_u, derivative)

    def edge(self, i: int, u: Array, derivative: int = 0) -> Array:
        """Points or u-derivatives of one edge curve (i modulo edges where closed): (k, 3)."""
        least, most = (-MOST_STRIPS, MOST_STRIPS) if self.closed_i else (0, self.edges - 1)
        i = checked_count("StripModel.edge", i, least, most) % self.edges
        return spline.evaluate(self.control[i], u, self.closed_u, derivative)

    def pairs(self, values: Array) -> tuple[Array, Array]:
        """Values per edge (edges, ...) as the two sides of every strip, each (strips, ...)."""
        if not isinstance(values, np.ndarray) or values.dtype.kind not in "fiub":
            values = as_numbers("StripModel.pairs", values)
        if values.shape[:1] != (self.edges,):
            problem = f"expected values of {self.edges} edges, found shape {values.shape}"
            raise InputError("StripModel.pairs", problem)
        if self.closed_i:
            return values, np.roll(values, -1, axis=0)
        return values[:-1], values[1:]

    def rulings(self, u: Array) -> tuple[Array, Array]:
        """Unit rulings (strips, k, 3) from p_i to p_{i+1} and their lengths (strips, k)."""
        first, second = self.pairs(self.points(u))
        vector = second - first
        return unit(vector), np.linalg.norm(vector, axis=-1)

    def parameters(self, per_segment: int = 4) -> Array:
        """Evenly spaced parameters, `per_segment` to a knot span, both ends of an open model."""
        count = self.segments * checked_count("per_segment", per_segment, 1, FINEST)
        u = np.linspace(0.0, self.segments, count + 1)
        return u[:-1] if self.closed_u else u

    def with_control(self, control: Array, **changes: Any) -> StripModel:
        """The same model with other control points (and other attributes, if given)."""
        return replace(self, control=control, **changes)

    def divided(self, counts: int | Sequence[int]) -> StripModel:
        """Every strip parted along its rulings into parts of equal width, the same surface.

        The curve at v = k / count of a ruled strip is the spline of the interpolated control
        points, so nothing moves and every part is as developable as its strip.

        Parameters
        ----------
        counts : int or sequence of int
            Parts of every strip, or of each.

        Raises
        ------
        InputError
            If a count is less than 1 or absurd, or there is not one for each strip.
        """
        alike = not isinstance(counts, Sequence | np.ndarray)
        each = [
            checked_count(f"StripModel.divided, {self.strips} strips", count, 1, MOST_PARTS)
            for count in ([counts] * self.strips if alike else counts)
        ]
        if len(each) != self.strips:
            raise InputError(
                "StripModel.divided", f"expected 1 part or more of {self.strips} strips each"
            )
        if sum(each) > MOST_STRIPS:
            raise InputError(
                "StripModel.divided", f"expected {MOST_STRIPS:,} parts at most, found {sum(each):,}"
            )
        parts = [
            first + k / count * (second - first)
            for first, second, count in zip(*self.pairs(self.control), each, strict=True)
            for k in range(count)
        ]
        if not self.closed_i:
            parts.append(self.control[-1])
        return self.with_control(np.array(parts))

    def refined(self) -> StripModel:
        """Every knot span halved, the same surface; parameters double."""
        return self.with_control(spline.refine(self.control, self.closed_u))


def check_model(name: str, given: Any) -> None:
    """Raise InputError where something else than a model is given, such as what holds one."""
    if hasattr(given, "strips") and callable(getattr(given, "parameters", None)):
        return
    found = type(given).__name__
    holds = isinstance(getattr(given, "model", None), StripModel)
    cure = f"pass {found.removeprefix('Fit').lower()}.model" if holds else "pass a StripModel"
    raise InputError(name, f"expected a strip model, found a {found}", cure)


@dataclass(frozen=True)
class Patch:
    """The part of strip `strip` of a model between the rulings u0 and u1.

    Attributes
    ----------
    strip, cell : int
        Strip index i and running number along the strip.
    u0, u1 : float
        Parameter interval, u0 < u1 (of a closed strip u1 may exceed m; parameters are periodic).
    """

    strip: int
    cell: int
    u0: float
    u1: float

    def __post_init__(self) -> None:
        for name in ("strip", "cell"):
            checked_count(f"patch {name}", getattr(self, name), 0)
        if not checked_number("patch u0", self.u0) < checked_number("patch u1", self.u1):
            raise InputError(
                f"patch {self.tag}", f"expected u0 < u1, found {self.u0} and {self.u1}"
            )

    @property
    def tag(self) -> str:
        """The number in every mark: strip and cell, such as ``03-07``."""
        return f"{self.strip:02d}-{self.cell:02d}"

    @property
    def mark(self) -> str:
        """The panel's mark, ``P-03-07``."""
        return f"P-{self.tag}"

    def parameters(self, count: int) -> Array:
        """`count` evenly spaced parameters from u0 to u1."""
        checked_count("patch parameters", count, 1, MOST_PARAMETERS)
        return np.linspace(self.u0, self.u1, count)

    def edges(self, model: StripModel, u: Array, derivative: int = 0) -> tuple[Array, Array]:
        """The two edge curves of the patch at u (k,): each (k, 3)."""
        check_patch("Patch.edges", model, self)
        return (
            model.edge(self.strip, u, derivative),
            model.edge(self.strip + 1, u, derivative),
        )


def check_patch(name: str, model: Any, given: Any) -> None:
    """Raise InputError where something else than a model and a patch of it is given."""
    check_model(name, model)
    if not isinstance(given, Patch):
        raise InputError(name, f"expected a patch, found a {type(given).__name__}", "pass a Patch")
    if given.strip >= model.strips:
        raise InputError(f"patch {given.tag}", f"the model's strips are 0 to {model.strips - 1}")
