"""What a design surface holds, measured: faces, size, curvature, boundary, how strips could run."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from fabgeo.arrays import Array, BoolArray
from fabgeo.surfaces.base import DesignSurface, SurfacePoints, size_of
from fabgeo.surfaces.creases import sharpest
from fabgeo.surfaces.nurbs import NurbsSurface

SAMPLES = 4000
FLAT = 1e-3  # curvature times size below which a direction counts as straight
UMBILIC = 0.05  # difference of the principal curvatures over their size
SAG = 5.0  # mm, for the suggested strip width


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
    strips : int
        How many such strips cover the surface's extent along the rulings.
    """

    rulings: str
    direction: str
    across: tuple[float, float, float]
    curvature_per_mm: float
    width_mm: float
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
        for name, (low, high) in zip(_NAMES, ranges, strict=True):
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


def inspect(surface: DesignSurface, sag_mm: float = SAG) -> Inspection:
    """Measure a design surface by some thousand evenly spread samples.

    Parameters
    ----------
    surface : DesignSurface
        In millimetres.
    sag_mm : float
        Deviation that the suggested strips may have from the surface.
    """
    at = surface.sample(SAMPLES)
    kappa, axes = at.principal()
    size = size_of(surface)
    low, high = surface.bounds
    straight = np.abs(kappa) * size < FLAT
    flat, single = straight[:, 0], straight[:, 1] & ~straight[:, 0]
    product = kappa[:, 0] * kappa[:, 1]
    doubly = ~straight[:, 1]
    spread = np.abs(kappa[:, 0] - kappa[:, 1]) / np.maximum(np.abs(kappa[:, 0]), 1e-300)
    umbilic = (spread < UMBILIC) & doubly
    where = at.point[np.argmin(np.where(doubly, spread, np.inf))] if umbilic.any() else None
    largest = float(np.abs(kappa[:, 0]).max())
    unit = getattr(surface, "unit", None)
    return Inspection(
        name=surface.name,
        kind=type(surface).__name__,
        face_count=_face_count(surface),
        faces=_faces(surface),
        unit=unit.name if unit else "mm",
        unit_reason=unit.reason if unit else "made in millimetres",
        size_mm=_triple(high - low),
        area_m2=_area(surface, at) / 1e6,
        curvature_larger_per_mm=(float(kappa[:, 0].min()), float(kappa[:, 0].max())),
        curvature_smaller_per_mm=(float(kappa[:, 1].min()), float(kappa[:, 1].max())),
        radius_min_mm=1.0 / largest if largest * size > FLAT else None,
        synclastic_share=float(np.mean(doubly & (product > 0.0))),
        anticlastic_share=float(np.mean(doubly & (product < 0.0))),
        single_curved_share=float(np.mean(single)),
        flat_share=float(np.mean(flat)),
        umbilic_share=float(np.mean(umbilic)),
        umbilic_at_mm=None if where is None else _triple(where),
        boundary_loops_mm=tuple(_length(loop) for loop in surface.loops),
        suggestions=tuple(
            s for k in (1, 0) if (s := _suggestion(at.point, kappa, axes, k, size, sag_mm))
        ),
        notes=tuple(_notes(surface, umbilic, flat, np.sign(product[doubly]))),
    )


def _face_count(surface: DesignSurface) -> int:
    mesh = getattr(surface, "mesh", None)
    if mesh is not None:
        return len(mesh.quads) + len(mesh.triangles)
    return len(getattr(surface, "charts", ())) or 1


def _faces(surface: DesignSurface) -> tuple[Face, ...]:
    if not isinstance(surface, NurbsSurface):
        return ()
    return tuple(
        Face(k, face.name, surface.face_areas[k] / 1e6, _triple(np.ptp(surface.face_bounds(k), 0)))
        for k, face in enumerate(surface.faces)
    )


def _area(surface: DesignSurface, at: SurfacePoints) -> float:
    """Area in mm2: exact to the sampling where the surface knows it, else from its samples."""
    own = getattr(surface, "area", None)
    if own is not None:
        return float(own)
    from scipy.spatial import KDTree

    # Evenly spread points have a mean nearest distance of about 0.74 / sqrt(density).
    distance = KDTree(at.point).query(at.point, k=2)[0][:, 1]
    return float(len(at.point) * (distance.mean() / 0.74) ** 2)


def _length(loop: Array) -> float:
    return float(np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1).sum())


def _suggestion(
    point: Array, kappa: Array, axes: Array, k: int, size: float, sag: float
) -> StripSuggestion | None:
    """Strips whose rulings follow the principal direction `k` (0: larger, 1: smaller)."""
    along = float(np.percentile(np.abs(kappa[:, k]), 95))
    direction = axes[:, k]
    # The mean axis of undirected lines is the leading eigenvector of their mean projector; they
    # count by how clearly they differ, since flat and umbilic places have no directions.
    clear = np.abs(kappa[:, 0] - kappa[:, 1])
    clear = clear / clear.max() if clear.max() > 0.0 else np.ones_like(clear)
    _, vectors = np.linalg.eigh(np.einsum("k,ki,kj->ij", clear, direction, direction))
    across = vectors[:, -1] * (np.sign(vectors[np.argmax(np.abs(vectors[:, -1])), -1]) or 1.0)
    extent = float(np.ptp(point @ across))
    names = _NAMES[k], _NAMES[1 - k], _triple(across)
    if along * size < FLAT:
        return StripSuggestion(*names, along, extent, 1)
    width = math.sqrt(16.0 * sag / along)
    return StripSuggestion(*names, along, min(width, extent), max(math.ceil(extent / width), 1))


_NAMES = ("larger", "smaller")


def _notes(surface: DesignSurface, umbilic: BoolArray, flat: BoolArray, signs: Array) -> list[str]:
    notes = []
    if umbilic.mean() > 0.0:
        notes.append(
            f"the principal curvatures nearly agree on {100 * umbilic.mean():.2g} % of the area: "
            "principal strips can't keep a direction there"
        )
    if flat.mean() > 0.01:
        notes.append(f"{100 * flat.mean():.0f} % of the area is flat")
    crease = sharpest(surface)
    if crease is not None:
        notes.append(f"{crease}: no strip is smooth across, choose faces of one smooth sheet")
    if len(signs) and 0.02 < np.mean(signs > 0) < 0.98:
        notes.append("the surface is partly dome-like, partly saddle-like")
    correspondence = getattr(surface, "correspondence", None)
    if correspondence:
        notes.append(f"sections correspond by {correspondence}")
    grid = getattr(surface, "grid", None)
    if grid is not None:
        notes.append(f"a regular grid of {grid.shape[0]} x {grid.shape[1]} points")
    return notes


def _named(face: Face) -> str:
    return "" if face.name in ("", f"face {face.index}") else f" {face.name!r}"


def _strips_line(s: StripSuggestion) -> str:
    across = ", ".join(f"{x:.2f}" for x in s.across)
    return (
        f"strips     {s.strips}, up to {_metres(s.width_mm)} m wide within {SAG:g} mm, rulings "
        f"along the {s.rulings} curvature, about ({across}): "
        f'start = "principal", direction = "{s.direction}", count = {s.strips}'
    )


def _metres(length_mm: float) -> str:
    return f"{length_mm / 1000.0:.4g}"


def _triple(vector: Array) -> tuple[float, float, float]:
    x, y, z = (float(c) for c in vector)
    return x, y, z


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    return value
