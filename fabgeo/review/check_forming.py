"""How panels are formed, against their classes and radii.

Glossary
--------
forming
    Flat panels stay flat. Of the others of one material and thickness, those spring into shape
    that are bent no tighter than some radius; tighter ones are rolled or pressed.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage, number

type Row = dict[str, str]


def check_forming(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Compare forming with class and radius; the springing radius is what most rows agree on."""
    del measured
    groups: dict[tuple[str, str], list[tuple[float, Row]]] = defaultdict(list)
    for row in package.tables["panels"]:
        forming, kind, least = row.get("forming"), row.get("class"), number(row, "radius_min_mm")
        if forming and kind and (forming == "flat") != (kind == "flat"):
            words = "flat" if kind == "flat" else f"bent, of class {kind}"
            findings.add(row.get("mark", ""), "forming of its class", words, forming)
        elif forming and kind != "flat" and least is not None and np.isfinite(least):
            groups[row.get("material", ""), row.get("thickness_mm", "")].append((least, row))
    for bent in groups.values():
        _springing(bent, findings)


def _springing(bent: list[tuple[float, Row]], findings: Findings) -> None:
    """Name rows on the wrong side of the radius that parts most others."""
    radii = np.array([radius for radius, _ in bent])
    springs = np.array([row.get("forming") == "spring" for _, row in bent])
    order = np.argsort(radii, kind="stable")
    sprung, formed = np.sort(radii[springs]), np.sort(radii[~springs])
    limits = np.append(radii[order], np.inf)
    wrong = np.searchsorted(sprung, limits) + len(formed) - np.searchsorted(formed, limits, "right")
    limit = limits[int(wrong.argmin())]
    for radius, row in bent:
        spring = row.get("forming") == "spring"
        if (spring and radius < limit) or (not spring and radius > limit):
            words = "spring" if radius > limit else "rolled or pressed"
            what = f"forming at {radius:.0f} mm, where others of its sheet turn at {limit:.0f} mm"
            findings.add(row.get("mark", ""), what, words, row.get("forming"))
