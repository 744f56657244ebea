"""The integer choice over continuous placement of a few panels, by HiGHS.

For every panel and every option one binary y and the steps s of its placement. With the features
f and their slopes F of `fabgeo.panels.firstorder`, all in units of the limits::

    minimise  sum cost y
    where     sum over a panel's options of y = 1
              |f y + F s| <= y                           the panel's own, for every option
              |sum of f y + F s, second panel less first| <= 1      at every joint

A step is zero where its y is: the options' feasible sets are convex, and this is the convex hull
of their union (disjunctive programming), so that the solver's relaxation is tight. A panel that
stays as fitted is an option without steps whose features are zero.

With the classes decided, `fabgeo.panels.settling` makes the largest use of any limit small.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.sparse import csr_array

from fabgeo.arrays import Array, BoolArray, IntArray
from fabgeo.panels.firstorder import Option
from fabgeo.panels.highs import Programme, Solution
from fabgeo.panels.joints import Joints


@dataclass(frozen=True)
class Rim:
    """A joint between a panel of the group and one outside that does not move.

    Attributes
    ----------
    joint, side : int
        The joint, and on which side of it the group's panel is.
    features : (m,) array
        Those of the panel outside.
    """

    joint: int
    side: int
    features: Array


@dataclass(frozen=True)
class Group:
    """Some panels, the joints between them, and those to panels outside."""

    panels: IntArray
    inside: IntArray
    rims: tuple[Rim, ...] = ()


@dataclass(frozen=True)
class Decision:
    """What a group's panels are made as.

    Attributes
    ----------
    option : (n,) int array
        Index of the option; -1: as fitted.
    steps : sequence of (f,) arrays
        Steps of every panel's placement.
    """

    option: IntArray
    steps: Sequence[Array]


class Rows:
    """A sparse matrix with limits on its rows, while it grows."""

    def __init__(self) -> None:
        self._entries: list[tuple[IntArray, IntArray, Array]] = []
        self._low: list[Array] = []
        self._high: list[Array] = []
        self._count = self._first = 0

    def begin(self, low: Array, high: Array) -> None:
        """Append rows with these limits."""
        self._first = self._count
        self._low.append(low)
        self._high.append(high)
        self._count += len(low)

    def put(self, column: int, block: Array) -> None:
        """A block (rows, columns) from a column on into the rows begun last."""
        row, at = np.indices(block.shape)
        self._entries.append(((self._first + row).ravel(), (column + at).ravel(), block.ravel()))

    def matrix(self, columns: int) -> csr_array:
        """The matrix of all rows."""
        row, column, value = (np.concatenate(parts) for parts in zip(*self._entries, strict=True))
        return csr_array((value, (row, column)), shape=(self._count, columns))

    @property
    def limits(self) -> tuple[Array, Array]:
        """Lower and upper limits of all rows."""
        return np.concatenate(self._low), np.concatenate(self._high)


class Classed(Protocol):
    """A class that panels may be made as, with the steps of their placements."""

    @property
    def kind(self) -> int:
        """Index into CLASSES."""
        ...

    @property
    def able(self) -> BoolArray:
        """Whether a panel may take it, (p,)."""
        ...

    @property
    def count(self) -> int:
        """Number of steps."""
        ...


class Binaries:
    """Columns of a programme: a binary for every panel and option, the steps behind it.

    Attributes
    ----------
    column : dict
        Where the binary of a panel and an option is; option -1: as fitted.
    cost : list of float
    whole : list of bool
        Which columns are binaries.
    behind : list of int
        The binary that a column is zero without.
    """

    def __init__(self, options: Sequence[Classed], prices: Array, rows: Rows) -> None:
        self._options, self._prices, self._rows = options, prices, rows
        self.column: dict[tuple[int, int], int] = {}
        self.cost: list[float] = []
        self.whole: list[bool] = []
        self.behind: list[int] = []

    def of_panel(self, p: int) -> list[int]:
        """Append a panel's, of which exactly one is one; the options that it may take."""
        self._rows.begin(np.ones(1), np.ones(1))
        here = [k for k, option in enumerate(self._options) if option.able[p]]
        for k in [*here, -1]:
            kind, steps = (self._options[k].kind, self._options[k].count) if k >= 0 else (-1, 0)
            self.column[p, k] = len(self.cost)
            self._rows.put(len(self.cost), np.ones((1, 1)))
            self.cost += [float(self._prices[kind])] + [0.0] * steps
            self.whole += [True] + [False] * steps
            self.behind += [self.column[p, k]] * (1 + steps)
        return here


@dataclass(frozen=True)
class Choosing:
    """The programme that chooses a group's classes and placements.

    Attributes
    ----------
    programme : Programme
    column : dict
        Where the binary of a panel and an option is, its steps behind it; option -1: as fitted.
    """

    programme: Programme
    column: dict[tuple[int, int], int]

    def decision(
        self, group: Group, options: Sequence[Option], solution: Solution
    ) -> Decision | None:
        """What a solution says; None if it has no choice."""
        if solution.x is None:
            return None
        x, chosen, moves = solution.x, [], []
        for p in group.panels.tolist():
            k = max((k for q, k in self.column if q == p), key=lambda k: x[self.column[p, k]])
            at = self.column[p, k] + 1
            chosen.append(k)
            moves.append(x[at : at + options[k].count] if k >= 0 else np.zeros(0))
        return Decision(np.array(chosen), moves)


def choosing(
    group: Group,
    options: Sequence[Option],
    joints: Joints,
    prices: Array,
    share: float,
    below: float = np.inf,
    every: bool = False,
) -> Choosing:
    """The programme for the cheapest classes and placements of a group.

    Parameters
    ----------
    prices : (4,) array
        Cost by class; the last one is that of staying as fitted.
    share : float
        Share of every limit that may be used: above one for a bound that stands in spite of the
        features' curvature, below one for placements that keep the limits in spite of it.
    below : float
        Most that a choice may cost: there is none to be found where none is cheaper.
    every : bool
        Look at all features of joints, not at few.
    """
    rows = Rows()
    binaries = Binaries(options, prices, rows)
    column = binaries.column
    most: list[float] = []  # that a column can be
    for p in group.panels.tolist():
        for k in binaries.of_panel(p):
            f, slope = options[k].value[p][:, None], options[k].slope[p]
            most += [1.0, *(options[k].reach[p] * (share + np.abs(f).max()))]
            for sign in (1.0, -1.0):
                rows.begin(np.full(len(f), -np.inf), np.zeros(len(f)))
                rows.put(column[p, k], np.hstack([sign * f - share, sign * slope]))
        most.append(1.0)  # as fitted
    few = np.arange(options[0].edge[0].shape[1]) if every else options[0].few
    for offset, terms in joint_rows(group, options[0].edge[0].shape[1]):
        rows.begin(offset[few] - share, offset[few] + share)
        for j, side, sign in terms:
            p = int(joints.panels[j, side])
            for k, option in enumerate(options):
                if option.able[p]:
                    block = np.hstack([option.edge[side][j][:, None], option.edge_slope[side][j]])
                    rows.put(column[p, k], sign * block[few])
    if np.isfinite(below):
        rows.begin(np.full(1, -np.inf), np.full(1, below))
        rows.put(0, np.array(binaries.cost)[None])
    whole = np.array(binaries.whole)
    programme = Programme(
        np.array(binaries.cost),
        rows.matrix(len(binaries.cost)),
        *rows.limits,
        np.where(whole, 0.0, -np.array(most)),
        np.array(most),
        whole,
        np.array(binaries.behind),
    )
    return Choosing(programme, column)


def joint_rows(group: Group, width: int) -> Iterator[tuple[Array, list[tuple[int, int, float]]]]:
    """Offset of a joint's rows, and the sides (joint, side, sign) whose features add up to it."""
    for j in group.inside.tolist():
        yield np.zeros(width), [(j, 0, -1.0), (j, 1, 1.0)]
    for rim in group.rims:
        yield rim.features, [(rim.joint, rim.side, 1.0)]
