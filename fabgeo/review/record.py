"""The review record: everything that people read about one build, as plain data.

Glossary
--------
row
    One line of a schedule: a mapping from column name (`fabgeo.review.columns`) to value; a column
    that is missing or None was not asked for and is written empty.
figure
    A measured number of one part (or of the package: key of the summary) that a limit may judge.
rails
    N polylines of k points in cyclic order: a prism's edge curves sampled, what a part is drawn by.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from fabgeo.arrays import Array, set_frozen
from fabgeo.errors import InputError
from fabgeo.panels.flat import FlatPart
from fabgeo.sheets.stock import Nest

type Row = Mapping[str, Any]
type Family = Literal["panels", "cells", "beams", "connectors"]
type Verdict = Literal["good", "warn", "fail", "not asked"]

SUMMARY_KEYS = (
    "deviation_max_mm",
    "deviation_rms_mm",
    "deviation_over_sag_limit",
    "twist_max_deg",
    "kink_max_deg",
    "gap_max_mm",
    "conical_residual",
    "offset_distance_error_mm",
    "solids",
    "invalid_solids",
    "volume_error_rel",
    "edge_length_error_mm",
    "shared_edge_error_mm",
    "area_error_rel",
    "refold_error_mm",
    "utilisation",
    "unplaced_parts",
    "failed_verdicts",
)


@dataclass(frozen=True)
class Limit:
    """What a figure is judged by: good up to `good`, a warning up to `warn`, beyond it a failure.

    Attributes
    ----------
    key : str
        The figure's name, such as ``kink_max_deg``.
    good : float or None
        None: reported only, verdict "not asked".
    warn : float, optional
        None: as `good`, there is no range of warnings.
    label, origin : str
        What it is in words, and where the number comes from.
    sense : str
        "max": figures should be at most the limit; "min": at least.
    """

    key: str
    good: float | None
    warn: float | None = None
    label: str = ""
    origin: str = ""
    sense: Literal["max", "min"] = "max"

    def __post_init__(self) -> None:
        if self.good is None or self.warn is None:
            return
        if self.warn < self.good if self.sense == "max" else self.warn > self.good:
            raise InputError(
                f"limit {self.key}",
                f"expected warn ({self.warn}) to be no stricter than good ({self.good})",
                "exchange the two",
            )


@dataclass(frozen=True)
class Shown:
    """One part as the page and the drawings show it.

    Attributes
    ----------
    mark, family : str
        The mark of the part and the layer that it is shown on.
    rails : (N, k, 3) array
        Edge polylines in cyclic order, in mm; N = 2 is a surface, N >= 3 a solid with end caps.
    normal : (3,) array
        Outward direction, for the exploded view.
    row : str
        Mark of the schedule row it belongs to; its own mark where empty.
    """

    mark: str
    family: Family
    rails: Array
    normal: Array
    row: str = ""

    def __post_init__(self) -> None:
        set_frozen(self, "rails", ("N", "k", 3))
        set_frozen(self, "normal", (3,))


@dataclass(frozen=True)
class ShownConnector:
    """A connector as shown: its place, its bolt axis (outwards) and its product."""

    mark: str
    product: str
    origin: Array
    axis: Array

    def __post_init__(self) -> None:
        set_frozen(self, "origin", (3,))
        set_frozen(self, "axis", (3,))


@dataclass(frozen=True)
class SetoutPoint:
    """A point that the site measures in, with the normal there; role such as "panel corner"."""

    point: str
    position: Array
    normal: Array
    role: str
    mark: str

    def __post_init__(self) -> None:
        set_frozen(self, "position", (3,))
        set_frozen(self, "normal", (3,))


@dataclass(frozen=True)
class DeviationMap:
    """Signed deviations in mm at points of a regular grid over the strips.

    Attributes
    ----------
    points : (rows, columns, 3) array
    values : (rows, columns) array
        Deviation from the design surface; rows run across the strips. nan: beyond the surface.
    """

    points: Array
    values: Array

    def __post_init__(self) -> None:
        set_frozen(self, "points", ("rows", "columns", 3))
        values = np.array(self.values, dtype=np.float64)
        if values.shape != self.points.shape[:2]:
            raise InputError("DeviationMap.values", f"expected shape {self.points.shape[:2]}")
        values.flags.writeable = False
        object.__setattr__(self, "values", values)


@dataclass(frozen=True)
class ReviewRecord:
    """One build as its readers see it.

    Attributes
    ----------
    name, unit, version : str
        Project name, the unit of its input, the version of fabgeo.
    panels, plates, beams, connectors, cells : tuple of Row
        The schedules; verdict and reason columns are added by `fabgeo.review.verdicts.judged`.
    shown : tuple of Shown
        Panels, cells and beam plates to draw; connectors are in `shown_connectors`.
    flats : mapping of mark to FlatPart
    nests : tuple of Nest
    setout : tuple of SetoutPoint
    limits : tuple of Limit
    figures : mapping of mark to mapping of figure name to number or None
    summary : mapping
        The package's figures (keys `SUMMARY_KEYS`); a missing key is null in review.json.
    history : tuple of Row
        One row an iteration of the fit; numbers by name, with "iteration" and "cost".
    seconds : mapping of stage to seconds
    deviation : DeviationMap, optional
    tradeoff : tuple of Row
        Panel classes over tolerance: "tolerance_mm" and one count per class.
    where : mapping of figure name to str
        Where on the model a figure of the package that fails is at its worst, and what may help.
    remarks : tuple of str
        What people should know of the model besides the figures, a sentence each.
    not_asked : tuple of str
        Stages or outputs the project did not ask for.
    materials : mapping of material key to mapping
        Plain figures of each material, such as density_kg_m3 and name.
    """

    name: str
    unit: str = "mm"
    version: str = ""
    panels: tuple[Row, ...] = ()
    plates: tuple[Row, ...] = ()
    beams: tuple[Row, ...] = ()
    connectors: tuple[Row, ...] = ()
    cells: tuple[Row, ...] = ()
    shown: tuple[Shown, ...] = ()
    shown_connectors: tuple[ShownConnector, ...] = ()
    flats: Mapping[str, FlatPart] = field(default_factory=dict)
    nests: tuple[Nest, ...] = ()
    setout: tuple[SetoutPoint, ...] = ()
    limits: tuple[Limit, ...] = ()
    figures: Mapping[str, Mapping[str, float | None]] = field(default_factory=dict)
    summary: Mapping[str, float | None] = field(default_factory=dict)
    history: tuple[Row, ...] = ()
    seconds: Mapping[str, float] = field(default_factory=dict)
    deviation: DeviationMap | None = None
    tradeoff: tuple[Row, ...] = ()
    where: Mapping[str, str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    not_asked: tuple[str, ...] = ()
    materials: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest corner of everything shown."""
        if not self.shown:
            return np.zeros(3), np.ones(3)
        points = np.concatenate([part.rails.reshape(-1, 3) for part in self.shown])
        return points.min(axis=0), points.max(axis=0)
