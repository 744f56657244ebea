"""The cheapest class of every panel within the project's tolerances, panel by panel.

Glossary
--------
class
    What a panel is made as: "flat", "cylinder", "cone", or "developable" where no simpler shape
    keeps the limits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fabgeo.arrays import Array, BoolArray, IntArray, cross, dot, unit
from fabgeo.panels.candidates import OwnCandidates, own_candidates
from fabgeo.panels.carrier import Carriers
from fabgeo.panels.forming import Forming, Sheet, beyond_standards, forming_of
from fabgeo.panels.joints import Joints, joints_of
from fabgeo.panels.limits import Costs, Tolerances
from fabgeo.panels.made import as_made, end_turns
from fabgeo.panels.pairs import greedy, pairs_of
from fabgeo.panels.pool import CLASSES, Pool, pair_limits
from fabgeo.panels.samples import PanelInput, Samples
from fabgeo.panels.shapes import Cone, Cylinder, Shape, shape_of
from fabgeo.panels.worst import worst_of
from fabgeo.strips.ruled import RuledPatch

_BEND_LINES = {"flat": "parallel", "cylinder": "parallel", "cone": "concurrent"}


@dataclass(frozen=True)
class PanelChoice:
    """What one panel is made as, with everything measured about it.

    Attributes
    ----------
    mark : str
    cls : str
        "flat", "cylinder", "cone" or "developable".
    shape : Plane, Cylinder, Cone or None
        What replaces the fitted panel; None: it stays.
    fitted : RuledPatch
        The fitted panel.
    deviation_mm, bound_mm : float
        Largest distance between fitted panel and shape at samples, and the bound of it anywhere.
    flange_mm : float
        Largest change of the distance between panel and beam flange, along the edges.
    gap_mm, gap_edge : float, str
        Largest gap to a neighbour as made, and at which side.
    kink_added_deg, kink_own_deg, kink_edge : float, float, str
        Largest kink that replacement adds, the fitted model's own largest kink, and the side of
        the first.
    radius_min_mm, radius_max_mm : float
        Smallest and largest bending radius of the made panel; infinite where flat.
    half_angle_deg : float or None
        Of a cone.
    axis : (2, 3) array or None
        Point and direction of a cylinder's axis; apex and direction of a cone's.
    bend_lines : str
        "parallel", "concurrent" or "free", to within the deviation tolerance.
    forming : str
        "flat", "spring", "roll" or "press".
    cost : float
    reason : str
        Why no cheaper class, and what forming has to say.
    """

    mark: str
    cls: str
    shape: Shape | None
    fitted: RuledPatch
    deviation_mm: float
    bound_mm: float
    flange_mm: float
    gap_mm: float
    gap_edge: str
    kink_added_deg: float
    kink_own_deg: float
    kink_edge: str
    radius_min_mm: float
    radius_max_mm: float
    half_angle_deg: float | None
    axis: Array | None
    bend_lines: str
    forming: Forming
    cost: float
    reason: str

    @cached_property
    def made(self) -> RuledPatch:
        """The panel as made, on the shape; worked out when first asked for."""
        return self.on_shape(self.fitted)

    def on_shape(self, patch: RuledPatch, take: tuple[float, float] = (0.0, 0.0)) -> RuledPatch:
        """The fitted panel with its joints taken off, as it will be made.

        `take` is what of the joints the first and the last ruling come in by, mm.
        """
        if self.shape is None:
            return patch
        return as_made(patch, self.shape, end_turns(self.fitted, self.shape, take))

    def as_fitted(self, reason: str, cost: float) -> PanelChoice:
        """The choice not to replace the panel after all."""
        return replace(
            self,
            cls="developable",
            shape=None,
            half_angle_deg=None,
            axis=None,
            bend_lines="free",
            deviation_mm=0.0,
            bound_mm=0.0,
            flange_mm=0.0,
            cost=cost,
            reason="; ".join(filter(None, [reason, self.reason])),
        )


def classify(
    panels: Sequence[PanelInput],
    tolerances: Tolerances | None = None,
    costs: Costs | None = None,
    sheet: Sheet | None = None,
) -> list[PanelChoice]:
    """Choose panel by panel, in the order given: the cheapest class within all limits.

    A panel is compared with the neighbours already chosen as they will be made, and with the
    others as fitted, so that every one of them still can stay as it is.

    Parameters
    ----------
    panels : sequence of PanelInput
    tolerances, costs, sheet : optional
        The project's; defaults of the hand-over contract.

    Raises
    ------
    InputError
        If neighbours do not fit together.
    """
    tolerances, costs = tolerances or Tolerances(), costs or Costs()
    own = own_candidates(panels, tolerances)
    joints = joints_of(panels)
    chosen = greedy(own.pool, pairs_of(own.pool, joints, tolerances), costs)
    return describe(panels, own, own.pool, joints, chosen, tolerances, costs, sheet or Sheet())


def describe(
    panels: Sequence[PanelInput],
    own: OwnCandidates,
    pool: Pool,
    joints: Joints,
    chosen: IntArray,
    tolerances: Tolerances,
    costs: Costs,
    sheet: Sheet,
) -> list[PanelChoice]:
    """The chosen candidates as reported values, everything at the joints measured as made."""
    samples, every = own.samples, np.arange(len(joints))
    first, second = chosen[joints.panels[:, 0]], chosen[joints.panels[:, 1]]
    gap, added = pair_limits(pool, joints, every, first, second)
    worst = worst_of(joints, gap, added, len(panels))
    fitted_radii = bending_radii(samples)
    made_radii = _radii(samples, pool.carriers[chosen])
    lines = bend_lines(samples, tolerances.deviation_mm)
    cost = costs.by_kind
    reasons = _reasons(own.possible, pool, chosen, cost)
    out = []
    for p, panel in enumerate(panels):
        c, seen = int(chosen[p]), worst[p]
        name = CLASSES[pool.kind[c]]
        shape = None if name == "developable" else shape_of(pool.carriers, c, name)
        radii = fitted_radii[p] if shape is None else made_radii[p]
        forming, note = forming_of(name, radii[0], sheet)
        said = reasons[p], beyond_standards(name, sheet), note
        out.append(
            PanelChoice(
                mark=panel.mark,
                cls=name,
                shape=shape,
                fitted=panel.patch,
                deviation_mm=float(pool.deviation[c]),
                bound_mm=float(pool.bound[c]),
                flange_mm=float(pool.flange[c]),
                gap_mm=seen.gap,
                gap_edge=seen.gap_edge,
                kink_added_deg=float(np.degrees(seen.added)),
                kink_own_deg=float(np.degrees(seen.own)),
                kink_edge=seen.kink_edge,
                radius_min_mm=radii[0],
                radius_max_mm=radii[1],
                half_angle_deg=_half_angle(shape),
                axis=np.stack(shape.axis) if isinstance(shape, Cylinder | Cone) else None,
                bend_lines=_BEND_LINES.get(name, lines[p]),
                forming=forming,
                cost=float(cost[pool.kind[c]]),
                reason="; ".join(filter(None, said)),
            )
        )
    return out


def distinct_radii(panels: Sequence[PanelChoice]) -> int:
    """Number of different cylinder radii, to 1 mm: set-ups of the rolls, or moulds."""
    return len({round(p.radius_min_mm) for p in panels if p.cls == "cylinder"})


def _half_angle(shape: Shape | None) -> float | None:
    """Of a cone, degrees."""
    return float(np.degrees(shape.half_angle)) if isinstance(shape, Cone) else None


def _reasons(possible: BoolArray, pool: Pool, chosen: IntArray, cost: Array) -> list[str]:
    """Why panels are made as nothing cheaper: their classes that may be, and that were found."""
    offered = np.zeros_like(possible)
    offered[pool.panel, pool.kind] = True
    cheaper = cost < cost[pool.kind[chosen]][:, None]
    found = {
        "beyond the deviation tolerance": cheaper & ~possible,
        "no placement keeps deviation, flange, ends and radii": cheaper & possible & ~offered,
        "gap or kink at the joints": cheaper & possible & offered,
    }
    out: list[str] = []
    for p in range(len(possible)):
        names = {why: [CLASSES[k] for k in np.flatnonzero(of[p])] for why, of in found.items()}
        out.append("; ".join(f"not {' or '.join(own)}: {why}" for why, own in names.items() if own))
    return out


def _radii(samples: Samples, carriers: Carriers) -> list[tuple[float, float]]:
    """Smallest and largest bending radius of the carriers over the patches."""
    feet = carriers.project(samples.edges[0].reshape(len(samples), -1, 3))
    return _inverse(np.abs(carriers.curvature(feet)[0]))


def bending_radii(samples: Samples) -> list[tuple[float, float]]:
    """Smallest and largest bending radius of fitted patches, at their samples.

    The normal curvature across a developable's ruling: (n . x_tt) over the squared distance
    across the rulings, at both ends of every ruling.
    """
    rulings = samples.rulings
    curvatures = []
    for side in (0, 1):
        speed, second = samples.edges[1, :, :, side], samples.edges[2, :, :, side]
        normal = unit(cross(speed, rulings))
        across = dot(cross(normal, rulings), speed)
        # II(x_t, x_t) = n . x_tt: along the rulings a developable does not bend.
        curvatures.append(np.abs(dot(normal, second)) / across**2)
    kappa = np.concatenate(curvatures, axis=1)
    return _inverse(kappa)


def _inverse(kappa: Array) -> list[tuple[float, float]]:
    """Radii of the largest and smallest curvature in every row; straight: infinite."""
    tiny = 1e-12
    return [
        (1.0 / high if high > tiny else np.inf, 1.0 / low if low > tiny else np.inf)
        for high, low in zip(kappa.max(axis=1), kappa.min(axis=1), strict=True)
    ]


def bend_lines(samples: Samples, tolerance: float) -> list[str]:
    """Whether the rulings of fitted patches are "parallel", "concurrent" or "free".

    Parallel (a general cylinder) or concurrent (a general cone) when turning each ruling about
    its middle into the common direction, or through the common point, moves its ends by less than
    the tolerance.
    """
    rulings = samples.rulings
    middle = samples.points(np.array([0.5]))[:, :, 0]
    half = np.linalg.norm(samples.edges[0, :, :, 1] - samples.edges[0, :, :, 0], axis=-1) / 2.0
    mean = unit(rulings.mean(axis=1))[:, None]
    parallel = (np.linalg.norm(cross(rulings, mean), axis=-1) * half).max(axis=1)
    # The point closest to all rulings: sum (1 - e e') (x - c) = 0, about the patch's own middle.
    centre = middle.mean(axis=1)
    away = np.eye(3) - rulings[..., :, None] * rulings[..., None, :]
    right = np.einsum("psij,psj->pi", away, middle - centre[:, None])
    matrix = away.sum(axis=1)
    matrix = matrix + 1e-14 * np.trace(matrix, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    apex = centre + np.linalg.solve(matrix, right[..., None])[..., 0]
    towards = unit(middle - apex[:, None])
    concurrent = (np.linalg.norm(cross(rulings, towards), axis=-1) * half).max(axis=1)
    return [
        "parallel" if p <= tolerance else "concurrent" if c <= tolerance else "free"
        for p, c in zip(parallel, concurrent, strict=True)
    ]
