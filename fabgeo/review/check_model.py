"""strips.json measured again: the figures of the fitted model that need no design surface."""

from __future__ import annotations

from fabgeo.errors import FabgeoError
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage

NAME = "strips.json"


def check_model(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Read the model and measure twist, kink, conical residual and the offset's distance.

    What they are compared with is in `fabgeo.review.check_summary`.
    """
    from fabgeo.fitting.store import load_model
    from fabgeo.strips.measures import measure
    from fabgeo.strips.offset import offset

    path = package.folder / NAME
    if not path.is_file():
        return
    try:
        model = load_model(path)
    except FabgeoError as error:
        findings.add(NAME, "model", "readable", error.problem)
        return
    found = measure(model)
    measured.figures["model_twist_max_deg"] = found.twist_deg.value
    if found.kink_across_deg:
        measured.figures["kink_max_deg"] = found.kink_across_deg.value
    if model.kind == "conical" and found.conicality:
        measured.figures["conical_residual"] = found.conicality.value
    measured.figures["folds"] = float(len(found.folds))
    stated = (package.review.get("summary") or {}).get("offset_distance_error_mm")
    depth = _depth(package)
    if stated is None or depth is None or model.kind not in ("conical", "circular"):
        return
    try:
        errors = offset(model, depth).errors
    except FabgeoError as error:
        findings.add(NAME, f"offset by {depth:g} mm", "possible", error.problem)
        return
    known = [e for e in (errors.ruling, errors.plane, errors.vertex) if e == e]
    measured.figures["offset_distance_error_mm"] = float(max(known))


def _depth(package: WrittenPackage) -> float | None:
    """Signed distance of the offset that cells or beams are bounded by."""
    cells, beams = package.project.get("cells"), package.project.get("beams")
    if cells:
        return float(cells.get("depth", -200.0))
    if beams and "standoff" in beams and "depth" in beams:
        return -(float(beams["standoff"]) + float(beams["depth"]))
    return None
