"""strips.json measured again: the figures of the fitted model that need no design surface."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fabgeo.errors import FabgeoError
from fabgeo.review.check_strips import NAME, model_names
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage

if TYPE_CHECKING:
    from fabgeo.strips.model import StripModel


def check_model(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Read the model and measure twist, kink, conical residual and the offset's distance.

    What they are compared with is in `fabgeo.review.check_summary`.
    """
    from fabgeo.fitting.store import load_model

    models = []
    for name in model_names(package):
        try:
            models.append(load_model(package.folder / name))
        except FabgeoError as error:
            findings.add(name, "model", "readable", error.problem)
            return
    for model in models:
        _measure(model, measured)
    if len(models) == 1:
        _check_offset(models[0], package, measured, findings)


def _measure(model: StripModel, measured: Measured) -> None:
    """The worst of all models, and all folds."""
    from fabgeo.strips.measures import measure

    found = measure(model)
    measured.worst("model_twist_max_deg", found.twist_deg.value)
    if found.kink_across_deg:
        measured.worst("kink_max_deg", found.kink_across_deg.value)
    if model.kind == "conical" and found.conicality:
        measured.worst("conical_residual", found.conicality.value)
    measured.figures["folds"] = measured.figures.get("folds", 0.0) + len(found.folds)


def _check_offset(
    model: StripModel, package: WrittenPackage, measured: Measured, findings: Findings
) -> None:
    """How far its offset is from the distance asked."""
    from fabgeo.strips.offset import offset

    depth = _depth(package)
    if depth is None or model.kind not in ("conical", "circular"):
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
