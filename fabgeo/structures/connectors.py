"""Point fixings between panels and outer flanges (paper Fig. 9): placed, drilled, checked.

A fixing stands on the outer face of a beam's outer flange, square to the panel. Its holes are laid
out once, in its own frame, and pierce panel and flange along the same axes: the holes of both
plates are the same holes.

Glossary
--------
frame
    Origin where the fixing's axis meets the flange's outer face; z along the panel's normal from
    the flange to the panel, x along the panel's edge.
stand-off
    Clear distance from the flange's outer face to the panel's near face along the axis.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fabgeo.arrays import Array, dot, unit
from fabgeo.errors import InputError
from fabgeo.strips.frames import cross
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.beams import with_holes
from fabgeo.structures.parts import Beam, Connector, Hole, Plate
from fabgeo.structures.prisms import ruled_normals


@dataclass(frozen=True)
class LocalHole:
    """A hole in the fixing's frame; `angle` (radians, from x) is a slot's direction."""

    x: float = 0.0
    y: float = 0.0
    diameter: float = 14.0
    slot: float = 0.0
    angle: float = 0.0


@dataclass(frozen=True)
class Fixing:
    """Parameters of a point fixing; its product geometry is drawn by the CAD room. All mm.

    Attributes
    ----------
    name : str
        Beginning of the product key.
    spacing, end_distance : float
        Largest distance of fixings along a panel's edge, and from its ends.
    edge_distance : float
        Distance of the axis from the panel's edge, square to it.
    stand_off, reach : float
        Nominal stand-off, and how far the real one may leave it.
    step : float
        Real stand-offs are rounded down to this step: equal ones are one product.
    bolt : float
        Nominal bolt diameter (12: M12).
    base_length, base_width, base_thickness : float
        Base plate on the flange, length along x.
    disc_diameter, disc_thickness : float
        Clamping disc on the panel's outer face.
    panel_holes, flange_holes : tuple of LocalHole
    maker : callable, optional
        The user's own bracket: the CAD room calls it with the fixing (its stand-off set) and
        takes the build123d part that it returns.
    """

    name: str = "FX"
    spacing: float = 600.0
    end_distance: float = 120.0
    edge_distance: float = 60.0
    stand_off: float = 25.0
    reach: float = 15.0
    step: float = 1.0
    bolt: float = 12.0
    base_length: float = 70.0
    base_width: float = 40.0
    base_thickness: float = 6.0
    disc_diameter: float = 44.0
    disc_thickness: float = 5.0
    panel_holes: tuple[LocalHole, ...] = (LocalHole(diameter=14.0),)
    flange_holes: tuple[LocalHole, ...] = (LocalHole(diameter=14.0, slot=10.0),)
    maker: Callable[..., object] | None = None

    def __post_init__(self) -> None:
        if min(self.spacing, self.end_distance, self.stand_off, self.step) <= 0.0:
            raise InputError(f"fixing {self.name}", "expected positive distances")

    @property
    def product(self) -> str:
        """Key of the product: name and stand-off."""
        return f"{self.name}-{self.stand_off:g}"


@dataclass(frozen=True)
class Fixings:
    """Placed fixings and the plates that they pierce.

    Attributes
    ----------
    connectors : list of Connector
    products : mapping
        Product key -> fixing with its real stand-off.
    panels : list of Plate
        The given panels, now with holes.
    beams : list of Beam
        The given beams, now with holes in their outer flanges.
    refused : mapping
        ``panel mark, edge`` -> why no fixing could be placed there.
    """

    connectors: list[Connector]
    products: Mapping[str, Fixing]
    panels: list[Plate]
    beams: list[Beam]
    refused: Mapping[str, str] = field(default_factory=dict)


def connect(panels: Sequence[Plate], beams: Sequence[Beam], fixing: Fixing) -> Fixings:
    """Place fixings along both edges of every panel where a beam runs below.

    Positions are spread evenly, `end_distance` clear of the panel's ends and clear of the joints
    between beam segments. What cannot be fixed (a flange too narrow, a stand-off out of reach) is
    refused by name, never drawn wrongly.
    """
    flanges: dict[int, list[tuple[Beam, Plate]]] = defaultdict(list)
    for beam in beams:
        for plate in beam.plates:
            if plate.role == "flange_outer":
                flanges[beam.edge].append((beam, plate))
    edges = (max(flanges) + 1) if flanges else 0
    drilled: dict[str, list[Hole]] = defaultdict(list)
    refused: dict[str, str] = {}
    products: dict[str, Fixing] = {}
    connectors: list[Connector] = []
    for panel in panels:
        strip = int(panel.mark.split("-")[1])
        number = 0
        for side in (0, 1):
            edge = strip + side
            if edge not in flanges and side == 1 and 0 in flanges and edge == edges:
                edge = 0  # a model closed in i
            for beam, flange in flanges.get(edge, ()):
                for site in _sites(panel, side, flange, fixing):
                    made = _fit(panel, flange, site, fixing)
                    if isinstance(made, str):
                        refused[f"{panel.mark}, edge {edge}, {beam.mark}"] = made
                        continue
                    frame, product, in_panel, in_flange = made
                    number += 1
                    mark = f"K-{panel.mark.removeprefix('P-')}-{number}"
                    products[product.product] = product
                    connectors.append(
                        Connector(mark, product.product, frame, panel.mark, beam.mark)
                    )
                    drilled[panel.mark] += in_panel
                    drilled[flange.mark] += in_flange
    return Fixings(
        connectors,
        products,
        [_drill(panel, drilled) for panel in panels],
        [with_holes(b, [_drill(p, drilled) for p in b.plates]) for b in beams],
        refused,
    )


def _drill(plate: Plate, drilled: Mapping[str, Sequence[Hole]]) -> Plate:
    holes = drilled.get(plate.mark, ())
    return replace(plate, holes=(*plate.holes, *holes)) if holes else plate


@dataclass(frozen=True)
class _Site:
    """A place on a panel's mid-surface: its point, edge direction and normal."""

    u: float
    point: Array
    along: Array
    normal: Array


def _sites(panel: Plate, side: int, flange: Plate, fixing: Fixing) -> list[_Site]:
    """Evenly spread places along one edge, over one flange segment and clear of its ends."""
    mid = panel.mid
    grid = mid.parameters(8)
    edge = mid.edges(grid)[side]
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(edge, axis=0), axis=1))])
    low, high = fixing.end_distance, arc[-1] - fixing.end_distance
    clear = fixing.base_length / 2.0 + 5.0
    ends = _over(flange.mid, edge, arc, clear)
    low, high = max(low, ends[0]), min(high, ends[1])
    if high < low:
        return []
    count = max(2, int(np.ceil((high - low) / fixing.spacing)) + 1)
    if high - low < 2.0 * fixing.base_length:
        count = 1
    places = np.linspace(low, high, count) if count > 1 else np.array([(low + high) / 2.0])
    u = np.interp(places, arc, grid)
    a, b = mid.edges(u)
    tangents = unit(mid.edges(u, 1)[side])
    chord: Array = b - a
    e = unit(chord) if side == 0 else -unit(chord)
    m = ruled_normals(mid, u)
    sine = np.abs(dot(cross(tangents, e), m))
    points = mid.edges(u)[side] + (fixing.edge_distance / sine)[:, None] * e
    return [_Site(*row) for row in zip(u, points, tangents, m, strict=True)]


def _over(flange: RuledPatch, edge: Array, arc: Array, clear: float) -> tuple[float, float]:
    """Range of the panel edge's arc length that lies over the flange, `clear` of its ends."""
    out = []
    for u, sign in ((flange.u0, 1.0), (flange.u1, -1.0)):
        at = np.array([u])
        point = flange.points(at, np.array([0.5]))[0]
        direction = sign * unit(flange.edges(at, 1).mean(axis=0))[0]
        ahead = (edge - point) @ direction - clear
        inside = ahead >= 0.0
        if not inside.any():
            return (1.0, 0.0)
        first = int(np.argmax(inside)) if sign > 0 else len(arc) - 1 - int(np.argmax(inside[::-1]))
        out.append(_crossing(arc, ahead, first, first - int(sign)))
    return out[0], out[1]


def _crossing(arc: Array, value: Array, inside: int, outside: int) -> float:
    """Arc length where `value` crosses zero between two neighbouring samples."""
    if not 0 <= outside < len(arc):
        return float(arc[inside])
    t = value[inside] / (value[inside] - value[outside])
    return float(arc[inside] + t * (arc[outside] - arc[inside]))


def pierce(mid: RuledPatch, point: Array, axis: Array, u: float) -> tuple[float, float, float]:
    """Where the line point + h axis meets a ruled patch: u, v, h, by Newton's method."""
    v, h = 0.5, 0.0
    for _ in range(30):
        at = np.array([min(max(u, mid.u0), mid.u1)])
        a, b = mid.edges(at)[:, 0]
        da, db = mid.edges(at, 1)[:, 0]
        miss = a + v * (b - a) - point - h * axis
        jacobian = np.stack([da + v * (db - da), b - a, -axis], axis=1)
        step = np.linalg.solve(jacobian, -miss)
        u, v, h = u + float(step[0]), v + float(step[1]), h + float(step[2])
        if np.abs(step[1:]).max() < 1e-13 * max(1.0, abs(h)) and np.linalg.norm(miss) < 1e-9:
            break
    return u, v, h


def _fit(
    panel: Plate, flange: Plate, site: _Site, fixing: Fixing
) -> tuple[Array, Fixing, list[Hole], list[Hole]] | str:
    """Frame, product and holes of one fixing, or why there is none."""
    guess = flange.mid.u0 + 0.5 * (flange.mid.u1 - flange.mid.u0)
    guess = site.u if flange.mid.u0 <= site.u <= flange.mid.u1 else guess
    u, v, h = pierce(flange.mid, site.point, site.normal, guess)
    if not flange.mid.u0 <= u <= flange.mid.u1:
        return "lies past the end of the beam segment"
    z = site.normal * -np.sign(h)
    x = unit(site.along - (site.along @ z) * z)
    at = np.array([u])
    a, b = flange.mid.edges(at)[:, 0]
    square = abs(float(ruled_normals(flange.mid, at)[0] @ z))
    stand_off = abs(h) - panel.thickness / 2.0 - flange.thickness / 2.0 / square
    if abs(stand_off - fixing.stand_off) > fixing.reach:
        return (
            f"needs a stand-off of {stand_off:.1f} mm; the fixing reaches "
            f"{fixing.stand_off - fixing.reach:g} to {fixing.stand_off + fixing.reach:g} mm"
        )
    width = float(np.linalg.norm(b - a))
    room = min(v, 1.0 - v) * width
    least = fixing.base_width / 2.0
    if room < least:
        return (
            f"needs a flange {width + 2.0 * (least - room):.0f} mm wide or a smaller edge "
            f"distance (the flange is {width:.0f} mm wide)"
        )
    rounded = float(np.floor(stand_off / fixing.step + 1e-9) * fixing.step)
    product = replace(fixing, stand_off=rounded)
    origin = site.point - z * (abs(h) - flange.thickness / 2.0 / square)
    frame = np.eye(4)
    frame[:3, 0], frame[:3, 1], frame[:3, 2], frame[:3, 3] = x, cross(z, x), z, origin
    return (
        frame,
        product,
        [_hole(panel, hole, frame, site.u) for hole in fixing.panel_holes],
        [_hole(flange, hole, frame, u) for hole in fixing.flange_holes],
    )


def _hole(plate: Plate, hole: LocalHole, frame: Array, u: float) -> Hole:
    """The hole where its axis, given in the fixing's frame, meets the plate's mid-surface."""
    x, y, z, origin = (frame[:3, k] for k in range(4))
    start = origin + hole.x * x + hole.y * y
    _, _, h = pierce(plate.mid, start, z, u)
    direction = np.cos(hole.angle) * x + np.sin(hole.angle) * y
    return Hole(start + h * z, z, hole.diameter, hole.slot, direction)
