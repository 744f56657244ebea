"""All panels chosen together: the least sum of costs within every limit.

Candidates come first: every panel by itself, then sweeps in which neighbours settle on common
boundaries. An integer programme chooses among them; then every panel that might still be cheaper
is fitted against the neighbours as chosen, and the programme is solved again, until nothing is
gained. Last, strip by strip, integer programmes over continuous placements
(`fabgeo.panels.programme`) look for what sweeps have missed.

The same programmes without neighbours bound how far that is from the least cost of all: to first
order, and with limits wider by all that is not linear (`fabgeo.panels.proof`) as a proof. Where
every panel has its cheapest class, nothing more is looked for.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

from fabgeo.panels.bounds import first_order, proven
from fabgeo.panels.classify import PanelChoice, describe
from fabgeo.panels.effort import Effort
from fabgeo.panels.forming import Sheet
from fabgeo.panels.integer import IntegerChoice
from fabgeo.panels.limits import Costs, Tolerances
from fabgeo.panels.placing import StripPlacing
from fabgeo.panels.samples import PanelInput
from fabgeo.panels.search import Search
from fabgeo.panels.stripwise import Stripwise

_GAIN = 5e-3  # of the cost: what a round has to gain for another one


@dataclass(frozen=True)
class JointChoice:
    """The panels chosen together, and what that is worth.

    Attributes
    ----------
    panels : tuple of PanelChoice
    cost : float
        Sum of the chosen classes' costs.
    bound : float
        Proven by the solver, over continuous placements: the sum of what the strips cost at
        least, each without regard to the others, with limits wider by what gaps, kinks and
        deviations are off linear ones (`fabgeo.panels.enclosure`). It concerns placements up to
        three times as far from the closest ones as limits allow to first order; where that is too
        far for anything to be proven, a panel counts as able to be made as its cheapest class. Of
        more than a thousand panels: `floor`.
    nearly : float
        The same with features linear about every panel's closest shape and limits 3 % wider:
        a bound to first order only. Far from the closest shapes (tens of millimetres along
        directions that hardly change a panel) features may be off by half a limit. Of more than
        a thousand panels it is not worked out: as `bound` then.
    among : float
        Proven by the solver: no choice among the candidates costs less.
    floor : float
        Every panel in the cheapest class that its deviation alone allows, whatever that does to
        its neighbours: no choice of any placements costs less.
    one_by_one : float
        Cost of the choice panel by panel under the same limits (`classify`).
    candidates : int
        Size of the pool.
    status : str
        "optimal" (among the candidates), "node limit" or, where `seconds` cut the work short,
        "time limit".
    history : tuple of float
        Cost after each round.
    seconds : float
    """

    panels: tuple[PanelChoice, ...]
    cost: float
    bound: float
    nearly: float
    among: float
    floor: float
    one_by_one: float
    candidates: int
    status: str
    history: tuple[float, ...]
    seconds: float

    @property
    def saving(self) -> float:
        """Share of the panel-by-panel cost that the joint choice saves."""
        return 1.0 - self.cost / self.one_by_one

    @property
    def most(self) -> float:
        """Share of the panel-by-panel cost that a choice can save at most, by `bound`."""
        return 1.0 - self.bound / self.one_by_one

    @property
    def figures(self) -> dict[str, float]:
        """What the choice costs, what it would panel by panel, and what none undercuts."""
        return {
            "panels_cost": self.cost,
            "panels_cost_one_by_one": self.one_by_one,
            "panels_cost_bound": self.bound,
            "panels_cost_first_order": self.nearly,
            "panels_cost_floor": self.floor,
        }

    def __str__(self) -> str:
        solved = self.bound > self.floor
        proof = "proven by the solver's bound" if solved else "by each panel's own deviation"
        told = (
            f"cost {self.cost:g} chosen together, {self.one_by_one:g} panel by panel: "
            f"{100 * self.saving:.1f} % saved; no choice saves more than {100 * self.most:.1f} % "
            f"(cost {self.bound:g}, {proof})"
        )
        if self.nearly <= self.bound:
            return told
        most = 100.0 * (1.0 - self.nearly / self.one_by_one)
        return f"{told}, to first order in the placements {most:.1f} % (cost {self.nearly:g})"


def choose(
    panels: Sequence[PanelInput],
    tolerances: Tolerances | None = None,
    costs: Costs | None = None,
    sheet: Sheet | None = None,
    rounds: int = 4,
    seconds: float | None = None,
    radii: Sequence[float] | int | None = None,
    radii_step: float | None = None,
    jobs: int | None = None,
    thorough: bool = False,
) -> JointChoice:
    """Choose the classes and placements of all panels together.

    Limited by counts of work, so that the same panels are chosen alike on every machine.

    Parameters
    ----------
    panels : sequence of PanelInput
    tolerances, costs, sheet : optional
        The project's; defaults of the hand-over contract.
    rounds : int
        Most rounds of new candidates after the first choice, again of strips' programmes, and of
        those of neighbouring strips at once; they end earlier when one gains less than 0.5 %. See
        `fabgeo.panels.effort` for what many panels leave of them.
    seconds : float, optional
        Limit by the clock of one integer programme over all panels, and of all strips'
        programmes: the choice then depends on the machine, and `status` tells so.
    radii : sequence of float or int, optional
        Equal radii: the radii that cylinders may have, mm, or how many different ones at most.
    radii_step : float, optional
        Radii that are not given are multiples of this, mm.
    jobs : int, optional
        Threads that solve the strips' programmes; by default this one alone.
    thorough : bool
        Place neighbouring strips at once however many panels there are.

    Raises
    ------
    InputError
        If neighbours do not fit together.
    """
    began = time.perf_counter()
    search = Search(panels, tolerances or Tolerances(), costs or Costs(), seconds)
    if radii is not None or radii_step is not None:
        search.limit_radii(radii, radii_step)
    found = _searched(search, Effort.of(len(panels), rounds, thorough), jobs)
    chosen = tuple(_described(search, panels, sheet or Sheet()))
    return replace(found, panels=chosen, seconds=time.perf_counter() - began)


def _searched(search: Search, effort: Effort, jobs: int | None) -> JointChoice:
    """The search to its end: figures of what it has come to, its panels not yet described."""
    history = [search.cost]
    result = _swept(search, effort, history)
    strips = Stripwise(search)
    bounds = first_order(strips, jobs) if effort.bounded else strips.summed(search.floors)
    placing = StripPlacing(strips, bounds, jobs, search.seconds)
    result = _placed(placing, effort, history) or result
    bound = _bound(strips, effort, jobs)
    return JointChoice(
        panels=(),
        cost=search.cost,
        bound=bound,
        nearly=max(bound, float(bounds.sum())),
        among=result.bound,
        floor=float(search.floors.sum()),
        one_by_one=history[0],
        candidates=len(search.pool),
        status="time limit" if placing.late else result.status,
        history=tuple(history),
        seconds=0.0,
    )


def _described(search: Search, panels: Sequence[PanelInput], sheet: Sheet) -> list[PanelChoice]:
    """The panels as chosen, with everything measured about them."""
    own, pool, joints, current = search.own, search.pool, search.joints, search.current
    return describe(panels, own, pool, joints, current, search.tolerances, search.costs, sheet)


def _swept(search: Search, effort: Effort, history: list[float]) -> IntegerChoice:
    """Choose among candidates of sweeps, then of rounds against the neighbours as chosen."""
    if not search.proven:
        search.settle()
    result = search.choose()
    history.append(search.cost)
    for _ in range(effort.candidates):
        if search.proven or not search.widen():
            break
        result = search.choose()
        history.append(search.cost)
        if _gain(history) < _GAIN:
            break
    return result


def _placed(placing: StripPlacing, effort: Effort, history: list[float]) -> IntegerChoice | None:
    """Strips placed by their programmes, as long as another round can be expected to gain.

    A round gains about as much less than the one before it as that one did: those to come are not
    waited for to have shown it.
    """
    search, before = placing.search, 1.0
    if search.proven or not effort.strips:
        return None
    for _ in range(effort.strips):
        placing.improve()
        history.append(search.cost)
        gain = _gain(history)
        if search.proven or gain * min(1.0, gain / before) < _GAIN:
            break
        before = gain
    for count in effort.windows:
        for _ in range(effort.again):
            for shift in range(count):
                placing.improve_windows(count, shift)
            history.append(search.cost)
            if search.proven or _gain(history) < _GAIN:
                break
    return search.choose()


def _bound(strips: Stripwise, effort: Effort, jobs: int | None) -> float:
    """What no choice undercuts: see `JointChoice.bound`."""
    search = strips.search
    if search.proven:
        return search.cost
    return proven(strips, jobs) if effort.bounded else float(search.floors.sum())


def _gain(history: Sequence[float]) -> float:
    """Share of the cost that the last round has saved."""
    return 1.0 - history[-1] / history[-2] if history[-2] > 0.0 else 0.0
