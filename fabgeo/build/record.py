"""The review record of a build: what people read, gathered from the parts and their figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

import fabgeo
from fabgeo.arrays import Array
from fabgeo.build.cache import Cache
from fabgeo.build.facts import facts_of
from fabgeo.build.figures import (
    limits_of,
    model_figures,
    panel_deviations,
    part_figures,
    summary_of,
)
from fabgeo.build.geometry import Design
from fabgeo.build.products import product_facts
from fabgeo.build.rows import beam_rows, cell_rows, panel_rows, places_of, plate_rows
from fabgeo.build.solids import Built
from fabgeo.build.surface import seen
from fabgeo.panels.flat import FlatPart
from fabgeo.review.display import shown_plate, shown_prism
from fabgeo.review.record import (
    DeviationMap,
    ReviewRecord,
    SetoutPoint,
    Shown,
    ShownConnector,
)
from fabgeo.sheets.stock import Nest
from fabgeo.structures.prisms import ruled_normals

COVERED = 0.98  # of the surface: where strips leave more of it bare, the build says so


def record_of(
    design: Design,
    flats: Mapping[str, FlatPart],
    nests: list[Nest],
    built: Mapping[str, Built],
    seconds: Mapping[str, float],
    not_asked: tuple[str, ...],
    jobs: int | None = None,
    cache: Cache | None = None,
) -> ReviewRecord:
    """Everything that the review shows and judges; what is of one part is measured by `jobs`."""
    store = cache or Cache()
    measured = facts_of(design, flats, jobs, store)
    model, deviations, seen = store.once("deviations", _compared(design), lambda: _compare(design))
    products = product_facts(design, store)
    facts = dict(measured)
    figures = part_figures(design, flats, built, deviations, facts)
    places = places_of(nests)
    project = design.project
    masses = {key: product.mass for key, product in products.items()}
    return ReviewRecord(
        name=project.name,
        unit=project.surface.unit or "mm",
        version=fabgeo.__version__,
        panels=tuple(panel_rows(design, flats, built, figures, places, facts)),
        plates=tuple(plate_rows(design, flats, built, places, facts)),
        beams=tuple(beam_rows(design, built, facts)),
        cells=tuple(cell_rows(design, built, facts)),
        connectors=tuple(connector_rows(design, masses)),
        shown=tuple(_shown(design)),
        shown_connectors=tuple(
            ShownConnector(c.mark, c.product, c.frame[:3, 3], c.frame[:3, 2])
            for c in design.connectors
        ),
        flats=flats,
        nests=tuple(nests),
        setout=tuple(setout_of(design)),
        limits=limits_of(project),
        figures=figures,
        summary=summary_of(design, model, figures, flats, built, nests, products, facts),
        history=tuple(row for own in design.models for row in own.fit.history),
        seconds=seconds,
        deviation=DeviationMap(*seen),
        tradeoff=design.tradeoff,
        remarks=(*design.notes, *_uncovered(model["covered_share"]), *_unfixed(design)),
        not_asked=not_asked,
        materials={
            name: {"name": name, "density_kg_m3": project.material(name).density}
            for name in sorted({plate.material for plate in design.plates})
        },
    )


def _uncovered(share: float | None) -> tuple[str, ...]:
    """A remark where the strips leave part of the surface bare; sampled, so to half a per cent."""
    if share is None or share > COVERED:
        return ()
    return (
        f"model: {100.0 * (1.0 - share):.1f} % of the surface lies beside the strips; let them "
        'overhang it (start = "principal", or "iso" with strips.overhang) and raise strips.cover',
    )


def _unfixed(design: Design) -> tuple[str, ...]:
    """A remark where panels lack fixings that were asked for: their rows tell each its reason."""
    lacking = {m: why for m, (verdict, why) in design.complaints.items() if verdict == "warn"}
    if not lacking:
        return ()
    mark, reason = next(iter(lacking.items()))
    return (
        f"connectors: {len(lacking)} of {len(design.panels)} panels lack fixings, "
        f"{len(design.connectors)} are made in all; {mark}: {reason}",
    )


type _Compared = tuple[dict[str, float | None], Array | None, tuple[Array, Array]]


def _compared(design: Design) -> tuple[Any, ...]:
    """What all comparison with the design surface depends on; a surface is known by points."""
    project = design.project
    height = project.panels.offset if project.panels else 0.0
    models = tuple(own.model for own in design.models)
    made = (models, [plate.mid for plate in design.panels], height)
    beams = project.beams and (project.beams.standoff, project.beams.depth, bool(design.beams))
    depth = project.cells and project.cells.depth
    return (*seen(design.surface), *made, beams, depth)


def _compare(design: Design) -> _Compared:
    """Figures of the model, deviations of the panels, and the map of the model's."""
    model = model_figures(design)
    deviations, _ = panel_deviations(design) if design.panels else (None, None)
    shown = deviation_map(design)
    return model, deviations, (shown.points, shown.values)


def deviation_map(design: Design) -> DeviationMap:
    """Signed deviation of the fitted models from the design surface; nan where they overhang."""
    models = [own.model for own in design.models]
    columns = max(len(model.parameters(2)) for model in models)
    rows: list[Array] = []
    for model in models:
        u = model.parameters(2)
        u = u if len(u) == columns else np.linspace(0.0, model.segments, columns)
        first, second = model.pairs(model.points(u))
        for k in range(model.strips):
            rows += [first[k], (first[k] + second[k]) / 2.0]
        if not model.closed_i:
            rows.append(second[-1])
    points = np.array(rows)
    found = design.surface.closest(points.reshape(-1, 3))
    values = np.einsum("ki,ki->k", points.reshape(-1, 3) - found.point, found.normal)
    values[found.on_boundary] = np.nan
    return DeviationMap(points, values.reshape(points.shape[:2]))


def setout_of(design: Design) -> list[SetoutPoint]:
    """Panel corners at mid-surface, beam ends, and connector centres, with normals."""
    out = []
    for plate in design.panels:
        ends = np.array([plate.mid.u0, plate.mid.u1])
        corners, normals = plate.mid.edges(ends), ruled_normals(plate.mid, ends)
        for number, (side, end) in enumerate(((0, 0), (0, 1), (1, 1), (1, 0)), 1):
            name = f"{plate.mark}/{number}"
            out.append(
                SetoutPoint(name, corners[side, end], normals[end], "panel corner", plate.mark)
            )
    for beam in design.beams:
        webs = [p.mid for p in beam.plates if p.mark.startswith(f"{beam.mark}-WEB")]  # or pieces
        first, last = webs[0], webs[-1]
        inner, outer = np.stack(
            [mid.edges(np.array([u]))[:, 0] for mid, u in ((first, first.u0), (last, last.u1))],
            axis=1,
        )
        axis = (outer - inner) / np.linalg.norm(outer - inner, axis=-1, keepdims=True)
        for number in (0, 1):
            name = f"{beam.mark}/{number + 1}"
            out.append(SetoutPoint(name, outer[number], axis[number], "beam node", beam.mark))
    for c in design.connectors:
        out.append(SetoutPoint(c.mark, c.frame[:3, 3], c.frame[:3, 2], "connector", c.mark))
    return out


def _shown(design: Design) -> list[Shown]:
    out = [shown_plate(plate, "panels") for plate in design.panels]
    out += [shown_plate(plate, "panels") for plate in design.layers]
    normals = {patch.tag: part.normal for patch, part in zip(design.patches, out, strict=False)}
    up = np.array([0.0, 0.0, 1.0])
    for cell in design.cells:
        normal = normals.get(cell.patch.tag, up)
        out.append(shown_prism(cell.prism, "cells", normal, f"P-{cell.patch.tag}"))
    out += [shown_plate(plate, "cells") for plate in design.walls]
    for beam in design.beams:
        out += [shown_plate(plate, "beams", beam.mark) for plate in beam.plates]
    return out


def connector_rows(design: Design, masses: Mapping[str, float]) -> list[dict[str, Any]]:
    """One row a connector; `masses` by product."""
    rows = []
    for connector in design.connectors:
        place, axis = connector.frame[:3, 3], connector.frame[:3, 2]
        rows.append(
            {
                "mark": connector.mark,
                "product": connector.product,
                "panel": connector.panel,
                "beam": connector.beam,
                "mass_kg": masses[connector.product],
                **{f"{k}_mm": float(v) for k, v in zip("xyz", place, strict=True)},
                **{f"axis_{k}": float(v) for k, v in zip("xyz", axis, strict=True)},
            }
        )
    return rows
