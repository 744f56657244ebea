"""Parts of checks/review.json: those of the schedules, their figures, verdicts and the worst."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from fabgeo.review.check_limits import limits_of
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WORDS, WrittenPackage
from fabgeo.review.record import Limit
from fabgeo.review.verdicts import ORDER, judge

REVIEW = "checks/review.json"
IN_ROWS = {"kink_own_deg": "kink_max_deg"}
"""Figures whose column has another name."""
NO_WARNING = ("not ", "radius ")
"""How reasons begin that say why a shape or a way of forming was chosen: verdicts need others."""

type Part = Mapping[str, Any]
type Row = Mapping[str, str]


def check_parts(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Compare parts with the schedules' rows, verdicts with figures by the project's limits."""
    del measured
    parts, limits = package.review.get("parts"), limits_of(package)
    if not parts:
        return  # `check_summary` says so
    tables = (package.tables[name] for name in ("panels", "plates", "beams", "cells"))
    rows = {row.get("mark", ""): row for table in tables for row in table}
    for mark in rows.keys() - parts.keys():
        findings.add(mark, "part in review.json", "present", "missing")
    for mark in parts.keys() - rows.keys():
        findings.add(mark, "row of a part in review.json", "present", "missing")
    _words(package, findings)
    for mark, part in parts.items():
        _verdict(mark, part, limits, findings)
        row = rows.get(mark)
        if row is not None:
            _same_words(mark, part, row, findings)
            _same_figures(mark, part, row, findings)
    _worst(package, limits, findings)


def _words(package: WrittenPackage, findings: Findings) -> None:
    """Figures are numbers, or null."""
    written = package.review_as_written.get("parts")
    for mark, own in written.items() if isinstance(written, dict) else ():
        for key, value in own.items() if isinstance(own, dict) else ((REVIEW, own),):
            if key not in WORDS and not isinstance(value, int | float | None):
                findings.add(mark, f"{key} in review.json", "a number", repr(value)[:40])


def _verdict(mark: str, part: Part, limits: list[Limit], findings: Findings) -> None:
    """No better than figures say; no worse either, but for a reason beside them."""
    figures = {k: v for k, v in part.items() if isinstance(v, int | float)}
    verdict, said = judge(limits, figures)
    stated, reason = part.get("verdict"), part.get("reason", "")
    others = [word for word in reason.removeprefix(said).split("; ") if word]
    worse = stated in ("warn", "fail") and not any(not w.startswith(NO_WARNING) for w in others)
    if stated not in ORDER or ORDER.index(stated) < ORDER.index(verdict):
        findings.add(mark, "verdict in review.json by its figures", verdict, stated)
    elif worse and ORDER.index(stated) > ORDER.index(verdict):
        findings.add(mark, "verdict in review.json by its figures and reason", verdict, stated)


def _same_words(mark: str, part: Part, row: Row, findings: Findings) -> None:
    """Verdict and reason stand in both."""
    for key in ("verdict", "reason"):
        stated = part.get(key)
        if key in row and row[key] != (stated or ""):
            findings.add(mark, f"{key} in its schedule row", stated, row[key])


def _same_figures(mark: str, part: Part, row: Row, findings: Findings) -> None:
    """Figures that stand in review.json and in the schedule are equal, as rounded."""
    for key, value in part.items():
        text = row.get(IN_ROWS.get(key, key))
        if not text or not isinstance(value, int | float):
            continue
        decimals = len(text.partition(".")[2])
        try:
            stated = float(text)
        except ValueError:
            continue
        findings.near(mark, f"{key} in its schedule row", value, stated, 0.51 * 10.0**-decimals)


def _worst(package: WrittenPackage, limits: list[Limit], findings: Findings) -> None:
    """Of every figure with a limit that parts have, the part that has the worst is named."""
    stated, parts = package.review.get("worst") or {}, package.review["parts"]
    if "worst" not in package.review_as_written:
        return
    for limit in limits:
        own = [v for part in parts.values() if isinstance(v := part.get(limit.key), int | float)]
        if not own:
            continue
        value = max(own) if limit.sense == "max" else min(own)
        named = stated.get(limit.key, {})
        found, mark = named.get("value"), named.get("mark")
        there = parts.get(mark, {}).get(limit.key)
        if not (_equal(found, value) and _equal(there, value)):
            words = f"{found} of {mark}"
            findings.add(REVIEW, f"worst {limit.key}", f"{value:.6g} of a part that has it", words)


def _equal(one: Any, other: float) -> bool:
    return isinstance(one, int | float) and math.isclose(one, other, rel_tol=1e-9)
