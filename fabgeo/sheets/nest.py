"""Nesting of flat parts on stock: one interface, several engines, every layout verified.

Glossary
--------
group
    Parts of one material and thickness: nested by themselves.
layout
    Sheets with placements as an engine proposes them; a nest is a layout that passed the check.
steps
    Instead of seconds: a fixed number of tries, the same layout every time for the same seed.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from fabgeo.errors import InputError, PartError
from fabgeo.panels.flat import FlatPart
from fabgeo.sheets.batches import batched
from fabgeo.sheets.cover import Cover
from fabgeo.sheets.loop import knapsack_loop
from fabgeo.sheets.pieces import Piece, piece_of
from fabgeo.sheets.shelf import Layout, fits, shelves
from fabgeo.sheets.stock import Nest, Sheet, Stock, remaining
from fabgeo.sheets.verify import check_nest, check_sheet

type Rotations = tuple[float, ...] | str | None
type Listener = Callable[[str], None]

AT_ONCE = 300  # pieces that are laid out together; more go in batches
SLOWLY = 40  # pieces that the slower engine also lays out where steps are given
CLOSING = 2.0  # times the rows' check: sheet by sheet and in all, when time is up
LEAST_SECONDS = 1.0  # an engine needs this long to be of use


@dataclass(frozen=True)
class Rules:
    """What a layout of one group must keep."""

    stocks: tuple[Stock, ...]
    spacing: float
    margin: float


def nest(
    parts: Sequence[FlatPart],
    stocks: Sequence[Stock],
    spacing: float = 6.0,
    margin: float = 10.0,
    rotations: Rotations = None,
    seconds: float = 60.0,
    seed: int = 0,
    steps: int | None = None,
    listener: Listener | None = None,
    quantities: Mapping[str, int] | None = None,
    tolerance: float = 0.05,
    jobs: int | None = None,
) -> list[Nest]:
    """Nest all parts, by material and thickness, on the cheapest set of sheets found.

    Parameters
    ----------
    parts : sequence of FlatPart
    stocks : sequence of Stock
        Sheets, boards and remnants; cost None: the sheet's area. Remnants: quantity 1, cost 0.
    spacing, margin : float
        mm between parts, and between parts and the sheet's edge.
    rotations : tuple of float, "free" or None
        Allowed rotations in radians for all parts; None: by each part's grain.
    seconds : float
        Wall clock of the engines for all groups together (fitting the contours comes before).
    seed : int
        Of the random candidates.
    steps : int, optional
        Tries a sheet instead of seconds: reproducible.
    listener : callable, optional
        Told in words whenever a group's layout improves.
    quantities : mapping, optional
        How many of each mark; 1 where missing.
    tolerance : float
        mm, of contours that have to be fitted first.
    jobs : int, optional
        Processes, where seconds are given; one for each core otherwise.

    Returns
    -------
    list of Nest
        One a group, sorted by material and thickness. Parts that fit nothing are named in
        `unplaced` with the reason; all the others are placed: rows of boxes are the fallback.

    Raises
    ------
    InputError
        If marks repeat or a size is negative.
    """
    _checked(parts, spacing, margin)
    groups = _grouped(parts, quantities or {}, tolerance, rotations)
    nests, end = [], time.monotonic() + seconds
    waiting = sum(_effort(pieces) for pieces in groups.values())
    for (material, thickness), pieces in sorted(groups.items(), key=lambda item: item[0]):
        budget = max(0.0, end - time.monotonic()) * _effort(pieces) / waiting
        waiting -= _effort(pieces)
        own = tuple(s for s in stocks if (s.material, s.thickness) == (material, thickness))
        rules, say = Rules(own, spacing, margin), listener or (lambda _: None)
        group = _Group(material, thickness, pieces, rules, say, jobs)
        nests.append(group.solve(budget, seed, steps))
    return nests


def _grouped(
    parts: Sequence[FlatPart],
    quantities: Mapping[str, int],
    tolerance: float,
    rotations: Rotations,
) -> dict[tuple[str, float], list[Piece]]:
    """Pieces by material and thickness, each as often as it is asked for."""
    groups: dict[tuple[str, float], list[Piece]] = {}
    for part in parts:
        made = [piece_of(part, tolerance, rotations)] * quantities.get(part.mark, 1)
        groups.setdefault((part.material, part.thickness), []).extend(made)
    return groups


class _Group:
    def __init__(
        self,
        material: str,
        thickness: float,
        pieces: list[Piece],
        rules: Rules,
        say: Listener,
        jobs: int | None,
    ) -> None:
        self.material, self.thickness, self.jobs = material, thickness, jobs
        self.pieces, self.rules, self.say = pieces, rules, say
        self.contours = {piece.mark: piece.contour for piece in pieces}
        self.rotations = {piece.mark: piece.rotations for piece in pieces}
        self.areas = {piece.mark: piece.area for piece in pieces}
        self.quantities: dict[str, int] = {}
        for piece in pieces:
            self.quantities[piece.mark] = self.quantities.get(piece.mark, 0) + 1

    def solve(self, seconds: float, seed: int, steps: int | None) -> Nest:
        end = time.monotonic() + seconds
        rules = self.rules
        layout, unplaced = shelves(self.pieces, rules.stocks, rules.spacing, rules.margin)
        best = self._nest(layout, unplaced)
        checking = time.monotonic()
        problems = self._problems(best)
        end -= CLOSING * (time.monotonic() - checking)
        if problems:
            raise PartError(f"nest {self._name}", f"rows of boxes fail the check: {problems[0]}")
        self.say(f"{self._name}: {len(best.sheets)} sheets in rows")
        movable = [p for p in self.pieces if any(fits(p, s, rules.margin) for s in rules.stocks)]
        if len(rules.stocks) > 1:  # the cheapest sheet for each part is not the cheapest for all
            for stock in rules.stocks:
                best = self._better(best, shelves(movable, [stock], rules.spacing, rules.margin)[0])
        if not movable or (steps is None and seconds < LEAST_SECONDS):
            return best
        for layout in self._engines(movable, end, seed, steps):
            best = self._better(best, layout)
        return best

    def _engines(
        self, pieces: list[Piece], end: float, seed: int, steps: int | None
    ) -> Iterator[Layout]:
        """Layouts of the engines that suit the group, as long as there is time."""
        rules = self.rules
        if len(pieces) > AT_ONCE:
            yield batched(pieces, rules, end, seed, steps)
            return
        cover = Cover(pieces, rules, end, seed, steps, self.jobs)
        if steps is not None and len(pieces) <= SLOWLY:
            found = knapsack_loop(pieces, rules, end, seed, steps, self.sound)
            yield found
            cover.add(found)
        for layout in cover.layouts():
            yield layout
            if self._at_best(pieces, layout):
                return

    def _at_best(self, pieces: list[Piece], layout: Layout) -> bool:
        """Whether no layout on its one stock can have fewer sheets: their area tells."""
        rules = self.rules
        stock, *others = rules.stocks
        if others or sum(len(placed) for _, placed in layout) < len(pieces):
            return False
        room = (stock.length - 2 * rules.margin) * (stock.width - 2 * rules.margin)
        return len(layout) <= math.ceil(sum(piece.area for piece in pieces) / room)

    def sound(self, stock: Stock, placements: list) -> bool:
        sheet = Sheet("", stock, tuple(placements), 0.0)
        return not check_sheet(sheet, self.contours, self.rules.spacing, self.rules.margin)

    def _better(self, best: Nest, layout: Layout) -> Nest:
        """The layout completed, if it is sound and cheaper."""
        price = sum(_bought(stock) for stock, _ in layout)
        if not layout or (not best.unplaced and price >= _cost(best)):
            return best
        made = self._completed(layout)
        problems = self._problems(made)
        if problems:
            self.say(f"{self._name}: a layout was rejected: {problems[0]}")
            return best
        if (len(made.unplaced), _cost(made)) < (len(best.unplaced), _cost(best)):
            self.say(f"{self._name}: {len(made.sheets)} sheets, {100 * made.utilisation:.1f} %")
            return made
        return best

    def _completed(self, layout: Layout) -> Nest:
        """Unsound sheets are taken apart; what is not placed goes into rows of boxes."""
        sound = [
            (stock, placed) for stock, placed in layout if placed and self.sound(stock, placed)
        ]
        left = dict(self.quantities)
        for _, placed in sound:
            for placement in placed:
                left[placement.mark] -= 1
        rest = []
        for piece in self.pieces:
            if left[piece.mark] > 0:
                left[piece.mark] -= 1
                rest.append(piece)
        rows, unplaced = shelves(
            rest, remaining(self.rules.stocks, sound), self.rules.spacing, self.rules.margin
        )
        return self._nest(sound + rows, unplaced)

    def _nest(self, layout: Layout, unplaced: dict[str, str]) -> Nest:
        sheets, used, bought = [], 0.0, 0.0
        for k, (stock, placements) in enumerate(layout, start=1):
            area = sum(self.areas[placement.mark] for placement in placements)
            size = stock.length * stock.width
            used, bought = used + area, bought + size
            sheets.append(Sheet(f"SHEET-{k:03d}", stock, tuple(placements), area / size))
        return Nest(
            self.material,
            self.thickness,
            tuple(sheets),
            unplaced,
            used / bought if bought else 0.0,
            self.rules.spacing,
            self.rules.margin,
        )

    def _problems(self, made: Nest) -> list[str]:
        return check_nest(made, self.contours, self.rotations, self.quantities)

    @property
    def _name(self) -> str:
        return f"{self.material} {self.thickness:g} mm"


def _cost(made: Nest) -> float:
    return sum(_bought(sheet.stock) for sheet in made.sheets)


def _bought(stock: Stock) -> float:
    """Its cost, else its area; a remnant may cost nothing."""
    return stock.length * stock.width if stock.cost is None else stock.cost


def _effort(pieces: Sequence[Piece]) -> float:
    return 10.0 + len(pieces)  # a few seconds for small groups too


def _checked(parts: Sequence[FlatPart], spacing: float, margin: float) -> None:
    if spacing < 0.0 or margin < 0.0:
        raise InputError("nest", f"expected spacing and margin >= 0, found {spacing}, {margin}")
    seen: set[str] = set()
    for part in parts:
        if part.mark in seen:
            raise InputError(
                f"part {part.mark}", "its mark repeats", "give each its own, or a quantity"
            )
        seen.add(part.mark)
