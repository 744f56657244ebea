"""The model gives way: strips are drawn towards what their panels could cheaply be made as.

Every panel has a closest plane, cylinder or cone. Where the cheapest of them is not far off, the
model is fitted once more with its distance from it as a further term, and the panels are chosen
anew: what that buys is told. A model that leaves the design surface by more than ``strips.give``
(or ``limits.deviation_max_mm``, where that is less), or costs no less, is not taken; what one
farther off would buy is told, too. Distances from the surface are measured as for the review.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from fabgeo.arrays import Array, IntArray
from fabgeo.build.fitted import lane_counts, lanes_of, patches_of
from fabgeo.build.model import options_of, outwards
from fabgeo.build.progress import Clock
from fabgeo.build.skin import SPRINGING, limits_of
from fabgeo.errors import GeometryError
from fabgeo.fitting.fit import FitResult, fit
from fabgeo.fitting.starts import Start
from fabgeo.panels.carrier import Carriers
from fabgeo.panels.certify import deviation
from fabgeo.panels.choose import JointChoice, choose
from fabgeo.panels.limits import Costs
from fabgeo.panels.pool import CLASSES
from fabgeo.panels.samples import PanelInput
from fabgeo.panels.search import Search
from fabgeo.project import Project
from fabgeo.strips.measures import measure
from fabgeo.strips.model import Patch, StripModel
from fabgeo.structures import panels as layers
from fabgeo.surfaces.base import DesignSurface

TURNS = 3  # fits, each towards the shapes of the panels before
NEAR = 8.0  # class tolerances: shapes further off are not worth the way
PULL = 3.0  # weight of the first fit, against 1 of the surface
WEAKER = 0.2  # of it where the model left the surface too far, or its panels cost no less


@dataclass(frozen=True)
class Drawn:
    """Shapes of the panels of a model, looked up by strip, lane and place.

    Attributes
    ----------
    carriers : Carriers
        One a panel.
    able : (p,) bool array
        Whether the panel is drawn to it.
    lanes : (strips,) int array
        How many lanes `panels.width` divides every strip into.
    first : (all lanes,) int array
        Number of each lane's first panel.
    begins : tuple of arrays
        Where a lane's panels begin, from 0 to 1 along it.
    """

    carriers: Carriers
    able: Array
    lanes: IntArray
    first: IntArray
    begins: tuple[Array, ...]

    def __call__(
        self, strip: IntArray, lane: IntArray, t: Array, points: Array
    ) -> tuple[Array, Array]:
        """See `fabgeo.fitting.objectives.towards.Shapes`; no distance where none is wanted."""
        panel = np.empty(len(strip), dtype=np.int64)
        number = (np.cumsum(self.lanes) - self.lanes)[strip] + lane
        for k, begins in enumerate(self.begins):
            own = number == k
            at = np.searchsorted(begins, t[own], side="right") - 1
            panel[own] = self.first[k] + at % len(begins)
        shapes, each = self.carriers[panel], points[:, None]
        wanted = self.able[panel]
        return wanted * shapes.distance(each)[:, 0], wanted[:, None] * shapes.normal(each)[:, 0]


def given_way(
    project: Project,
    surface: DesignSurface,
    initial: Start,
    fitted: FitResult,
    clock: Clock | None = None,
    jobs: int | None = None,
) -> tuple[FitResult, str, dict[str, float]]:
    """The fit whose panels cost least, what giving way has bought, and figures of it."""
    asked = project.strips.give
    if asked is None or project.panels is None:
        return fitted, "", {}
    asked = min(asked, project.limits.deviation_max_mm or np.inf)
    clock = clock or Clock()
    away = off = _off(fitted, surface)
    best, before = fitted, _chosen(project, outwards(fitted.model), jobs)
    found, pull = before, PULL
    farther: tuple[float, float] | None = None  # what a model too far off costs, and how far it is
    for _ in range(TURNS):
        clock.tell(f"strips towards shapes, panels cost {found.cost:g}")
        try:
            made = _towards(project, initial, outwards(best.model), pull)
            anew = _chosen(project, outwards(made.model), jobs)
        except GeometryError:
            break  # strips folded on the way
        far = _off(made, surface)
        if far > asked:
            farther = min(farther or (np.inf, far), (anew.cost, far))
        if far > asked or _worse(made, fitted) or anew.cost >= found.cost:
            pull *= WEAKER
        else:
            best, found, off = made, anew, far
    figures = {
        "give_panels_cost_before": before.cost,
        "give_panels_cost_after": found.cost,
        "give_deviation_before_mm": away,
        "give_deviation_after_mm": off,
    }
    told = _told(before, found, away, off, asked)
    if farther is not None and farther[0] < found.cost:
        told += "; {:.2f} mm off the surface panels would cost {:g}".format(*reversed(farther))
    return best, told, figures


def _towards(project: Project, initial: Start, model: StripModel, pull: float) -> FitResult:
    """The fit once more from where it began, drawn to the shapes of a model's panels.

    From the model itself it would be anchored there: strips would drift from where they belong.
    """
    start = outwards(initial.model)  # counted as the model's edges are
    options = options_of(project, initial)
    weights = replace(options.weights, towards=pull)
    options = replace(options, towards=_shapes(project, model), weights=weights)
    return fit(initial.reference, start, project.strips.kind, options)


def _worse(made: FitResult, fitted: FitResult) -> bool:
    return made.status != "converged" and fitted.status == "converged"


def _off(result: FitResult, surface: DesignSurface) -> float:
    """The model's largest distance from the surface, mm."""
    found = measure(result.model, surface).deviation_max
    return 0.0 if found is None else found.value


def _told(before: JointChoice, after: JointChoice, away: float, off: float, asked: float) -> str:
    if after is before:
        return (
            f"give: no model within {asked:g} mm of the surface was found whose panels cost less "
            f"than {before.cost:g}; it stays as fitted, {away:.2f} mm off"
        )
    return (
        f"give: panels cost {after.cost:g}, {before.cost:g} before the strips gave way "
        f"({100 * (1 - after.cost / before.cost):.1f} % saved); {_shares(after)}, before "
        f"{_shares(before)}; {off:.2f} mm off the surface, {away:.2f} mm before"
    )


def _shares(choice: JointChoice) -> str:
    count = Counter(panel.cls for panel in choice.panels)
    return ", ".join(f"{count[name]} {name}" for name in CLASSES if count[name])


def _inputs(project: Project, model: StripModel) -> tuple[tuple[Patch, ...], list[PanelInput]]:
    """Panels on the model itself, its strips divided into lanes."""
    lanes = lanes_of(model, lane_counts(project, model))
    patches = patches_of(project, lanes)
    plates = layers.panels(lanes, patches, layers.Layer("model", 0.0, 1.0, ""))
    names = ("first", "second", "start", "end")
    return patches, [
        PanelInput(p.mark, p.mid, {side: p.shared[side] for side in names if side in p.shared})
        for p in plates
    ]


def _chosen(project: Project, model: StripModel, jobs: int | None) -> JointChoice:
    asked = project.panels
    costs, radii, step = (
        (Costs(), None, None)
        if asked is None
        else (Costs(**asked.costs), asked.radii, asked.radii_step)
    )
    _, inputs = _inputs(project, model)
    limits = limits_of(project)
    return choose(inputs, limits, costs, SPRINGING, radii=radii, radii_step=step, jobs=jobs)


def _shapes(project: Project, model: StripModel) -> Drawn:
    """The cheapest class of every panel that is near, and its closest shape."""
    asked = project.panels
    patches, inputs = _inputs(project, model)
    limits = limits_of(project)
    costs = Costs() if asked is None else Costs(**asked.costs)
    search = Search(inputs, limits, costs)
    fits = list(search.own.fits)
    if asked is not None and (asked.radii is not None or asked.radii_step is not None):
        search.limit_radii(asked.radii, asked.radii_step)
        k = CLASSES.index("cylinder")
        if len(search.radii):
            fits[k] = search.rolled(np.arange(len(patches)), fits[k])[0]
    off = np.stack([deviation(search.samples, own)[0] for own in fits], axis=1)
    price = np.where(off <= NEAR * limits.deviation_mm, costs.by_kind[: len(fits)], np.inf)
    kind, carriers = price.argmin(axis=1), fits[-1]
    for k, own in enumerate(fits):
        carriers = own.where(kind == k, carriers)
    lanes = lane_counts(project, model)
    own = np.array([patch.strip for patch in patches])  # a lane is a strip of the divided model
    begins = np.array([patch.u0 for patch in patches]) / model.segments
    every = np.arange(sum(lanes))
    return Drawn(
        carriers,
        np.isfinite(price.min(axis=1)).astype(np.float64),
        np.array(lanes),
        np.searchsorted(own, every),
        tuple(begins[own == k] for k in every),
    )
