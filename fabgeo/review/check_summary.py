"""Summary of checks/review.json against what was measured here, key by key."""

from __future__ import annotations

from typing import Any

from fabgeo.review.check_limits import check_limits, limits_of
from fabgeo.review.check_manifest import LARGEST_TOLERANCE
from fabgeo.review.check_strips import NAME
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage
from fabgeo.review.record import SUMMARY_KEYS
from fabgeo.review.verdicts import failed_verdicts

REVIEW = "checks/review.json"
EXACT = {"solids": 0.0, "invalid_solids": 0.0, "unplaced_parts": 0.0, "utilisation": 2e-3}

WORST = (
    "twist_max_deg",
    "gap_max_mm",
    "kink_added_deg",
    "volume_error_rel",
    "edge_length_error_mm",
    "area_error_rel",
    "refold_error_mm",
)
"""Summary keys that are the worst over the parts (of the twist: and of the model)."""

OF_MODEL = {
    "twist_max_deg": (0.0, 1e-6),
    "kink_max_deg": (1e-6, 1e-6),
    "conical_residual": (1e-9, 1e-6),
    "folds": (0.0, 0.0),
    "offset_distance_error_mm": (1e-4, 0.01),
}
"""Summary keys that strips.json alone measures, and how far they may be off, relatively too.

Strips that `panels.width` divides are offset as divided, strips.json holds them whole: errors of a
few 1e-6 mm differ by as much.
"""

OF_SURFACE = ("deviation_max_mm", "deviation_rms_mm")
"""Summary keys that only the design surface measures: every fitted model has them."""

MEASURED = {
    "edge_length_error_mm": 0.02,
    "shared_edge_error_mm": 0.02,
    "refold_error_mm": 0.05,
}
"""Errors of the unfolding: how much more than stated the files may measure.

Outlines are written within a tolerance, of 0.05 mm here; with a wider one they may be as much more
off. Areas are judged part by part (`check_flats`): of a small part its outline is a larger share.
"""
OUTLINES = 0.05  # mm


def check_summary(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Summary's keys and numbers, and the limits that it is judged by."""
    if not package.review:
        findings.add(REVIEW, "file", "present and JSON", "missing or broken")
        return
    summary = package.review["summary"]
    for key in SUMMARY_KEYS:
        if key not in summary:
            findings.add(REVIEW, f"summary key {key}", "present", "missing")
    for key, within in EXACT.items():
        stated, found = summary.get(key), measured.figures.get(key)
        if stated is not None and found is not None:
            findings.near(REVIEW, f"summary {key}", found, float(stated), within)
    if package.project.get("strips"):
        _asked_for(package, measured, findings)
    _worst_of_parts(package, measured, findings)
    _of_model(summary, measured, findings)
    tolerance = float(package.setting("cutting", "tolerance", OUTLINES))
    wider = max(1.0, min(tolerance, LARGEST_TOLERANCE) / OUTLINES)
    for key, more in MEASURED.items():
        stated, found = summary.get(key), measured.figures.get(key)
        if stated is not None and found is not None and found > stated + wider * more:
            words = f"at most {stated + wider * more:.4g}"
            findings.add(REVIEW, f"summary {key} of the files", words, found)
    check_limits(package, findings)
    _failed(package, findings)


def _asked_for(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """A key is not null where it was measured, of the model or of any part."""
    summary, parts = package.review["summary"], package.review["parts"].values()
    there = {key for part in parts for key, value in part.items() if value is not None}
    due = {*OF_SURFACE, *(key for key in (*EXACT, *OF_MODEL) if key in measured.figures)}
    due |= there & set(WORST)
    for key in sorted(due):
        if key in summary and summary[key] is None:
            findings.add(REVIEW, f"summary {key}", "a number", "null")
    most, mean = (summary.get(key) for key in OF_SURFACE)
    if most is not None and mean is not None and not mean <= most * (1.0 + 1e-9):
        findings.add(REVIEW, "summary deviation_rms_mm", f"at most the largest, {most:.6g}", mean)


def _worst_of_parts(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    summary, parts = package.review["summary"], package.review["parts"].values()
    for key in WORST:
        values = [v for part in parts if isinstance(v := part.get(key), int | float)]
        stated, most = summary.get(key), max(values, default=0.0)
        if key == "twist_max_deg" and measured.figures.get("model_twist_max_deg", 0.0) > most:
            continue  # the model's: see `_of_model`
        if values and stated is not None:
            findings.near(REVIEW, f"summary {key}", most, stated, 1e-6 * abs(most) + 1e-15)


def _of_model(summary: dict[str, Any], measured: Measured, findings: Findings) -> None:
    """Figures of the model: where several differ it was altered, where one does, it or this."""
    figures = dict(measured.figures)
    figures["twist_max_deg"] = figures.get("model_twist_max_deg", 0.0)
    off = {}
    for key, (within, share) in OF_MODEL.items():
        stated, found = summary.get(key), figures.get(key)
        if stated is None or found is None or (key == "twist_max_deg" and found <= stated):
            continue
        if not abs(found - stated) <= within + share * abs(found):
            off[key] = found, stated
    for key, (found, stated) in off.items():
        findings.add(NAME, f"{key} as the summary states", stated, found)
        if len(off) == 1:
            findings.add(REVIEW, f"summary {key} of strips.json", found, stated)


def _failed(package: WrittenPackage, findings: Findings) -> None:
    """How many verdicts fail, by the limits that the project asks for."""
    limits = {own.key: {"good": own.good, "warn": own.warn, "sense": own.sense}
              for own in limits_of(package)}  # fmt: skip
    stated = package.review["summary"].get("failed_verdicts")
    failed = failed_verdicts({**package.review, "limits": limits})
    if stated is not None and stated != failed:
        findings.add(REVIEW, "summary failed_verdicts", failed, stated)
