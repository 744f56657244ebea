"""Parts in other processes: the same results, crashes isolated, finished parts kept."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import scale_work

from fabgeo.build.cache import Cache
from fabgeo.build.parallel import Work, results

NUMBERS = list(range(20))
SQUARES = [n * n for n in NUMBERS]


def work(function: Callable[..., Any]) -> Work[Any, Any]:
    return Work("square", function, lambda n: n, lambda n, reason: f"{n}: {reason}")


def test_two_processes_give_what_one_gives() -> None:
    assert list(results(work(scale_work.squared), NUMBERS)) == SQUARES
    assert list(results(work(scale_work.squared), NUMBERS, 2)) == SQUARES


def test_other_processes_begin_before_anybody_takes_a_result(tmp_path: Path) -> None:
    flags = [str(tmp_path / f"{n}") for n in range(4)]
    found = results(work(scale_work.flagged), flags, 2)
    end = time.monotonic() + 60.0
    while not (tmp_path / "0").exists() and time.monotonic() < end:
        time.sleep(0.01)
    assert (tmp_path / "0").exists()
    assert list(found) == flags


def test_a_part_that_kills_its_process_is_reported_and_the_others_made(tmp_path: Path) -> None:
    cache = Cache(tmp_path)
    found = list(results(work(scale_work.deadly), NUMBERS, 2, cache))
    assert found[13] == "13: the process that worked on it died, again when it was alone"
    assert found[:13] + found[14:] == SQUARES[:13] + SQUARES[14:]
    assert cache.made == 19  # the fault is no result: it is tried again


def test_a_worker_killed_from_outside_costs_no_part(tmp_path: Path) -> None:
    jobs = [(n, str(tmp_path / "flag")) for n in NUMBERS]
    assert list(results(work(scale_work.dies_once), jobs, 2)) == SQUARES
    assert (tmp_path / "flag").exists()


def test_a_worker_that_grew_steps_back_and_costs_no_part() -> None:
    found = list(results(work(scale_work.grows), range(100), 2))
    assert [square for square, _ in found] == [n * n for n in range(100)]
    grown = found[60][1]
    assert grown not in {p for _, p in found[90:]}


def test_finished_parts_are_kept_when_the_build_stops(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="No space"):
        list(results(work(scale_work.stopped), NUMBERS, 1, Cache(tmp_path)))
    cache = Cache(tmp_path)
    assert list(results(work(scale_work.squared), NUMBERS, 1, cache)) == SQUARES
    assert cache.found == 7
