"""`fabgeo check DIR`: a written package measured from its files alone.

Hashes come first, but every measurement is made whatever they say: an altered file is named by
the part that it concerns.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from fabgeo.arrays import checked_path
from fabgeo.review.check_beams import check_beams
from fabgeo.review.check_bill import check_bill
from fabgeo.review.check_columns import check_columns
from fabgeo.review.check_families import check_families
from fabgeo.review.check_files import check_files
from fabgeo.review.check_fixings import check_fixings
from fabgeo.review.check_flats import check_flats
from fabgeo.review.check_forming import check_forming
from fabgeo.review.check_kinks import check_kinks
from fabgeo.review.check_manifest import check_manifest
from fabgeo.review.check_marks import check_marks
from fabgeo.review.check_model import check_model
from fabgeo.review.check_neighbours import check_neighbours
from fabgeo.review.check_parts import check_parts
from fabgeo.review.check_planks import check_planks
from fabgeo.review.check_rows import check_rows
from fabgeo.review.check_setout import check_setout
from fabgeo.review.check_sheets import check_sheets
from fabgeo.review.check_site import check_site
from fabgeo.review.check_solids import check_solids
from fabgeo.review.check_strips import check_strips
from fabgeo.review.check_summary import check_summary
from fabgeo.review.check_tables import check_tables
from fabgeo.review.check_welds import check_welds
from fabgeo.review.findings import CheckReport, Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage

STEPS = (
    check_files,
    check_solids,
    check_flats,
    check_sheets,
    check_rows,
    check_beams,
    check_welds,
    check_planks,
    check_fixings,
    check_neighbours,
    check_site,
    check_setout,
    check_marks,
    check_tables,
    check_columns,
    check_bill,
    check_forming,
    check_families,
    check_manifest,
    check_model,
    check_parts,
    check_summary,
    check_strips,
    check_kinks,
)


def check_package(
    folder: Path | str,
    progress: Callable[[str], None] | None = None,
    jobs: int | None = None,
) -> CheckReport:
    """Measure a package and compare it with what it says of itself.

    Parameters
    ----------
    folder : Path
        The package's folder.
    progress : callable, optional
        Called with the name of each step.
    jobs : int, optional
        Processes for work that is independent per part; by default what joblib's
        `parallel_config` around the call says, else this process alone.

    Raises
    ------
    InputError
        If the folder holds no package.
    """
    package = WrittenPackage.open(checked_path("check_package", folder), jobs)
    findings, measured = Findings(), Measured()
    seconds: dict[str, float] = {}
    for step in STEPS:
        name = step.__name__.removeprefix("check_")
        if progress is not None:
            progress(name)
        begin = time.perf_counter()
        try:
            step(package, measured, findings)
        except Exception as error:  # whatever damaged files lead to: the other steps go on
            what = f"{type(error).__name__}: {error}"
            findings.add("package", f"files for the check of {name}", "measurable", what)
        seconds[name] = time.perf_counter() - begin
    counts = {
        "panels": len(package.tables["panels"]),
        "solids": sum(measured.names.values()),
        "flat parts": len(measured.flats),
        "sheets": len(package.sheet_files),
        "files": len(files)
        if isinstance(files := package.manifest.get("files"), dict | list)
        else 0,
    }
    return CheckReport(tuple(findings.items), dict(measured.figures), seconds, counts)
