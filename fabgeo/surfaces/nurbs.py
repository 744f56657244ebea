"""Design surfaces made of one or many trimmed (rational) B-spline faces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array
from fabgeo.errors import InputError
from fabgeo.surfaces.bspline import BSplineChart
from fabgeo.surfaces.mesh import ABSURD
from fabgeo.surfaces.parametric import ParametricSurface
from fabgeo.surfaces.trims import Trim

NO_AREA = 1e-9  # of the box around it


@dataclass(frozen=True, eq=False)
class NurbsFace:
    """One face as plain data, as a CAD reader hands it over; lengths in millimetres.

    Attributes
    ----------
    poles : (n, m, 3) array
    weights : (n, m) array or None
    knots_u, knots_v : arrays
        Flat (repeated) knots, n + degree_u + 1 and m + degree_v + 1 of them.
    degree_u, degree_v : int
    trims : tuple of (k, 2) arrays
        Closed polylines in (u, v); () for the whole patch.
    name : str
        As the file calls it, or ``face 3``.
    colour : (red, green, blue) or None
        Each 0 to 1.
    """

    poles: Array
    weights: Array | None
    knots_u: Array
    knots_v: Array
    degree_u: int
    degree_v: int
    trims: tuple[Array, ...] = ()
    name: str = ""
    colour: tuple[float, float, float] | None = None

    def same_as(self, other: NurbsFace) -> bool:
        """Whether both are one piece of surface, whatever they are called."""
        mine, theirs = self._numbers(), other._numbers()
        return len(mine) == len(theirs) and all(map(np.array_equal, mine, theirs))

    def _numbers(self) -> list[Array]:
        weights = np.ones(1) if self.weights is None else self.weights
        degrees = np.array([self.degree_u, self.degree_v])
        return [self.poles, weights, self.knots_u, self.knots_v, degrees, *self.trims]

    def chart(self) -> BSplineChart:
        """The face's patch, without its trims."""
        return BSplineChart(
            self.poles, self.knots_u, self.knots_v, self.degree_u, self.degree_v, self.weights
        )


class NurbsSurface(ParametricSurface):
    """A design surface of trimmed B-spline faces.

    Faces are turned to agree along the edges they share; `loops` holds free edges only.
    A face that is there twice is taken once: no edge of it would be free.

    Parameters
    ----------
    faces : sequence of NurbsFace
    name : str
        For messages, such as the file's name.
    tolerance : float, optional
        Borders closer than this are one edge; default 1e-5 of the size.

    Attributes
    ----------
    faces : tuple of NurbsFace
    copies : tuple of NurbsFace
        The same again, left out.
    """

    def __init__(
        self, faces: Sequence[NurbsFace], name: str = "nurbs", tolerance: float | None = None
    ) -> None:
        if not faces:
            raise InputError(name, "holds no face", "export surfaces, not curves or meshes")
        self.faces, self.copies = _once(faces)
        charts = [face.chart() for face in self.faces]
        trims = []
        for face, chart in zip(self.faces, charts, strict=True):
            where = f"{name}, {face.name or 'face'}"
            if np.abs(face.poles).max() > ABSURD:
                raise InputError(where, f"has a pole beyond {ABSURD:g} mm", "rebuild the face")
            trim = _checked_trim(where, face.trims)
            trims.append(None if trim is None or trim.is_whole(chart) else trim)
        super().__init__(name, charts, trims, tolerance)


def _once(faces: Sequence[NurbsFace]) -> tuple[tuple[NurbsFace, ...], tuple[NurbsFace, ...]]:
    """Faces that differ, and copies of them."""
    alike: dict[bytes, list[NurbsFace]] = {}
    own, copies = [], []
    for face in faces:
        others = alike.setdefault(np.asarray(face.poles, dtype=np.float64).tobytes(), [])
        if any(face.same_as(other) for other in others):
            copies.append(face)
            continue
        others.append(face)
        own.append(face)
    return tuple(own), tuple(copies)


def _checked_trim(where: str, loops: tuple[Array, ...]) -> Trim | None:
    """The loops as a trim.

    Raises
    ------
    InputError
        If a loop crosses itself, or all of them enclose nothing.
    """
    if not loops:
        return None
    import shapely

    for loop in loops:
        ring = shapely.Polygon(loop)
        if not ring.is_valid:
            why = shapely.is_valid_reason(ring)
            at = np.round(loop.mean(axis=0), 4)
            # A touch or a fold within the sampling of the curve is not a crossing.
            mended = shapely.make_valid(ring)
            least = NO_AREA * float(np.prod(np.ptp(loop, axis=0)))
            if abs(mended.area - ring.area) > 1e-3 * max(mended.area, ring.area, least):
                raise InputError(
                    where,
                    f"a trimming loop around u, v = {at.tolist()} crosses itself ({why})",
                    "repair the face in the CAD program (untrim and trim again)",
                )
    around = np.prod(np.ptp(np.concatenate(loops), axis=0))
    if max(shapely.Polygon(loop).area for loop in loops) <= NO_AREA * around:
        raise InputError(where, "its trimming loops enclose no area", "delete the face")
    return Trim(loops)
