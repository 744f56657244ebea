"""The trade-off between tolerance and cost: what each tolerance buys, as a table and a plot."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fabgeo.panels.candidates import measured, targets_of
from fabgeo.panels.choose import JointChoice, choose
from fabgeo.panels.classify import distinct_radii
from fabgeo.panels.fit_shape import fit, start
from fabgeo.panels.forming import Sheet
from fabgeo.panels.limits import Costs, Tolerances
from fabgeo.panels.pool import CLASSES
from fabgeo.panels.samples import PanelInput, sample

DEVIATIONS_MM = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
NORMS = (2.0, 4.0, 16.0)  # of a closest shape's fit, one after the other

# One colour a class, told apart by colour-blind eyes (Okabe and Ito).
_COLOURS = ("#009E73", "#56B4E9", "#E69F00", "#CC79A7")


@dataclass(frozen=True)
class TradeOffRow:
    """One pair of tolerances and what the joint choice makes of it.

    Attributes
    ----------
    deviation_mm, kink_deg : float
        The tolerances.
    flat, cylinder, cone, developable : float
        Shares of the panels, 0 to 1.
    cost, bound, floor, one_by_one : float
        Sum of costs, what no choice undercuts (see `JointChoice`), what no panel by itself
        undercuts, and the cost chosen panel by panel.
    radii : int
        Distinct cylinder radii, to 1 mm.
    gap_max_mm, kink_max_deg : float
        Largest gap and largest added kink between panels as made.
    """

    deviation_mm: float
    kink_deg: float
    flat: float
    cylinder: float
    cone: float
    developable: float
    cost: float
    bound: float
    floor: float
    one_by_one: float
    radii: int
    gap_max_mm: float
    kink_max_deg: float


def trade_off(
    panels: Sequence[PanelInput],
    deviations_mm: Sequence[float] = (1.0, 3.0, 6.0),
    kinks_deg: Sequence[float] = (0.5, 1.0, 3.0),
    tolerances: Tolerances | None = None,
    costs: Costs | None = None,
    sheet: Sheet | None = None,
    rounds: int = 2,
    seconds: float | None = None,
    thorough: bool = False,
    radii: Sequence[float] | int | None = None,
    radii_step: float | None = None,
) -> Iterator[TradeOffRow]:
    """Joint choices at every pair of tolerances, one by one; other limits as in `tolerances`.

    A choice within tighter limits stands where the search within wider ones finds none cheaper.
    `seconds` limits the programmes of each pair by the clock, and `thorough` places neighbouring
    strips together; `radii` and `radii_step` are those that cylinders may have: see
    `fabgeo.panels.choose.choose`.
    """
    base = tolerances or Tolerances()
    made: list[tuple[float, float, JointChoice]] = []
    for deviation in deviations_mm:
        for kink in kinks_deg:
            limits = replace(base, deviation_mm=deviation, kink_deg=kink)
            found = choose(
                panels, limits, costs, sheet, rounds, seconds, radii, radii_step, thorough=thorough
            )
            made.append((deviation, kink, found))
            within = [own for d, k, own in made if d <= deviation and k <= kink]
            best = min(within[::-1], key=lambda choice: choice.cost)
            count = len(best.panels)
            shares = {c: sum(p.cls == c for p in best.panels) / count for c in CLASSES}
            yield TradeOffRow(
                deviation_mm=deviation,
                kink_deg=kink,
                **shares,
                cost=best.cost,
                bound=found.bound,
                floor=found.floor,
                one_by_one=found.one_by_one,
                radii=distinct_radii(best.panels),
                gap_max_mm=max((p.gap_mm for p in best.panels), default=0.0),
                kink_max_deg=max((p.kink_added_deg for p in best.panels), default=0.0),
            )


def by_deviation(
    panels: Sequence[PanelInput],
    deviations_mm: Sequence[float] = DEVIATIONS_MM,
    tolerances: Tolerances | None = None,
) -> list[dict[str, float]]:
    """How many panels each class would have over the tolerance, every panel by itself.

    A panel counts to the simplest class whose closest shape is within the tolerance anywhere:
    neighbours, gaps and kinks are left out of it, so that it takes one fit a class.

    Returns
    -------
    list of dict
        A row a tolerance: "tolerance_mm" and a count for each class.
    """
    if not panels:
        return []
    limits = tolerances or Tolerances()
    samples, everyone = sample([panel.patch for panel in panels]), np.arange(len(panels))
    targets = targets_of(samples, 1.0, None, None, np.ones((len(panels), 1)))
    off = []
    for kind, name in enumerate(CLASSES[:-1]):
        near = fit(targets, start(samples, name), name, samples.size, NORMS)
        off.append(measured(everyone, kind, near, samples, limits).deviation)
    rows = []
    for tolerance in deviations_mm:
        within = np.array([*(np.array(off) <= tolerance), np.ones(len(panels), dtype=bool)])
        counts = np.bincount(within.argmax(axis=0), minlength=len(CLASSES)).tolist()
        rows.append({"tolerance_mm": tolerance, **dict(zip(CLASSES, counts, strict=True))})
    return rows


def table(rows: Sequence[TradeOffRow]) -> str:
    """The rows as a Markdown table."""
    head = (
        "deviation mm | kink deg | flat % | cylinder % | cone % | developable % | cost "
        "| least | one by one | radii | gap mm | kink added deg"
    )
    lines = [f"| {head} |", "|" + "---|" * (head.count("|") + 1)]
    for r in rows:
        shares = " | ".join(f"{100 * getattr(r, c):.0f}" for c in CLASSES)
        lines.append(
            f"| {r.deviation_mm:g} | {r.kink_deg:g} | {shares} | {r.cost:g} | {r.bound:.0f} "
            f"| {r.one_by_one:g} | {r.radii} | {r.gap_max_mm:.2f} | {r.kink_max_deg:.2f} |"
        )
    return "\n".join(lines)


def plot(rows: Sequence[TradeOffRow], path: str | Path) -> Path:
    """Stacked shares of the classes and the cost over the tolerances, as PNG or SVG by suffix."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 4.2), layout="constrained")
    FigureCanvasAgg(figure)
    shares = figure.subplots()
    at = np.arange(len(rows))
    below = np.zeros(len(rows))
    for name, colour in zip(CLASSES, _COLOURS, strict=True):
        share = 100.0 * np.array([getattr(r, name) for r in rows])
        shares.bar(at, share, bottom=below, color=colour, label=name, width=0.8)
        below += share
    shares.set_xticks(at, [f"{r.deviation_mm:g} mm\n{r.kink_deg:g}°" for r in rows])
    shares.set_ylabel("share of panels, %")
    shares.set_ylim(0.0, 100.0)
    shares.set_xlabel("tolerances: deviation, added kink")
    cost = shares.twinx()
    cost.plot(at, [r.cost for r in rows], "ko-", label="cost, chosen together")
    cost.plot(at, [r.one_by_one for r in rows], "k^:", label="cost, panel by panel")
    cost.set_ylim(bottom=0.0)
    cost.set_ylabel("relative cost")
    figure.legend(loc="outside upper center", ncols=6, fontsize="small")
    path = Path(path)
    figure.savefig(path, dpi=150)
    return path
