"""Flat parts nested on stock, group by group: what earlier builds found is kept and mended.

Glossary
--------
group
    Parts of one material and thickness.
mended
    A layout of an earlier build in which a few parts were added or taken out: the others stay
    where they are. Only where seconds limit the search; `steps` promise the layout of a first
    build.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from fabgeo.build.cache import Cache
from fabgeo.build.flats import stocks_of
from fabgeo.build.plain import digest
from fabgeo.build.progress import Clock
from fabgeo.panels.flat import FlatPart
from fabgeo.project import Nesting, Project
from fabgeo.sheets.nest import nest
from fabgeo.sheets.pieces import piece_of
from fabgeo.sheets.stock import Nest, Sheet, Stock
from fabgeo.structures.parts import Plate

FEW = 0.05  # share of a group's parts that may change while the others stay
LEAST_EFFORT = 10.0  # seconds are shared by numbers of parts, a few for small groups too


def nests_of(
    project: Project,
    plates: Sequence[Plate],
    flats: dict[str, FlatPart],
    clock: Clock | None = None,
    cache: Cache | None = None,
) -> list[Nest]:
    """All flat parts nested; [] where the project does not ask."""
    asked, store, clock = project.nesting, cache or Cache(), clock or Clock()
    if asked is None:
        return []
    stocks = stocks_of(project, plates)
    groups: dict[tuple[str, float], list[FlatPart]] = {}
    for part in flats.values():
        groups.setdefault((part.material, part.thickness), []).append(part)
    effort = sum(LEAST_EFFORT + len(parts) for parts in groups.values())
    nests = []
    for (material, thickness), parts in sorted(groups.items(), key=lambda item: item[0]):
        own = [s for s in stocks if (s.material, s.thickness) == (material, thickness)]
        share = asked.seconds * (LEAST_EFFORT + len(parts)) / effort
        group = _Group(asked, own, parts, share, project.cutting.tolerance)
        nests.append(group.solve(store, clock))
    return nests


class _Group:
    """Parts of one material and thickness, their stock and their share of the seconds."""

    def __init__(
        self,
        asked: Nesting,
        stocks: list[Stock],
        parts: list[FlatPart],
        seconds: float,
        tolerance: float,
    ) -> None:
        self.asked, self.stocks, self.parts = asked, stocks, parts
        self.seconds, self.tolerance = seconds, tolerance
        self.shapes = {part.mark: digest(part) for part in parts}
        first = parts[0]
        rules = asked.model_dump(exclude={"seconds"})
        self.rules = (first.material, first.thickness, rules, tolerance, stocks)

    def solve(self, cache: Cache, clock: Clock) -> Nest:
        key = cache.key("nest", self.rules, self.asked.seconds, list(self.shapes.items()))
        latest = cache.key("latest", self.rules)
        found = cache.get("nest", key)
        if found is None:
            found = self._mended(cache.get("latest", latest), clock)
            found = self._nested(self.parts, self.stocks, clock) if found is None else found
            cache.put("nest", key, found)
            cache.put("latest", latest, {"nest": found, "shapes": self.shapes})
        else:
            cache.get("latest", latest)  # in use: kept
        return found

    def _nested(self, parts: list[FlatPart], stocks: list[Stock], clock: Clock) -> Nest:
        asked = self.asked
        (made,) = nest(
            parts,
            stocks,
            spacing=asked.spacing,
            margin=asked.margin,
            seconds=self.seconds * len(parts) / len(self.parts),
            seed=asked.seed,
            steps=asked.steps,
            listener=clock.tell,
            tolerance=self.tolerance,
        )
        return made

    def _mended(self, before: Any, clock: Clock) -> Nest | None:
        """The latest layout with what changed taken out and laid anew on sheets of its own."""
        if before is None or self.asked.steps is not None:
            return None
        old: dict[str, str] = before["shapes"]
        new = [part for part in self.parts if old.get(part.mark) != self.shapes[part.mark]]
        gone = [mark for mark in old if self.shapes.get(mark) != old[mark]]
        if max(len(new), len(gone)) > FEW * len(self.parts):
            return None
        layout: Nest = before["nest"]
        if any(mark in layout.unplaced for mark in gone):
            return None
        sheets = [self._without(sheet, set(gone)) for sheet in layout.sheets]
        sheets = [sheet for sheet in sheets if sheet.placements]
        unplaced = dict(layout.unplaced)
        if new:
            rest = self._nested(new, _left(self.stocks, sheets), clock)
            sheets += rest.sheets
            unplaced |= rest.unplaced
        bought = sum(s.stock.length * s.stock.width for s in sheets)
        used = sum(s.utilisation * s.stock.length * s.stock.width for s in sheets)
        named = [replace(s, name=f"SHEET-{k:03d}") for k, s in enumerate(sheets, 1)]
        share = used / bought if bought else 0.0
        return replace(layout, sheets=tuple(named), unplaced=unplaced, utilisation=share)

    def _without(self, sheet: Sheet, gone: set[str]) -> Sheet:
        kept = tuple(p for p in sheet.placements if p.mark not in gone)
        if len(kept) == len(sheet.placements):
            return sheet
        parts = {part.mark: part for part in self.parts}
        area = sum(piece_of(parts[p.mark], self.tolerance).area for p in kept)
        size = sheet.stock.length * sheet.stock.width
        return replace(sheet, placements=kept, utilisation=area / size)


def _left(stocks: list[Stock], sheets: list[Sheet]) -> list[Stock]:
    """Stock that the sheets leave."""
    out = []
    for stock in stocks:
        used = sum(sheet.stock.name == stock.name for sheet in sheets)
        if stock.quantity is None:
            out.append(stock)
        elif stock.quantity > used:
            out.append(replace(stock, quantity=stock.quantity - used))
    return out
