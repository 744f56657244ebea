"""Flat parts nested on stock, group by group: what earlier builds found is kept and mended.

Glossary
--------
group
    Parts of one material and thickness.
chain
    Some of a large group's parts, of every strip alike, nested by themselves: chains of all groups
    are worked on side by side, and each has its share of the seconds to itself. How many chains
    there are depends on the number of parts alone, so that the layout does not depend on `jobs`.
mended
    A layout of an earlier build in which a few parts were added or taken out: the others stay
    where they are. Only where seconds limit the search; `steps` promise the layout of a first
    build.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from fabgeo.build.arguments import checked_flats, checked_jobs, checked_parts, checked_project
from fabgeo.build.cache import Cache
from fabgeo.build.flats import stocks_of
from fabgeo.build.identity import identity
from fabgeo.build.parallel import Work, results
from fabgeo.build.progress import Clock
from fabgeo.errors import PartError
from fabgeo.panels.flat import FlatPart
from fabgeo.project import Cutting, Nesting, Project
from fabgeo.sheets.nest import AT_ONCE, nest
from fabgeo.sheets.pieces import piece_of
from fabgeo.sheets.stock import Nest, Sheet, Stock
from fabgeo.structures.parts import Plate

FEW = 0.05  # share of a group's parts that may change while the others stay
LEAST_EFFORT = 10.0  # seconds are shared by numbers of parts, a few for small groups too
CHAIN = 1200  # parts of a chain at most


def nests_of(
    project: Project,
    plates: Sequence[Plate],
    flats: dict[str, FlatPart],
    clock: Clock | None = None,
    cache: Cache | None = None,
    jobs: int | None = None,
) -> list[Nest]:
    """All flat parts nested; [] where the project does not ask.

    Groups of up to `AT_ONCE` parts use all cores one after the other; larger ones are divided
    into chains for `jobs` processes.

    Raises
    ------
    InputError
        Naming the argument that is something else, or what no stock is large enough for.
    """
    project, jobs = checked_project(project), checked_jobs(jobs)
    plates, flats = checked_parts("plates", plates, Plate), checked_flats(flats)
    asked, store, clock = project.nesting, cache or Cache(), clock or Clock()
    if asked is None:
        return []
    stocks = stocks_of(project, plates)
    groups: dict[tuple[str, float], list[FlatPart]] = {}
    for part in flats.values():
        groups.setdefault((part.material, part.thickness), []).append(part)
    effort = sum(LEAST_EFFORT + len(parts) for parts in groups.values())
    asking = []
    for (material, thickness), parts in sorted(groups.items(), key=lambda item: item[0]):
        own = [s for s in stocks if (s.material, s.thickness) == (material, thickness)]
        share = asked.seconds * (LEAST_EFFORT + len(parts)) / effort
        asking.append(_Group(asked, own, parts, share, project.cutting))
    found = [group.found(store, clock, jobs) for group in asking]
    new = [group for group, known in zip(asking, found, strict=True) if known is None]
    made = iter(_nested([group.chains() for group in new], jobs, clock))
    nests = []
    for group, known in zip(asking, found, strict=True):
        nests.append(known if known is not None else group.kept(next(made), store))
    return nests


@dataclass(frozen=True)
class _Chain:
    """Parts that are nested by themselves, as `nest` takes them."""

    parts: tuple[FlatPart, ...]
    stocks: tuple[Stock, ...]
    settings: Mapping[str, Any]

    def solve(self) -> Nest:
        (made,) = nest(self.parts, self.stocks, **self.settings)
        return made


def _nested(groups: Sequence[Sequence[_Chain]], jobs: int | None, clock: Clock) -> list[Nest]:
    """One nest a group: chains side by side, longest first, then groups that are one chain."""
    longest = sorted(
        (chain for chains in groups if len(chains) > 1 for chain in chains),
        key=lambda chain: -len(chain.parts),
    )
    work = Work("chain", _Chain.solve, lambda chain: len(chain.parts), _crashed)
    made = {}
    for chain, own in zip(longest, results(work, longest, jobs), strict=True):
        clock.tell(f"{own.material} {own.thickness:g} mm: {len(own.sheets)} sheets")
        made[id(chain)] = own
    for chains in groups:
        if len(chains) == 1:
            settings = {**chains[0].settings, "listener": clock.tell, "jobs": jobs}
            made[id(chains[0])] = replace(chains[0], settings=settings).solve()
    return [_joined([made[id(chain)] for chain in chains]) for chains in groups]


def _crashed(chain: _Chain, reason: str) -> Nest:
    first = chain.parts[0]
    where = f"nest {first.material} {first.thickness:g} mm"
    raise PartError(where, f"could not be laid out: {reason}", "please report it")


def _joined(nests: Sequence[Nest]) -> Nest:
    """Nests of one group's chains as one."""
    if len(nests) == 1:
        return nests[0]
    sheets = [sheet for one in nests for sheet in one.sheets]
    unplaced = {mark: reason for one in nests for mark, reason in one.unplaced.items()}
    return _renamed(replace(nests[0], unplaced=unplaced), sheets)


def _renamed(layout: Nest, sheets: Sequence[Sheet]) -> Nest:
    """The layout with these sheets, numbered, and what they are used by."""
    bought = sum(s.stock.length * s.stock.width for s in sheets)
    used = sum(s.utilisation * s.stock.length * s.stock.width for s in sheets)
    named = [replace(s, name=f"SHEET-{k:03d}") for k, s in enumerate(sheets, 1)]
    return replace(layout, sheets=tuple(named), utilisation=used / bought if bought else 0.0)


class _Group:
    """Parts of one material and thickness, their stock and their share of the seconds."""

    def __init__(
        self,
        asked: Nesting,
        stocks: list[Stock],
        parts: list[FlatPart],
        seconds: float,
        cutting: Cutting,
    ) -> None:
        self.asked, self.stocks, self.parts = asked, stocks, parts
        self.seconds, self.tolerance = seconds, cutting.tolerance
        # Splines are cut as they are; what is nested are arcs that may lie off them.
        self.off = cutting.tolerance if cutting.curves == "splines" else 0.0
        self.shapes = {part.mark: identity(part) for part in parts}
        first = parts[0]
        rules = asked.model_dump(exclude={"seconds"})
        self.rules = (first.material, first.thickness, rules, self.tolerance, self.off, stocks)
        self._mine = (self.rules, asked.seconds, list(self.shapes.items()))

    def found(self, cache: Cache, clock: Clock, jobs: int | None = None) -> Nest | None:
        """The layout of an earlier build, of the same parts or mended."""
        known = cache.get("nest", cache.key("nest", *self._mine))
        latest = cache.get("latest", cache.key("latest", self.rules))  # in use: kept
        if known is not None:
            return known
        mended = self._mended(latest, clock, jobs)
        return None if mended is None else self.kept(mended, cache)

    def kept(self, layout: Nest, cache: Cache) -> Nest:
        """The layout, left for the next build."""
        cache.put("nest", cache.key("nest", *self._mine), layout)
        latest = {"nest": layout, "shapes": self.shapes}
        cache.put("latest", cache.key("latest", self.rules), latest)
        return layout

    def chains(self) -> list[_Chain]:
        """The group's parts in as few chains as are nested side by side; one, where it is small.

        Stock that can run out is shared by no two chains.
        """
        many = len(self.parts) > AT_ONCE and all(s.quantity is None for s in self.stocks)
        count = max(2, -(-len(self.parts) // CHAIN)) if many else 1
        return [self._chain(self.parts[k::count], self.stocks) for k in range(count)]

    def _chain(self, parts: Sequence[FlatPart], stocks: Sequence[Stock]) -> _Chain:
        asked = self.asked
        settings = {
            "spacing": asked.spacing + 2.0 * self.off,
            "margin": asked.margin + self.off,
            "seconds": self.seconds * len(parts) / len(self.parts),
            "seed": asked.seed,
            "steps": asked.steps,
            "tolerance": self.tolerance,
            "jobs": 1,
        }
        return _Chain(tuple(parts), tuple(stocks), settings)

    def _mended(self, before: Any, clock: Clock, jobs: int | None) -> Nest | None:
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
            (rest,) = _nested([[self._chain(new, _left(self.stocks, sheets))]], jobs, clock)
            sheets += rest.sheets
            unplaced |= rest.unplaced
        return _renamed(replace(layout, unplaced=unplaced), sheets)

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
