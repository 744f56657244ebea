"""Numbers that are measured: of the whole package and of every part, by code the fit does not use.

Glossary
--------
figure
    A measured number by name, as in checks/review.json (handover.md).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fabgeo.arrays import Array, dot
from fabgeo.build.facts import Facts
from fabgeo.build.geometry import Design
from fabgeo.build.products import ProductFacts
from fabgeo.build.solids import Built
from fabgeo.panels.flat import FlatPart
from fabgeo.project import Project
from fabgeo.review.record import Limit
from fabgeo.sheets.stock import Nest
from fabgeo.strips.distances import distances_from
from fabgeo.strips.measures import Measures, Worst, measure
from fabgeo.strips.offset import Offset, offset
from fabgeo.structures.prisms import ruled_normals

type Figures = dict[str, dict[str, float | None]]

SAMPLES = 4000  # of the surface, for its distance from several models
CERTIFIED = ("edge_length_error_mm", "area_error_rel", "refold_error_mm")
FACING = {"first": "second", "second": "first", "start": "end", "end": "start"}


def model_figures(design: Design) -> dict[str, float | None]:
    """Figures of the fitted models against the design surface: the worst of all."""
    found = [measure(own.model, design.surface) for own in design.models]
    conical = all(own.model.kind == "conical" for own in design.models)
    out: dict[str, float | None] = {
        "deviation_max_mm": _largest(m.deviation_max for m in found),
        "deviation_rms_mm": _of_all_samples(found),
        "deviation_over_sag_limit": _largest(m.deviation_over_sag_limit for m in found),
        "surface_to_model_max_mm": found[0].surface_to_model_max,
        "covered_share": found[0].covered_share,
        "folds": float(sum(len(m.folds) for m in found)),
        "twist_max_deg": _largest(m.twist_deg for m in found),
        "kink_max_deg": _largest(m.kink_across_deg for m in found),
        "conical_residual": _largest(m.conicality for m in found) if conical else None,
    }
    if len(found) > 1:
        out |= _covered_together(design, found)
    pair = offset_pair(design)
    if pair is not None:
        errors = pair.errors
        known = [e for e in (errors.ruling, errors.plane, errors.vertex) if np.isfinite(e)]
        out["offset_distance_error_mm"] = max(known)
    return out


def _largest(values: Iterable[Worst | float | None]) -> float | None:
    numbers = (v.value if isinstance(v, Worst) else v for v in values)
    return max((v for v in numbers if v is not None), default=None)


def _of_all_samples(found: Sequence[Measures]) -> float:
    """The root mean square deviation of several models, from that of each."""
    squares = [(m.deviation_count or 0) * (m.deviation_rms or 0.0) ** 2 for m in found]
    return float(np.sqrt(sum(squares) / max(sum(m.deviation_count or 0 for m in found), 1)))


def _covered_together(design: Design, found: Sequence[Measures]) -> dict[str, float | None]:
    """How far the surface is from the nearest model, and the share of it that they cover.

    As of a single model: points count that are as near to them as they are to the surface.
    """
    points = design.surface.sample(SAMPLES).point
    away = np.min([distances_from(own.model, points) for own in design.models], axis=0)
    near = _largest(limit for m in found for limit in (m.deviation_max, m.sag_limit)) or 0.0
    return {
        "surface_to_model_max_mm": float(away.max()),
        "covered_share": float(np.mean(away <= near)),
    }


def offset_pair(design: Design) -> Offset | None:
    """The offset pair of the cells; without cells, of the depth that the beams reach down to."""
    beams = design.project.beams
    if design.pair is not None or beams is None or not design.beams:
        return design.pair
    return offset(design.model, -(beams.standoff + beams.depth))


def panel_deviations(design: Design) -> tuple[Array, Array]:
    """Signed deviations (P, k) of the made panels from the design surface, and their places.

    Measured at 9 x 5 points a panel, along the surface's normals; a panel that lies at an offset
    is compared with the surface at that offset. Where a panel overhangs the surface there is
    nothing to compare it with: nan. Places are (P, k, 3).
    """
    height = design.project.panels.offset if design.project.panels else 0.0
    places, normals = [], []
    for plate in design.panels:
        u = np.linspace(plate.mid.u0, plate.mid.u1, 9)
        a, b = plate.mid.edges(u)
        v = np.linspace(0.0, 1.0, 5)[:, None, None]
        places.append(((1.0 - v) * a + v * b).reshape(-1, 3))
        normals.append(np.tile(ruled_normals(plate.mid, u), (5, 1)))
    points, m = np.array(places), np.array(normals)
    found = design.surface.closest(points.reshape(-1, 3))
    sign = np.where(dot(found.normal, m.reshape(-1, 3)) >= 0.0, 1.0, -1.0)
    signed = sign * dot(points.reshape(-1, 3) - found.point, found.normal)
    signed[found.on_boundary] = np.nan
    return signed.reshape(len(points), -1) - height, points


def part_figures(
    design: Design,
    flats: Mapping[str, FlatPart],
    built: Mapping[str, Built],
    deviations: Array | None,
    facts: Mapping[str, Facts],
) -> Figures:
    """Figures of every part by mark."""
    out: Figures = {}
    for plate in design.plates:
        figures: dict[str, float | None] = {"twist_max_deg": facts[plate.mark].twist_deg}
        flat = flats.get(plate.mark)
        if flat is not None:
            figures |= {key: flat.certificate.get(key) for key in CERTIFIED}
        out[plate.mark] = figures
    for mark, choice in design.choices.items():
        out[mark] |= {
            "fit_deviation_mm": choice.bound_mm,
            "gap_max_mm": choice.gap_mm,
            "kink_added_deg": choice.kink_added_deg,
            "kink_own_deg": choice.kink_own_deg,
        }
    if deviations is not None:
        for plate, row in zip(design.panels, deviations, strict=True):
            over = np.abs(row[np.isfinite(row)])
            out[plate.mark]["surface_deviation_mm"] = float(over.max()) if len(over) else None
    for cell in design.cells:
        out[cell.mark] = {}
    for mark, solid in built.items():
        sound = solid.report is not None and solid.report.sound
        out[mark] |= {"invalid_solids": 0.0 if sound else 1.0}
        if solid.volume_error is not None:
            out[mark]["volume_error_rel"] = solid.volume_error
    return out


def summary_of(
    design: Design,
    model: Mapping[str, float | None],
    parts: Figures,
    flats: Mapping[str, FlatPart],
    built: Mapping[str, Built],
    nests: list[Nest],
    products: Mapping[str, ProductFacts],
    facts: Mapping[str, Facts],
) -> dict[str, float | None]:
    """The package's figures: the worst over all parts (handover.md)."""
    out: dict[str, float | None] = {**model, **design.worth}
    for key in ("twist_max_deg", "gap_max_mm", "volume_error_rel", *CERTIFIED):
        values = [v for f in (model, *parts.values()) if (v := f.get(key)) is not None]
        out[key] = max(values) if values else None
    out["kink_added_deg"] = max((c.kink_added_deg for c in design.choices.values()), default=None)
    out["shared_edge_error_mm"] = shared_edge_error(facts)
    placed = sum(products[connector.product].solids for connector in design.connectors)
    unsound = sum(product.unsound for product in products.values())
    out["solids"] = placed + sum(1 for b in built.values() if b.made)
    out["invalid_solids"] = unsound + sum(
        1 for b in built.values() if not (b.report and b.report.sound)
    )
    if nests:
        area = sum(s.stock.length * s.stock.width for n in nests for s in n.sheets)
        used = sum(flats[p.mark].area for n in nests for s in n.sheets for p in s.placements)
        out["utilisation"] = used / area if area else 0.0
        out["unplaced_parts"] = sum(len(n.unplaced) for n in nests)
    return out


def shared_edge_error(facts: Mapping[str, Facts]) -> float | None:
    """Largest difference between two neighbouring flat parts along the edge they share, in mm.

    Neighbours as cut are not equally long there: a joint shortens the edge on the outside of a
    bend, and each panel lies on the shape it is made as. What counts is that both parts are laid
    flat alike: the difference of their flat lengths less the difference of the same two edges in
    space. Without a joint, on developable panels, it is the plain difference of flat lengths.
    """
    errors: dict[tuple[str, str], tuple[str, float]] = {}
    for mark, own in facts.items():
        for name, shared, length in own.flat_lengths:
            errors[mark, name] = (shared, length - own.lengths[name])
    worst: float | None = None
    for (mark, side), (shared, error) in errors.items():
        neighbour, back = errors.get((shared, FACING[side]), ("", 0.0))
        if neighbour == mark:
            worst = max(worst or 0.0, abs(error - back))
    return worst


def limits_of(project: Project) -> tuple[Limit, ...]:
    """The project's limits as the review judges by them."""
    given = project.limits
    own, default = "project file", "default of the hand-over contract"

    def limit(key: str, good: float | None, warn: float | None, label: str, field: str) -> Limit:
        return Limit(key, good, warn, label, own if field in given.model_fields_set else default)

    asked: list[tuple[str, Any, float | None, str, str]] = [
        (
            "surface_deviation_mm",
            given.deviation_max_mm,
            None,
            "Deviation from the design surface",
            "deviation_max_mm",
        ),
        (
            "kink_added_deg",
            given.kink_added_good_deg,
            given.kink_added_warn_deg,
            "Kink that replacement adds",
            "kink_added_good_deg",
        ),
    ]
    plain = {
        "deviation_max_mm": "Deviation of the fitted model",
        "deviation_over_sag_limit": "Deviation over the sag limit kappa L^2 / 16",
        "twist_max_deg": "Twist along a ruling",
        "gap_max_mm": "Gap between neighbouring panels as made",
        "conical_residual": "Conical residual",
        "offset_distance_error_mm": "Error of the offset's distance",
        "volume_error_rel": "STEP volume against formula",
        "edge_length_error_mm": "Unfolding: edge lengths",
        "shared_edge_error_mm": "Unfolding: shared edges",
        "area_error_rel": "Unfolding: area",
        "refold_error_mm": "Unfolding: refolded part",
    }
    asked += [(key, getattr(given, key), None, label, key) for key, label in plain.items()]
    out = [_given_way(limit(*row), project) for row in asked]
    share = limit("covered_share", given.covered_share, None, "Surface covered", "covered_share")
    out.append(replace(share, sense="min"))
    for key, label in (
        ("folds", "Folded strips"),
        ("invalid_solids", "Invalid solids"),
        ("unplaced_parts", "Parts not nested"),
    ):
        out.append(Limit(key, 0.0, None, label, "always"))
    return tuple(out)


def _given_way(limit: Limit, project: Project) -> Limit:
    """Strips that may give way are judged by how far they may, in place of the sag limit.

    Limits that the project names hold as they are.
    """
    give = None if project.panels is None else project.strips.give
    if give is None or limit.key in project.limits.model_fields_set:
        return limit
    if limit.key == "deviation_max_mm":
        return replace(limit, good=give, origin="strips.give")
    if limit.key == "deviation_over_sag_limit":
        return replace(limit, good=None, origin="strips.give")
    return limit
