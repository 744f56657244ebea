"""What the inspection of a design surface found, as plain data and as lines for people."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

PRINCIPALS = ("larger", "smaller")
"""The principal curvatures, by absolute value."""


@dataclass(frozen=True)
class StripSuggestion:
    """One way to lay strips, rulings along one principal direction.

    Attributes
    ----------
    rulings : str
        "smaller" (the paper's choice) or "larger": the principal curvature along the rulings.
    direction : str
        The other one, which the edges follow: `direction` of [strips] with start = "principal".
    across : (3,) tuple
        Mean direction of the rulings, unit.
    curvature_per_mm : float
        95th percentile of the normal curvature along the rulings.
    width_mm : float
        Ruling length at which the best fit deviates by the sag, L = sqrt(16 sag / kappa).
    sag_mm : float
        That sag.
    strips : int
        How many such strips cover the surface's extent along the rulings.
    """

    rulings: str
    direction: str
    across: tuple[float, float, float]
    curvature_per_mm: float
    width_mm: float
    sag_mm: float
    strips: int


@dataclass(frozen=True)
class Face:
    """One face of a file: what `faces` of [surface] calls it, its area, extents of its box."""

    index: int
    name: str
    area_m2: float
    size_mm: tuple[float, float, float]


@dataclass(frozen=True)
class Inspection:
    """What `inspect` found; lengths in mm, areas in m2, curvatures in 1/mm.

    Attributes
    ----------
    kind : str
        Class of the surface.
    face_count : int
        Faces of a CAD file, quads and triangles of a mesh.
    faces : tuple of Face
        Those of a CAD file.
    unit, unit_reason : str
        The file's unit and how it was found.
    size_mm : (3,) tuple
        Extents of the bounding box.
    area_m2 : float
    curvature_larger_per_mm, curvature_smaller_per_mm : (2,) tuple
        Range of the principal curvatures, larger and smaller by absolute value, with sign.
    radius_min_mm : float or None
        Smallest radius of curvature; None if flat.
    synclastic_share, anticlastic_share, single_curved_share, flat_share : float
        Of the area, by sign of the Gaussian curvature, adding up to 1.
    umbilic_share : float
        Share of the area where the principal curvatures nearly agree (no direction is principal).
    umbilic_at_mm : (3,) tuple or None
        The most umbilic place, if there is such a share.
    boundary_loops_mm : tuple of float
        Lengths of the boundary loops.
    suggestions : tuple of StripSuggestion
    notes : tuple of str
    """

    name: str
    kind: str
    face_count: int
    faces: tuple[Face, ...]
    unit: str
    unit_reason: str
    size_mm: tuple[float, float, float]
    area_m2: float
    curvature_larger_per_mm: tuple[float, float]
    curvature_smaller_per_mm: tuple[float, float]
    radius_min_mm: float | None
    synclastic_share: float
    anticlastic_share: float
    single_curved_share: float
    flat_share: float
    umbilic_share: float
    umbilic_at_mm: tuple[float, float, float] | None
    boundary_loops_mm: tuple[float, ...]
    suggestions: tuple[StripSuggestion, ...]
    notes: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """Plain data: dicts, lists, numbers, strings."""
        return _plain(asdict(self))

    def lines(self) -> list[str]:
        """The same for people, in metres."""
        size = " x ".join(_metres(x) for x in self.size_mm)
        lines = [
            f"surface    {self.name}: {self.kind}, faces: {self.face_count}",
            *(
                f"  face {f.index}{_named(f)}: {f.area_m2:.4g} m2, "
                f"{' x '.join(_metres(x) for x in f.size_mm)} m"
                for f in self.faces
            ),
            f"unit       {self.unit}, {self.unit_reason}",
            f"size       {size} m, area {self.area_m2:.4g} m2",
        ]
        ranges = (self.curvature_larger_per_mm, self.curvature_smaller_per_mm)
        for name, (low, high) in zip(PRINCIPALS, ranges, strict=True):
            bend = max(abs(low), abs(high)) * 1000.0
            least = f"radius from {1.0 / bend:.4g} m" if bend > 1e-9 else "straight"
            lines.append(
                f"curvature  {name} principal: {low * 1000.0:.4g} to {high * 1000.0:.4g} per m, "
                f"{least}"
            )
        shares = {
            "dome-like": self.synclastic_share,
            "saddle-like": self.anticlastic_share,
            "single-curved": self.single_curved_share,
            "flat": self.flat_share,
        }
        lines.append(
            "shape      " + ", ".join(f"{s:.1%} {k}" for k, s in shares.items() if s > 0.0)
        )
        loops = ", ".join(f"{_metres(x)} m" for x in self.boundary_loops_mm)
        lines.append(
            f"boundary   {len(self.boundary_loops_mm)} loops: {loops}"
            if loops
            else "boundary   none: a closed surface"
        )
        lines += [_strips_line(suggestion) for suggestion in self.suggestions]
        return lines + [f"note       {note}" for note in self.notes]


def _named(face: Face) -> str:
    return "" if face.name in ("", f"face {face.index}") else f" {face.name!r}"


def _strips_line(s: StripSuggestion) -> str:
    across = ", ".join(f"{x:.2f}" for x in s.across)
    return (
        f"strips     {s.strips}, up to {_metres(s.width_mm)} m wide within {s.sag_mm:g} mm, "
        f"rulings along the {s.rulings} curvature, about ({across}): "
        f'start = "principal", direction = "{s.direction}", count = {s.strips}'
    )


def _metres(length_mm: float) -> str:
    return f"{length_mm / 1000.0:.4g}"


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    return value
