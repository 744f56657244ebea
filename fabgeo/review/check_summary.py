"""checks/review.json against what was measured here, key by key."""

from __future__ import annotations

from typing import Any

from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage
from fabgeo.review.record import SUMMARY_KEYS, Limit
from fabgeo.review.verdicts import ORDER, failed_verdicts, judge

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

IN_ROWS = {"kink_own_deg": "kink_max_deg"}
"""Figures whose column has another name."""

OF_MODEL = {"kink_max_deg": 1e-6, "conical_residual": 1e-9, "folds": 0.0}
"""Summary keys that strips.json alone measures, and how far they may be off."""

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
    """Summary's keys and numbers, every part's verdict against its own figures and the limits."""
    review = package.review
    if not review:
        findings.add("checks/review.json", "file", "present and JSON", "missing or broken")
        return
    summary = review.get("summary") or {}
    for key in SUMMARY_KEYS:
        if key not in summary:
            findings.add("checks/review.json", f"summary key {key}", "present", "missing")
    for key, within in EXACT.items():
        stated, found = summary.get(key), measured.figures.get(key)
        if stated is not None and found is not None:
            findings.near("checks/review.json", f"summary {key}", found, float(stated), within)
    parts = (review.get("parts") or {}).values()
    for key in WORST:
        values = [v for part in parts if isinstance(v := part.get(key), int | float)]
        if key == "twist_max_deg" and "model_twist_max_deg" in measured.figures:
            values.append(measured.figures["model_twist_max_deg"])
        stated = summary.get(key)
        if values and stated is not None:
            within = 1e-6 * max(values) + 1e-12
            findings.near("checks/review.json", f"summary {key}", max(values), stated, within)
    for key, within in OF_MODEL.items():
        stated, found = summary.get(key), measured.figures.get(key)
        if stated is not None and found is not None:
            within += 1e-6 * abs(found)
            findings.near("checks/review.json", f"summary {key} of strips.json", found, stated,
                          within)  # fmt: skip
    stated = summary.get("offset_distance_error_mm")
    found = measured.figures.get("offset_distance_error_mm")
    if stated is not None and found is not None:
        within = 1e-6 + 0.01 * found
        findings.near("checks/review.json", "summary offset_distance_error_mm of strips.json",
                      found, stated, within)  # fmt: skip
    wider = max(1.0, float(package.setting("cutting", "tolerance", OUTLINES)) / OUTLINES)
    for key, more in MEASURED.items():
        stated, found = summary.get(key), measured.figures.get(key)
        if stated is not None and found is not None and found > stated + wider * more:
            words = f"at most {stated + wider * more:.4g}"
            findings.add("checks/review.json", f"summary {key} of the files", words, found)
    _verdicts(package, review, findings)


def _verdicts(package: WrittenPackage, review: dict[str, Any], findings: Findings) -> None:
    limits = [
        Limit(key, own.get("good"), own.get("warn"), sense=own.get("sense", "max"))
        for key, own in (review.get("limits") or {}).items()
    ]
    parts = review.get("parts") or {}
    others = (*package.tables["beams"], *package.tables["cells"])
    rows = {**package.cut_rows, **{row.get("mark", ""): row for row in others}}
    for mark, part in parts.items():
        figures = {k: v for k, v in part.items() if isinstance(v, int | float)}
        verdict, _ = judge(limits, figures)
        stated = part.get("verdict")
        if stated not in ORDER or ORDER.index(stated) < ORDER.index(verdict):
            findings.add(mark, "verdict in review.json by its figures", verdict, stated)
        row = rows.get(mark)
        if row is not None and row.get("verdict", stated) != stated:
            findings.add(mark, "verdict in its schedule row", stated, row.get("verdict"))
        if row is not None:
            _same_figures(mark, part, row, findings)
    summary = review.get("summary") or {}
    total = summary.get("failed_verdicts")
    failed = failed_verdicts(
        {"parts": parts, "limits": review.get("limits") or {}, "summary": summary}
    )
    if total is not None and total != failed:
        findings.add("checks/review.json", "summary failed_verdicts", failed, total)


def _same_figures(mark: str, part: dict[str, Any], row: dict[str, str], findings: Findings) -> None:
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
