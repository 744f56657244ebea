"""A layout made cheaper: some sheets are given up, their pieces laid out anew, all else as it is.

Glossary
--------
gathered
    Sum over the sheets of their costs times the square of their fill. Of two layouts that cost the
    same the more gathered one has fuller and emptier sheets: the empty ones can be spared next.
hand
    Sheets of a layout dealt to one process, the pieces they hold and the stock there is for them.
deal
    All sheets dealt to the processes and, mended, put together again. No two processes work on
    the same pieces, so what each gains is gained.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from concurrent.futures import BrokenExecutor
from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array
from fabgeo.sheets.filling import LARGE, Wanted, cost_of, filled, held
from fabgeo.sheets.sheetpool import Found, SheetPool

FEW, MOST = 2, 5  # sheets given up at a time
EMPTIER = 8.0  # how much rather empty sheets are among them: exp(EMPTIER (fullest - fill))
TRIES = (12, 40)  # a sheet, of the pieces given up
GATHERED = 0.15  # worth of a gathered sheet against its cost
VAIN, VAIN_DEALS = 100, 5  # mendings and deals in a row that may gain nothing
CHOOSING = 1.0  # seconds at most of one choice
DEAL, SHORTEST, LONGEST = 0.2, 3.0, 10.0  # share of the time left, seconds of a deal
LEAST_SHEETS = 4  # of a hand
DEALT = 3000  # sheets of the pool at most that go to every process
STARTING = 8.0  # seconds: with less left it is not worth while to start processes


@dataclass(frozen=True)
class Hand:
    """Sheets that together hold what is wanted."""

    sheets: tuple[Found, ...]
    wanted: Wanted


def mended(
    pool: SheetPool, sheets: Sequence[Found], end: float, jobs: int, seed: int
) -> Iterator[list[Found]]:
    """Ever better layouts with all the pieces of `sheets`, until time is up or nothing is gained.

    Parameters
    ----------
    end : float
        `time.monotonic()`.
    jobs : int
        Processes.
    """
    random, vain = np.random.default_rng(seed), 0
    while vain < VAIN_DEALS and (rest := end - time.monotonic()) > 0.0:
        until = time.monotonic() + float(np.clip(DEAL * rest, min(SHORTEST, rest), LONGEST))
        pool.thin(DEALT)
        several = jobs if rest > STARTING else 1
        hands = _dealt(pool, sheets, min(several, len(sheets) // LEAST_SHEETS), random)
        before = _value(pool, sheets, pool.demand)
        try:
            played = _played(pool, hands, until, random)
        except BrokenExecutor:  # a process died: the layout so far is there, this one goes on
            jobs = 1
            continue
        sheets = [found for hand, _ in played for found in hand]
        for found in (found for _, new in played for found in new):
            pool.keep(found)
        gained = before - _value(pool, sheets, pool.demand)
        yield list(sheets)
        if gained > 1e-9 * before:
            vain = 0
        elif time.monotonic() < until:
            return  # every hand was played to its end
        else:
            vain += 1


def mend(pool: SheetPool, hand: Hand, end: float = np.inf, most: int | None = None) -> list[Found]:
    """The sheets of a hand, mended until time is up or nothing is gained for long.

    With `most` mendings instead of time the same pool gives the same sheets.
    """
    sheets, vain, turn = list(hand.sheets), 0, 0
    while vain < VAIN and time.monotonic() < end and turn != most:
        anew = _anew(pool, sheets, hand.wanted, end)
        vain, turn = vain + 1, turn + 1
        if anew is not None:
            sheets, vain = anew, 0
    return sheets


def _anew(
    pool: SheetPool, sheets: Sequence[Found], wanted: Wanted, end: float
) -> list[Found] | None:
    """The sheets with a few of them laid out anew, if that is better."""
    own = held(sheets, wanted.demand)
    given = _given_up(pool, sheets, own)
    old, kept = [sheets[k] for k in given], [f for k, f in enumerate(sheets) if k not in given]
    used = np.bincount([found.stock for found in kept], minlength=len(pool.costs))
    few = Wanted(np.sum([own[k] for k in given], axis=0), wanted.stocked - used)
    worth = pool.areas ** float(pool.random.choice(LARGE))
    made = filled(pool, worth, few, int(pool.random.choice(TRIES)), end, end)
    seconds = None
    if np.isfinite(end):
        seconds = float(np.clip(end - time.monotonic(), 0.1, CHOOSING))
    below = cost_of(pool, old) * (1.0 + 1e-9)
    chosen = pool.choice(few.demand, few.stocked, below, seconds)
    best, least = None, _value(pool, old, few.demand) * (1.0 - 1e-9)
    for anew in (made, chosen):
        whole = np.all(sum(held(anew, few.demand)) == few.demand)
        if whole and (value := _value(pool, anew, few.demand)) < least:
            best, least = kept + anew, value
    return best


def _given_up(pool: SheetPool, sheets: Sequence[Found], own: Sequence[Array]) -> list[int]:
    """A few sheets: the first rather an empty one."""
    random = pool.random
    fill = np.array(
        [h @ pool.areas / pool.sizes[f.stock] for h, f in zip(own, sheets, strict=True)]
    )
    weight = np.exp(EMPTIER * (fill.max() - fill))
    first = int(random.choice(len(sheets), p=weight / weight.sum()))
    others = [int(k) for k in random.permutation(len(sheets)) if k != first]
    return [first, *others[: int(random.integers(FEW, MOST + 1)) - 1]]


def _value(pool: SheetPool, sheets: Sequence[Found], demand: Array) -> float:
    """Cost, the lower the more the pieces are gathered."""
    ordered = sorted(sheets, key=lambda found: -float(found.counts @ pool.areas))
    gathered = 0.0
    for found, own in zip(ordered, held(ordered, demand), strict=True):
        fill = float(own @ pool.areas) / pool.sizes[found.stock]
        gathered += pool.costs[found.stock] * fill**2
    return cost_of(pool, sheets) - GATHERED * gathered


def _dealt(
    pool: SheetPool, sheets: Sequence[Found], count: int, random: np.random.Generator
) -> list[Hand]:
    """The sheets in so many hands; of stock that is short each has its part."""
    count = max(count, 1)
    own = held(sheets, pool.demand)
    order = random.permutation(len(sheets))
    used = np.bincount([found.stock for found in sheets], minlength=len(pool.costs))
    short = np.isfinite(pool.stocked)
    rest = np.where(short, pool.stocked, 0.0) - used
    hands = []
    for k in range(count):
        mine = order[k::count]
        demand = np.sum([own[j] for j in mine], axis=0)
        stocked = np.bincount([sheets[j].stock for j in mine], minlength=len(pool.costs))
        spare: Array = np.where(short, (rest + k) // count, np.inf)
        hands.append(Hand(tuple(sheets[j] for j in mine), Wanted(demand, stocked + spare)))
    return hands


def _played(
    pool: SheetPool, hands: Sequence[Hand], until: float, random: np.random.Generator
) -> list[tuple[list[Found], list[Found]]]:
    """Every hand mended, and the sheets found on the way; each hand in a process of its own."""
    if len(hands) == 1:
        return [(mend(pool, hands[0], until), [])]
    from joblib import Parallel, delayed

    seeds = random.integers(2**31, size=len(hands))
    clock = until - time.monotonic() + time.time()
    played = Parallel(n_jobs=len(hands))(
        delayed(_alone)(pool, hand, clock, int(own)) for hand, own in zip(hands, seeds, strict=True)
    )
    return [made for made in played if made is not None]


def _alone(pool: SheetPool, hand: Hand, until: float, seed: int) -> tuple[list[Found], list[Found]]:
    """One hand in another process, which has a pool of its own, until a time of `time.time()`."""
    end = time.monotonic() + min(until - time.time(), LONGEST)
    pool.random = np.random.default_rng(seed)
    before = list(pool.sheets)
    known = {id(found) for found in before}
    sheets = mend(pool, hand, end)
    return sheets, [found for found in pool.sheets if id(found) not in known]
