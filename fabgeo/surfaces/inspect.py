"""What a design surface holds, measured: faces, size, curvature, boundary, how strips could run."""

from __future__ import annotations

import math

import numpy as np

from fabgeo.arrays import Array, BoolArray
from fabgeo.surfaces.base import DesignSurface, SurfacePoints, size_of
from fabgeo.surfaces.creases import sharpest
from fabgeo.surfaces.inspection import PRINCIPALS, Face, Inspection, StripSuggestion
from fabgeo.surfaces.nurbs import NurbsSurface

SAMPLES = 4000
FLAT = 1e-3  # curvature times size below which a direction counts as straight
UMBILIC = 0.05  # difference of the principal curvatures over their size
SAG = 5.0  # mm, for the suggested strip width


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
    names = PRINCIPALS[k], PRINCIPALS[1 - k], _triple(across)
    if along * size < FLAT:
        return StripSuggestion(*names, along, extent, sag, 1)
    width = math.sqrt(16.0 * sag / along)
    strips = max(math.ceil(extent / width), 1)
    return StripSuggestion(*names, along, min(width, extent), sag, strips)


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
    copies = getattr(surface, "copies", ())
    if copies:
        named = ", ".join(face.name or "a face" for face in copies[:3])
        more = f" and {len(copies) - 3} more" if len(copies) > 3 else ""
        notes.append(f"copies of other faces are left out: {named}{more}")
    return notes


def _triple(vector: Array) -> tuple[float, float, float]:
    x, y, z = (float(c) for c in vector)
    return x, y, z
