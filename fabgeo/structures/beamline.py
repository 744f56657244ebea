"""Where a beam's plates run: the section, and curves at every level and lateral position.

Distances along the axis are signed like offsets: positive on the side of t x e.

Glossary
--------
level
    Signed distance from the model along the axis of the edge.
lateral position
    Distance from the axis strip along the rulings of the strip orthogonal to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array
from fabgeo.errors import InputError
from fabgeo.strips.axes import Axes
from fabgeo.strips.flanges import axis_strip, envelope, trajectory
from fabgeo.strips.frames import EdgeCurves
from fabgeo.structures.parts import Role


@dataclass(frozen=True)
class Section:
    """A built-up section; lengths in mm.

    Attributes
    ----------
    outer : float
        Signed distance of the outer flange's outer face from the model, along the axis.
    depth : float
        Overall depth, inwards from there.
    web, flange_outer, flange_inner : float
        Thicknesses; a flange of thickness 0 is left out (T section).
    width_outer, width_inner : float
        Widths of the flanges.
    box : float
        Clear distance of two webs; 0 for one web.
    material : str
    """

    outer: float = -60.0
    depth: float = 300.0
    web: float = 10.0
    flange_outer: float = 12.0
    flange_inner: float = 12.0
    width_outer: float = 160.0
    width_inner: float = 160.0
    box: float = 0.0
    material: str = "steel"

    def __post_init__(self) -> None:
        if min(self.depth, self.web) <= 0.0 or min(self.flange_outer, self.flange_inner) < 0.0:
            raise InputError("Section", f"expected positive depth and thicknesses, found {self}")
        if self.clear <= 0.0:
            raise InputError("Section", f"its flanges fill the depth of {self.depth:g} mm")

    @property
    def clear(self) -> float:
        """Depth of the web between the flanges."""
        return self.depth - self.flange_outer - self.flange_inner

    def levels(self) -> dict[str, float]:
        """Distances along the axis: web's edges and the flanges' mid-surfaces."""
        inner = self.outer - self.depth
        return {
            "web_in": inner + self.flange_inner,
            "web_out": self.outer - self.flange_outer,
            "flange_in": inner + self.flange_inner / 2.0,
            "flange_out": self.outer - self.flange_outer / 2.0,
        }


@dataclass(frozen=True)
class PlateStrip:
    """One plate of a section: (level, lateral position) of both its edge curves."""

    name: str
    role: Role
    thickness: float
    first: tuple[float, float]
    second: tuple[float, float]


class BeamLine:
    """Where the beam of one edge runs: curves at every level and lateral position.

    Parameters
    ----------
    construction : str
        With "trajectory" a level s means the point p + (s + drift(u)) n/|n|, where drift has mean
        0 along the edge; with "envelope" it means p + s n.
    """

    def __init__(
        self, model: EdgeCurves, field: Axes, edge: int, section: Section, construction: str
    ) -> None:
        self.strip = axis_strip(model, field, edge)
        self.section = section
        self.construction = construction
        self.edge = edge
        self.closed = model.closed_u
        self.where = f"beam B-{edge:02d}"
        u = model.parameters(8)
        self.span = (0.0, float(model.segments))
        if construction == "trajectory":
            self._s = trajectory(self.strip)
            self._mean = float((self._s(u).max() + self._s(u).min()) / 2.0)

    def drift(self, u: Array) -> Array:
        """How far trajectories leave the constant distance along the axis at u, mm."""
        if self.construction == "envelope":
            return np.zeros(len(u))
        return self._s(u) - self._mean

    def axis_point(self, u: Array, level: float) -> Array:
        """Point of the web at a level."""
        if self.construction == "envelope":
            return self.strip.offset(u, level)
        return self.strip.at(u, level + self.drift(u))

    def lines(self, u: Array, wanted: Sequence[tuple[float, float]]) -> Array:
        """Curves (N, k, 3) at N pairs of a level and a lateral position y.

        Lateral positions run along the rulings of the orthogonal strip at that level, b itself
        for trajectories.
        """
        if self.construction == "envelope":
            return np.stack([self._envelope_line(u, level, y) for level, y in wanted])
        _, n, b = self.strip.frame(u)
        base = self.strip.curve(u, 0) + self.drift(u)[:, None] * n
        return np.stack([base + level * n + y * b for level, y in wanted])

    def _envelope_line(self, u: Array, level: float, y: float) -> Array:
        if y == 0.0:
            return self.strip.offset(u, level)
        c, r = envelope(self.strip, level, u, self.where)
        return c + y * r

    def plates(self) -> list[PlateStrip]:
        """Webs and flanges of the section."""
        s, levels = self.section, self.section.levels()
        low, high = levels["web_in"], levels["web_out"]
        y = (s.box + s.web) / 2.0 if s.box > 0.0 else 0.0
        out = [PlateStrip("WEB", "web", s.web, (low, -y), (high, -y))]
        if s.box > 0.0:
            out.append(PlateStrip("WEC", "web", s.web, (low, y), (high, y)))
        flanges: list[tuple[str, Role, float, float, float]] = [
            ("FLO", "flange_outer", levels["flange_out"], s.width_outer, s.flange_outer),
            ("FLI", "flange_inner", levels["flange_in"], s.width_inner, s.flange_inner),
        ]
        for name, role, level, width, thickness in flanges:
            if thickness > 0.0:
                half = width / 2.0
                out.append(PlateStrip(name, role, thickness, (level, -half), (level, half)))
        return out

    def outline(self, u: Array) -> Array:
        """Corner curves (4, k, 3) of the whole section."""
        s = self.section
        half = max(s.width_outer, s.width_inner, s.box + 2.0 * s.web) / 2.0
        _, n, b = self.strip.frame(u)
        base = self.axis_point(u, s.outer)
        inner = base - s.depth * n
        return np.stack([inner - half * b, inner + half * b, base + half * b, base - half * b])
