"""Placements fitted with an eye on the neighbours as they will be made.

Every panel of a sweep is fitted to its own patch and, at its joints, to where its neighbours are:
to their made boundary points, and to their normals turned back by the fitted model's own kink.
Distances and angles count in units of their limits, and a high norm presses the largest down, so
that a residual below one is a kept limit. Panels of one colour have no joint in common: they are
fitted at once, against the others as they stand.
"""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array, BoolArray, IntArray, cross, unit
from fabgeo.panels.candidates import targets_of
from fabgeo.panels.carrier import Carriers
from fabgeo.panels.fit_shape import Targets, fit
from fabgeo.panels.joints import Joints, made_boundary, turned
from fabgeo.panels.limits import Tolerances
from fabgeo.panels.pool import CLASSES
from fabgeo.panels.radii import nearest
from fabgeo.panels.samples import Samples

_AT = np.array([0, 4, 8])  # of the joints' nine samples


class Coordination:
    """What a sweep needs to know about the panels and their joints.

    Parameters
    ----------
    samples, joints, tolerances
        The panels' samples, their joints and the limits.

    Attributes
    ----------
    radii : (n,) array
        The radii that cylinders may have, mm; none: any.
    """

    def __init__(self, samples: Samples, joints: Joints, tolerances: Tolerances) -> None:
        self.samples, self.joints, self.tolerances = samples.thinned(), joints, tolerances
        self.size = samples.size
        self.radii: Array = np.zeros(0)
        self.own = joints.own
        self.colour = _colours(len(samples), joints)
        touching: list[list[tuple[int, int]]] = [[] for _ in range(len(samples))]
        for j, (a, b) in enumerate(joints.panels):
            touching[a].append((j, 0))
            touching[b].append((j, 1))
        width = max((len(t) for t in touching), default=0)
        self.joint = np.full((len(samples), width), -1, dtype=np.int64)
        self.side = np.zeros((len(samples), width), dtype=np.int64)
        for p, found in enumerate(touching):
            for n, (j, s) in enumerate(found):
                self.joint[p, n], self.side[p, n] = j, s

    def sweep(self, carriers: Carriers, kind: IntArray, refit: BoolArray) -> Carriers:
        """Refit the panels in `refit`, colour by colour, each in its class `kind`.

        Panels whose kind is the last of CLASSES stay as fitted and hold their neighbours there.
        """
        last = len(CLASSES) - 1
        for colour in range(int(self.colour.max()) + 1):
            for k in range(last):
                index = np.flatnonzero((self.colour == colour) & refit & (kind == k))
                if len(index):
                    carriers = self._replace(carriers, self.fitted(index, k, carriers, kind), index)
        return carriers

    def fitted(
        self,
        index: IntArray,
        k: int,
        guess: Carriers,
        kind: IntArray,
        carriers: Carriers | None = None,
    ) -> Carriers:
        """Carriers of class k for some panels against their neighbours as they stand.

        Parameters
        ----------
        index : (n,) int array
            The panels.
        guess : Carriers
            Starts, one a panel of all.
        kind, carriers
            Where every panel stands (carriers: as `guess` where not given).
        """
        stand = guess if carriers is None else carriers
        targets = self._targets(index, stand, kind)
        name = CLASSES[k]
        guess, moves = guess[index].as_class(name), name
        if name == "cylinder" and len(self.radii):
            near = nearest(guess.k, self.radii)
            guess, moves = Carriers(guess.origin, guess.frame, near, guess.g), "rolled"
        return fit(targets, guess, moves, self.size[index], powers=(2.0, 12.0), steps=8)

    def _targets(self, index: IntArray, carriers: Carriers, kind: IntArray) -> Targets:
        limits = self.tolerances
        own = targets_of(
            self.samples[index], limits.deviation_mm, limits.flange, None, np.zeros((1, 1))
        )
        joint, side = self.joint[index], self.side[index]
        there = joint >= 0
        j, s = np.where(there, joint, 0).ravel(), side.ravel()
        neighbour = self.joints.panels[j, 1 - s]
        points, normals = made_boundary(
            carriers[neighbour],
            kind[neighbour] != len(CLASSES) - 1,
            self.joints.points[j],
            self.joints.normals[1 - s, j],
            self.joints.ends[j],
        )
        # The neighbour's normal turned back by the own kink is what this panel's should be.
        back = np.where(s == 0, -1.0, 1.0)[:, None, None] * self.own[j]
        wanted = turned(normals, back)
        fitted = self.joints.normals[s, j]
        along = _across(self.joints.points[j], fitted)
        shape = (len(index), -1)
        ruling = unit(points[:, -1] - points[:, 0])  # of the neighbour's end, where it is one
        length = np.linalg.norm(self.joints.points[j][:, -1] - self.joints.points[j][:, 0], axis=-1)
        half = length.reshape(shape) / 2.0
        absent = np.repeat(~there.ravel(), len(_AT)).reshape(shape)

        def flat(array: Array) -> Array:
            return array[:, _AT].reshape(*shape, 3)

        return Targets(
            np.concatenate([own.points, flat(points)], axis=1),
            np.concatenate([own.unit, np.where(absent, 1e9, limits.gap_mm)], axis=1),
            flat(self.joints.points[j]),
            flat(along),
            np.einsum("psi,psi->ps", flat(wanted), flat(along)),
            np.where(absent, 1e9, limits.kink),
            self.joints.points[j][:, 4].reshape(*shape, 3),
            along[:, 4].reshape(*shape, 3),
            np.einsum("ji,ji->j", ruling, along[:, 4]).reshape(shape),
            np.where(there & self.joints.ends[j].reshape(shape), limits.gap_mm / half, 1e9),
        )

    @staticmethod
    def _replace(carriers: Carriers, values: Carriers, index: IntArray) -> Carriers:
        into = [np.array(getattr(carriers, n)) for n in ("origin", "frame", "k", "g")]
        for array, n in zip(into, ("origin", "frame", "k", "g"), strict=True):
            array[index] = getattr(values, n)
        return Carriers(*into)


def _across(points: Array, normals: Array) -> Array:
    """Unit directions across joints within the panel, (j, s, 3)."""
    along = np.gradient(points, axis=1)
    return unit(cross(normals, along))


def _colours(count: int, joints: Joints) -> IntArray:
    """Colours of panels, different across every joint (greedy)."""
    neighbours: list[set[int]] = [set() for _ in range(count)]
    for a, b in joints.panels:
        if a != b:
            neighbours[a].add(int(b))
            neighbours[b].add(int(a))
    colour = np.full(count, -1, dtype=np.int64)
    for p in range(count):
        taken = {int(colour[q]) for q in neighbours[p]}
        colour[p] = next(c for c in range(count) if c not in taken)
    return colour
