"""Planar parallel sections, such as floor slabs, and the smooth surface through them.

Glossary
--------
section
    A planar curve given by points on it; all sections lie in parallel planes.
correspondence
    Which points of neighbouring sections belong together. Where all sections are strictly convex:
    those with parallel tangents (paper section 1: developable strips between two sections join
    just those). Elsewhere: equal parts of the arc length.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fabgeo.arrays import Array, checked, dot, unit
from fabgeo.errors import InputError
from fabgeo.surfaces.sectioncurve import DENSE, SectionCurve, plane_axes

PLANE_TOLERANCE = 1e-4  # of the section's size
PARALLEL_TOLERANCE = np.radians(0.5)


@dataclass(frozen=True, eq=False)
class Sections:
    """Planar curves in parallel planes, sorted by height (`checked_sections` makes them).

    Attributes
    ----------
    points : tuple of (k, 3) arrays
        Points of each section, turned the same way; closed ones don't repeat the first point.
    closed : bool
    normal : (3,) array
        Common unit normal of the planes.
    heights : (s,) array
        Positions of the planes along the normal, rising.
    names : tuple of str
    """

    points: tuple[Array, ...]
    closed: bool
    normal: Array
    heights: Array
    names: tuple[str, ...]

    @cached_property
    def curves(self) -> tuple[SectionCurve, ...]:
        """The smooth curve through each section's points."""
        return tuple(SectionCurve(p, self.closed, self.normal) for p in self.points)

    @cached_property
    def convex(self) -> bool:
        """Whether every section is strictly convex, so that parallel tangents correspond."""
        return all(c.convex for c in self.curves) and self._same_turn()

    def _same_turn(self) -> bool:
        """Open sections: whether all begin and end with about the same tangents (5 degrees)."""
        if self.closed:
            return True
        ends = np.array([[c.angle[0], c.angle[-1]] for c in self.curves])
        return bool(np.ptp(ends, axis=0).max() < np.radians(5.0))

    def grid(self, columns: int) -> Array:
        """Corresponding points (sections, columns, 3), evenly spread in the mean.

        Closed sections: the first column isn't repeated.
        """
        t = np.arange(columns) / columns if self.closed else np.linspace(0.0, 1.0, columns)
        if not self.convex:
            return np.stack(
                [c.at_length(t + s) for c, s in zip(self.curves, self._shifts(), strict=True)]
            )
        if self.closed:
            angle = np.linspace(0.0, 2.0 * np.pi, DENSE + 1)
            length = np.stack([c.length_at(angle) for c in self.curves])
            length = length - length[:, :1]
            theta = np.interp(t, length.mean(axis=0), angle)
            return np.stack([c.at_length(c.length_at(theta)) for c in self.curves])
        # Open: the turn of each section, scaled so that the ends correspond exactly.
        part = np.linspace(0.0, 1.0, DENSE + 1)
        length = np.stack(
            [c.length_at(c.angle[0] + part * (c.angle[-1] - c.angle[0])) for c in self.curves]
        )
        share = np.interp(t, length.mean(axis=0), part)
        rows = [np.interp(share, part, row) for row in length]
        return np.stack([c.at_length(r) for c, r in zip(self.curves, rows, strict=True)])

    def _shifts(self) -> list[float]:
        """Start of each closed section in parts of its length: closest to the one before."""
        if not self.closed:
            return [0.0] * len(self.curves)
        shifts = [0.0]
        k = 256
        t = np.arange(k) / k
        for before, after in zip(self.curves, self.curves[1:], strict=False):
            a, b = before.at_length(t + shifts[-1]), after.at_length(t)
            a, b = a - a.mean(axis=0), b - b.mean(axis=0)
            match = sum(
                np.fft.ifft(np.conj(np.fft.fft(a[:, j])) * np.fft.fft(b[:, j])).real
                for j in range(3)
            )
            shifts.append(float(np.argmax(match)) / k)
        return shifts


def checked_sections(
    name: str,
    curves: Sequence[Array],
    names: Sequence[str] | None = None,
    closed: bool | None = None,
) -> Sections:
    """Sections from points, checked and turned the same way.

    Parameters
    ----------
    curves : sequence of (k, 3) arrays
    closed : bool, optional
        Default: a section closes if its end is no farther from its start than 1.5 times its
        longest step.

    Raises
    ------
    InputError
        If there are fewer than two, one isn't planar, crosses itself or has too few points, two
        planes aren't parallel or coincide, or some are closed and others open.
    """
    labels = tuple(names) if names is not None else tuple(str(i) for i in range(len(curves)))
    if len(curves) < 2:
        raise InputError(
            name, f"expected two sections or more, found {len(curves)}", "add the other floors"
        )
    lines = [
        checked(f"{name}, section {s}", c, (None, 3)) for s, c in zip(labels, curves, strict=True)
    ]
    lines = [
        _without_repeats(f"{name}, section {s}", c) for s, c in zip(labels, lines, strict=True)
    ]
    shut = [_is_closed(c) for c in lines] if closed is None else [closed] * len(lines)
    if len(set(shut)) > 1:
        odd = labels[shut.index(not shut[0])]
        raise InputError(
            name,
            f"section {odd} is {'closed' if not shut[0] else 'open'}, section {labels[0]} is not",
            "make all sections open or all closed",
        )
    if shut[0]:
        lines = [c[:-1] if _same(c[0], c[-1], c) else c for c in lines]
    least = 4 if shut[0] else 2
    for label, line in zip(labels, lines, strict=True):
        if len(line) < least:
            raise InputError(
                f"{name}, section {label}", f"needs {least} points or more, found {len(line)}"
            )
    normal = _common_normal(name, labels, lines)
    heights = np.array([float(dot(line, normal).mean()) for line in lines])
    order = np.argsort(heights, kind="stable")
    heights = heights[order]
    size = float(np.linalg.norm(np.ptp(np.concatenate(lines), axis=0)))
    for k in np.flatnonzero(np.diff(heights) < 1e-6 * size):
        pair = labels[order[k]], labels[order[k + 1]]
        raise InputError(
            name, f"sections {pair[0]} and {pair[1]} lie in one plane", "keep one of them"
        )
    sections = Sections(
        tuple(lines[i] for i in order), shut[0], normal, heights, tuple(labels[i] for i in order)
    )
    for label, line in zip(sections.names, sections.points, strict=True):
        _check_simple(f"{name}, section {label}", line, sections)
    return replace(sections, points=tuple(_turned(sections)))


def _same(a: Array, b: Array, line: Array) -> bool:
    return bool(np.linalg.norm(a - b) <= 1e-9 * np.linalg.norm(np.ptp(line, axis=0)))


def _without_repeats(where: str, line: Array) -> Array:
    if len(line) < 2:
        raise InputError(where, f"needs two points or more, found {len(line)}")
    size = float(np.linalg.norm(np.ptp(line, axis=0)))
    step = np.linalg.norm(np.diff(line, axis=0), axis=1)
    return line[np.concatenate([[True], step > 1e-9 * size])]


def _is_closed(line: Array) -> bool:
    if len(line) < 4:
        return False
    step = np.linalg.norm(np.diff(line, axis=0), axis=1).max()
    return bool(np.linalg.norm(line[-1] - line[0]) <= 1.5 * step)


def _common_normal(name: str, labels: Sequence[str], lines: Sequence[Array]) -> Array:
    """Unit normal of all planes, upwards; straight sections take it from the others."""
    found: list[tuple[str, Array]] = []
    for label, line in zip(labels, lines, strict=True):
        _, spread, axes = np.linalg.svd(line - line.mean(axis=0), full_matrices=True)
        off = float(np.abs((line - line.mean(axis=0)) @ axes[2]).max())
        size = float(np.linalg.norm(np.ptp(line, axis=0)))
        if len(line) < 3 or spread[1] < 1e-6 * spread[0]:
            continue  # straight: no plane of its own
        if off > PLANE_TOLERANCE * size:
            raise InputError(
                f"{name}, section {label}",
                f"is not planar: points lie up to {off:.4g} off its plane",
                "project the section to its plane",
            )
        found.append((label, axes[2]))
    if not found:
        raise InputError(name, "every section is straight: their planes are not determined")
    normal = found[0][1]
    for label, other in found:
        angle = float(np.arccos(np.clip(abs(normal @ other), 0.0, 1.0)))
        if angle > PARALLEL_TOLERANCE:
            raise InputError(
                name,
                f"the planes of sections {found[0][0]} and {label} are {np.degrees(angle):.2f} "
                "degrees apart; expected parallel planes",
                "cut all sections with parallel planes",
            )
    mean = unit(np.sum([n * np.sign(n @ normal) for _, n in found], axis=0))
    if np.abs(mean).max() > 1.0 - 1e-9:
        mean = np.round(mean)  # exactly along an axis, as floors are
    return mean * (np.sign(mean[np.argmax(np.abs(mean))]) or 1.0)


def _check_simple(where: str, line: Array, sections: Sections) -> None:
    import shapely

    e1, e2 = plane_axes(sections.normal)
    flat = np.stack([line @ e1, line @ e2], axis=1)
    curve = shapely.LinearRing(flat) if sections.closed else shapely.LineString(flat)
    if not curve.is_simple:
        raise InputError(where, "crosses itself", "order its points along the outline")


def _turned(sections: Sections) -> list[Array]:
    """Closed sections counterclockwise about the normal, open ones along the first."""
    e1, e2 = plane_axes(sections.normal)
    turned = []
    for line in sections.points:
        if sections.closed:
            x, y = line @ e1, line @ e2
            x, y = x - x[0], y - y[0]
            forward = float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) > 0.0
        else:
            first = turned[-1] if turned else line
            straight = np.linalg.norm(line[0] - first[0]) + np.linalg.norm(line[-1] - first[-1])
            swapped = np.linalg.norm(line[0] - first[-1]) + np.linalg.norm(line[-1] - first[0])
            forward = straight <= swapped
        turned.append(line if forward else line[::-1].copy())
    return turned
