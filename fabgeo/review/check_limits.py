"""Limits of checks/review.json against those that the project asks for in manifest.json."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from fabgeo.review.findings import Findings
from fabgeo.review.package import WrittenPackage
from fabgeo.review.record import Limit

DEFAULTS: dict[str, float | None] = {
    "deviation_max_mm": None,
    "deviation_over_sag_limit": 1.2,
    "twist_max_deg": 0.02,
    "covered_share": None,
    "kink_added_good_deg": 1.0,
    "kink_added_warn_deg": 3.0,
    "gap_max_mm": 2.0,
    "offset_distance_error_mm": 0.01,
    "conical_residual": 1e-4,
    "edge_length_error_mm": 0.02,
    "shared_edge_error_mm": 0.02,
    "area_error_rel": 1e-6,
    "refold_error_mm": 0.05,
    "volume_error_rel": 1e-6,
}
"""Limits of a project that names none (hand-over contract), by their keys in its [limits]."""
MAY_LACK = ("deviation_max_mm", "deviation_over_sag_limit", "twist_max_deg", "covered_share")
"""Those that a project may do without: manifest.json omits them then."""
WITH_WARNINGS = {"kink_added_deg": ("kink_added_good_deg", "kink_added_warn_deg")}
"""Figures that have a range of warnings, and both keys of theirs."""
OF_ANOTHER = {"surface_deviation_mm": "deviation_max_mm"}
"""Figures that are judged by the limit of another."""
ALWAYS = ("folds", "invalid_solids", "unplaced_parts")
"""Figures that are to be 0 in every project."""
REVIEW, GIVE = "checks/review.json", "strips.give"


class Bound(NamedTuple):
    """A limit as a file has it, sound or not: see `fabgeo.review.record.Limit`."""

    good: float | None
    warn: float | None = None
    sense: str = "max"

    def __str__(self) -> str:
        words = "none" if self.good is None else f"{self.sense} {self.good:g}"
        return words if self.warn is None else f"{words}, warn {self.warn:g}"


def limits_of(package: WrittenPackage) -> list[Limit]:
    """What parts and summary are judged by: as the project asks, then what else is stated."""
    bounds = {**_stated(package), **_expected(package)}
    return [
        Limit(key, own.good, own.warn if _in_order(own) else None, sense=_sense(own.sense))
        for key, own in bounds.items()
    ]


def check_limits(package: WrittenPackage, findings: Findings) -> None:
    """Every limit that the project asks for is stated, and as it is asked for.

    Where review.json states the contract's, and that it is this, manifest.json was altered.
    """
    stated, usual = _stated(package), _asked(DEFAULTS)
    limits = package.review.get("limits") or {}
    for key, asked in _expected(package).items():
        if key not in stated:
            findings.add(REVIEW, f"limit {key}", asked, "none")
            continue
        own, default = stated[key], usual.get(key, asked)
        by_default = str(limits[key].get("origin", "")).startswith("default")
        if _same(own, asked):
            if by_default and not _same(own, default):
                findings.add(REVIEW, f"limit {key}", default, f"{own}, called a default")
        elif by_default and _same(own, default):
            findings.add("manifest.json", f"limit {key} of the project", own, asked)
        else:
            findings.add(REVIEW, f"limit {key}", asked, own)


def _stated(package: WrittenPackage) -> dict[str, Bound]:
    """Limits as review.json states them."""
    found = (package.review.get("limits") or {}).items()
    return {k: Bound(own.get("good"), own.get("warn"), own.get("sense", "max")) for k, own in found}


def _expected(package: WrittenPackage) -> dict[str, Bound]:
    """Limits as manifest.json asks for them; the contract's where it tells of no project."""
    table = package.project.get("limits")
    stated = _stated(package)
    if not isinstance(table, dict):
        return {key: own for key, own in _asked(DEFAULTS).items() if key in stated}
    own = {key: None if key in MAY_LACK else usual for key, usual in DEFAULTS.items()}
    asked = _asked({**own, **{k: v for k, v in table.items() if isinstance(v, int | float)}})
    # Strips that may give way are judged by how far they may, where the project names no limit.
    give = package.setting("strips", "give", None)
    origins = {k: own.get("origin") for k, own in (package.review.get("limits") or {}).items()}
    for key, good in (("deviation_max_mm", give), ("deviation_over_sag_limit", None)):
        if give is not None and origins.get(key) == GIVE:
            asked[key] = Bound(good)
    return asked


def _asked(table: Mapping[str, Any]) -> dict[str, Bound]:
    """Limits by figure of a table of limits by their keys."""
    out = {key: Bound(table[key]) for key in DEFAULTS}
    out["covered_share"] = Bound(table["covered_share"], None, "min")
    for key, (good, warn) in WITH_WARNINGS.items():
        out[key] = Bound(table[good], table[warn])
        del out[good], out[warn]
    out |= {key: out[other] for key, other in OF_ANOTHER.items()}
    return out | {key: Bound(0.0) for key in ALWAYS}


def _same(one: Bound, other: Bound) -> bool:
    pairs = ((one.good, other.good), (one.warn, other.warn))
    equal = all(a == b or (a and b and math.isclose(a, b)) for a, b in pairs)
    return equal and one.sense == other.sense


def _sense(word: str) -> Any:
    return "min" if word == "min" else "max"


def _in_order(own: Bound) -> bool:
    """Whether warnings begin where the good ends, as `Limit` asks."""
    if own.good is None or own.warn is None:
        return True
    return own.warn >= own.good if own.sense != "min" else own.warn <= own.good
