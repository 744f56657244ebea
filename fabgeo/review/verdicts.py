"""Limits against figures: a verdict and a reason for every part, and checks/review.json.

Glossary
--------
verdict
    "good" within the limit, "warn" within its range of warnings, "fail" beyond it, "not asked"
    where no figure of the part has a limit. A part's verdict is its worst figure's.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from fabgeo.review.record import SUMMARY_KEYS, Limit, ReviewRecord, Row, Verdict

ORDER: tuple[Verdict, ...] = ("not asked", "good", "warn", "fail")


def verdict_of(limit: Limit, value: float | None) -> Verdict:
    """The verdict on one figure; a figure that is not a number fails."""
    if limit.good is None or value is None:
        return "not asked"
    if not math.isfinite(value):
        return "fail" if limit.sense == "max" or math.isnan(value) else "good"
    sign = 1.0 if limit.sense == "max" else -1.0
    if sign * value <= sign * limit.good:
        return "good"
    if limit.warn is not None and sign * value <= sign * limit.warn:
        return "warn"
    return "fail"


def judge(limits: Iterable[Limit], figures: Mapping[str, float | None]) -> tuple[Verdict, str]:
    """The worst verdict on a part's figures and the reasons for whatever is not good."""
    worst: Verdict = "not asked"
    reasons: dict[str, list[str]] = {"warn": [], "fail": []}
    for limit in limits:
        value = figures.get(limit.key)
        verdict = verdict_of(limit, value)
        if ORDER.index(verdict) > ORDER.index(worst):
            worst = verdict
        if verdict in reasons:
            bound = limit.good if limit.warn is None or verdict == "warn" else limit.warn
            relation = "over" if limit.sense == "max" else "under"
            reasons[verdict].append(f"{limit.key} {value:.4g} {relation} {bound:g}")
    return worst, "; ".join(reasons["fail"] + reasons["warn"])


def judged(record: ReviewRecord) -> ReviewRecord:
    """The record with "verdict" and "reason" on every row whose part has figures.

    A verdict that a row brings along (a part that could not be made) is kept when it is worse.
    """
    verdicts = {mark: judge(record.limits, own) for mark, own in record.figures.items()}

    def rows(table: tuple[Row, ...]) -> tuple[Row, ...]:
        return tuple(_with_verdict(row, verdicts.get(str(row.get("mark")))) for row in table)

    return replace(
        record,
        panels=rows(record.panels),
        plates=rows(record.plates),
        beams=rows(record.beams),
        cells=rows(record.cells),
    )


def review_of(record: ReviewRecord) -> dict[str, Any]:
    """The contents of checks/review.json (handover.md); null where a figure was not asked for."""
    record = judged(record)
    tables = (record.panels, record.plates, record.beams, record.cells)
    rows = {str(row["mark"]): row for table in tables for row in table}
    parts: dict[str, dict[str, Any]] = {}
    for mark in sorted({*rows, *record.figures}):
        figures = record.figures.get(mark, {})
        verdict, reason = judge(record.limits, figures)
        row = rows.get(mark, {})
        parts[mark] = {key: _plain(value) for key, value in figures.items()}
        parts[mark]["verdict"] = row.get("verdict") or verdict
        parts[mark]["reason"] = row.get("reason") or reason
    summary = {key: _plain(record.summary.get(key)) for key in SUMMARY_KEYS}
    summary |= {k: _plain(v) for k, v in record.summary.items() if k not in summary}
    limits = {
        limit.key: {
            "good": limit.good,
            "warn": limit.warn,
            "sense": limit.sense,
            "label": limit.label,
            "origin": limit.origin,
        }
        for limit in record.limits
    }
    seconds = {stage: round(float(value), 3) for stage, value in record.seconds.items()}
    worst = _worst(record.limits, parts)
    review = {"summary": summary, "limits": limits, "worst": worst, "parts": parts}
    review["seconds"] = seconds
    summary["failed_verdicts"] = failed_verdicts(review)
    return review


def _worst(
    limits: Sequence[Limit], parts: Mapping[str, Mapping[str, Any]]
) -> dict[str, dict[str, Any]]:
    """Of every figure with a limit that parts have: the worst part's mark and value."""
    found = {}
    for limit in limits:
        own = [
            (part[limit.key], mark)
            for mark, part in parts.items()
            if part.get(limit.key) is not None
        ]
        if own:
            value, mark = (max if limit.sense == "max" else min)(own)
            found[limit.key] = {"mark": mark, "value": value}
    return found


def failed_verdicts(review: Mapping[str, Any]) -> int:
    """How many parts fail, and figures of the package that no part has for its own."""
    parts = review["parts"].values()
    of_parts = {key for part in parts for key in part}
    whole = package_verdicts(review).items()
    failed = [verdict for key, (verdict, _) in whole if key not in of_parts]
    return [*(part.get("verdict") for part in parts), *failed].count("fail")


def package_verdicts(review: Mapping[str, Any]) -> dict[str, tuple[Verdict, str]]:
    """Verdict and reason on every figure of review.json's summary that has a limit."""
    found: dict[str, tuple[Verdict, str]] = {}
    for key, own in review["limits"].items():
        value = review["summary"].get(key)
        if value is not None:
            limit = Limit(key, own.get("good"), own.get("warn"), sense=own.get("sense", "max"))
            found[key] = judge([limit], {key: value})
    return found


def write_review(path: Path, record: ReviewRecord) -> dict[str, Any]:
    """Write checks/review.json and return what was written."""
    review = review_of(record)
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(review, indent=1, allow_nan=False, ensure_ascii=False)
    path.write_text(text + "\n", encoding="utf-8")
    return review


def _with_verdict(row: Row, found: tuple[Verdict, str] | None) -> Row:
    own: Verdict = row.get("verdict") or "not asked"
    verdict, reason = found or ("not asked", "")
    brought = str(row.get("reason") or "")
    # A row that was judged before carries its reason already.
    words = brought if brought.startswith(reason) else "; ".join(filter(None, [reason, brought]))
    return {**row, "verdict": max(own, verdict, key=ORDER.index), "reason": words}


def _plain(value: Any) -> Any:
    """A number that JSON can hold: infinite and undefined ones become null."""
    if value is None or isinstance(value, str | bool | int):
        return value
    number = float(value)
    return number if math.isfinite(number) else None
