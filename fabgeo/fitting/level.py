"""One level of a fit: a net with its sites, and the problem of each stage on it."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array
from fabgeo.fitting.folds import regular
from fabgeo.fitting.held import Held
from fabgeo.fitting.normal import NormalEquations
from fabgeo.fitting.objectives.anchor import Anchor
from fabgeo.fitting.objectives.base import Objective, State
from fabgeo.fitting.objectives.boundary import Boundary
from fabgeo.fitting.objectives.cover import Cover
from fabgeo.fitting.objectives.developable import Developable
from fabgeo.fitting.objectives.even_widths import EvenWidths
from fabgeo.fitting.objectives.fair_edges import FairEdges
from fabgeo.fitting.objectives.fair_rulings import FairRulings
from fabgeo.fitting.objectives.points import MountingPoints, closest_sites
from fabgeo.fitting.objectives.proximity import EdgeProximity, MiddleProximity
from fabgeo.fitting.objectives.towards import Towards
from fabgeo.fitting.options import FitOptions
from fabgeo.fitting.problem import StripProblem
from fabgeo.fitting.quality import KIND_TERM, dense_sites
from fabgeo.fitting.reference import Reference, Tracker
from fabgeo.fitting.samples import Net, Sites
from fabgeo.strips.model import Kind

UNFOLDED = 0.2  # cosine between a ruling's two normals that steps keep, where the start has it
COVER_MARGIN = 0.05  # in mean ruling lengths: how far overhanging ends stay beyond the boundary
KEPT = 0.5  # the same: farther beyond the boundary, proximity counts less and less


class Level:
    """What stays the same while only weights change: sites, patterns, normal equations."""

    def __init__(
        self, net: Net, reference: Reference, kind: Kind, options: FitOptions, held: Held
    ) -> None:
        self.net, self.reference = net, reference
        self.kind: Kind = kind
        self.options, self.held = options, held
        self.fine, self.coarse = Sites.chebyshev(net, 3), Sites.gauss(net, 2)
        self.dense = dense_sites(net)
        self.ends = [] if net.closed_u else [Sites.at_end(net, False), Sites.at_end(net, True)]
        self.fairness = 1.0  # multiplies the weights of what only makes a model even
        self.importance: dict[str, Array] = {}
        self.trackers: dict[int, Tracker] = {}
        self._equations: NormalEquations | None = None

    def state(self, control: Array) -> State:
        """The evaluated model."""
        return State(self.net, control, self.reference)

    def refined(self, net: Net) -> Level:
        """The level of twice as many segments, with the same importance of every place."""
        finer = Level(net, self.reference, self.kind, self.options, self.held)
        finer.fairness = self.fairness
        for name, share in self.importance.items():  # of two sites in each span: one in each half
            halves = share.reshape(len(share), -1, 1)
            finer.importance[name] = np.broadcast_to(halves, (*halves.shape[:2], 2))
        return finer

    def problem(
        self, control: Array, start: Array, developability: float, anchor: float
    ) -> StripProblem:
        """The functional with its weights; normals for fairness are taken at `control`."""
        objectives = self._objectives(control, start, developability, anchor)
        nearest = float(regular(self.state(control), self.dense).min())
        fold_sites = self.coarse, self.dense, min(UNFOLDED, 0.9 * nearest)
        return StripProblem(self.net, self.reference, objectives, fold_sites, self.trackers)

    def stress(self, control: Array, power: float = 2.0, floor: float = 0.1) -> None:
        """Give far places more importance in proximity, so that the largest deviation shrinks.

        One round of iteratively reweighted least squares towards the norm of order 2 + `power`,
        from the importance of the round before.
        """
        state = State(self.net, control, self.reference, self.trackers)
        terms = EdgeProximity(self.coarse), MiddleProximity(self.coarse)
        values = [
            np.abs(term.evaluate(state, False)[0][..., 0]) * np.sqrt(kept)
            for term, kept in zip(terms, self._kept(state, self.coarse), strict=True)
        ]
        largest = max(float(v.max()) for v in values)
        wanted = [(v / largest) ** power for v in values]
        mean = float(np.mean(np.concatenate([w.ravel() for w in wanted])))
        for term, share in zip(terms, wanted, strict=True):
            before = self.importance.get(term.name, np.ones_like(share))
            self.importance[term.name] = np.sqrt(before * np.maximum(share / mean, floor))

    def equations(self, problem: StripProblem) -> NormalEquations:
        """The normal equations, whose pattern is the same for all stages of the level."""
        if self._equations is None:
            self._equations = NormalEquations(
                problem.stencils, problem.node_count, 3, self.options.solver
            )
        return self._equations

    @property
    def solver(self) -> str:
        """How the normal equations are solved."""
        return self._equations.method if self._equations else "none"

    def _objectives(
        self, control: Array, start: Array, developability: float, anchor: float
    ) -> list[Objective]:
        weights = self.options.weights
        state = State(self.net, control, self.reference, self.trackers)
        normals = state.feet(self.coarse)[0].normal
        step = float(np.linalg.norm(state.at(self.coarse, 1), axis=-1).mean())
        terms: list[tuple[Objective, float]] = [
            (Developable(self.fine), developability),
            *((term, weights.proximity) for term in self._proximity(state, self.coarse)),
            (
                FairEdges(self.coarse, normals, step, weights.normal_share),
                self.fairness * weights.fair_edges,
            ),
            (Anchor(self.coarse, self.coarse.evaluate(start), normals), anchor),
        ]
        if len(self.net.windows(3)):
            fair = FairRulings(self.coarse, normals, weights.normal_share)
            terms += [
                (fair, self.fairness * weights.fair_rulings),
                (EvenWidths(self.coarse), self.fairness * weights.widths),
            ]
        if self.kind in KIND_TERM:
            term = KIND_TERM[self.kind](self.fine)
            if len(term.window):
                terms.append((term, developability))
        for sites in self.ends:  # the outermost rulings, as long as half a span
            share = 0.5 * weights.proximity / self.net.segments
            terms += [(term, share) for term in self._proximity(state, sites)]
        terms += [(term, weights.boundary) for term in self._boundary(normals, state)]
        terms += [(term, weights.cover) for term in self._cover(start)]
        if self.options.points is not None and len(self.options.points):
            points = np.asarray(self.options.points) / self.reference.length
            edges, u = closest_sites(self.net, control, points)
            terms.append((MountingPoints(self.net, edges, u, points), weights.points))
        if self.options.towards is not None:
            drawn = Towards(self.coarse, self.options.towards, self.reference.length)
            terms.append((drawn, weights.towards))
        for term, weight in terms:
            term.weight = weight
        return [term for term, _ in terms]

    def _proximity(self, state: State, sites: Sites) -> list[Objective]:
        """Proximity of edges and of rulings' middles, each place with its importance."""
        terms: list[Objective] = [EdgeProximity(sites), MiddleProximity(sites)]
        stress = self.importance if sites is self.coarse else {}
        for term, kept in zip(terms, self._kept(state, sites), strict=True):
            term.importance = kept * stress.get(term.name, 1.0)
        return terms

    def _kept(self, state: State, sites: Sites) -> list[Array | float]:
        """How much proximity counts at edges and at middles: all on the surface, little beside it.

        What overhangs is cut off. A continuation bends otherwise from where it leaves one side of
        the boundary than from the next: drawn to it, strips are held off the surface along their
        whole length, as rulings and edges pass on what happens there, and outer edges pinch.
        General models mostly have the freedom to follow it.
        """
        choice = self.options.continuation
        follows = self.kind == "general" if choice == "auto" else choice == "followed"
        if follows or not state.reference.continued:
            return [1.0, 1.0]
        far = (np.maximum(foot.beyond / KEPT - 1.0, 0.0) for foot in state.feet(sites))
        return [(1.0 + r**2) ** -2 for r in far]

    def _cover(self, start: Array) -> list[Objective]:
        """One term for each part of the start's border that overhangs the boundary."""
        if not self.options.weights.cover:
            return []
        every = np.arange(self.net.edges)
        parts = [(s, every) for k, s in enumerate(self.ends) if k not in self.held.ends]
        if not self.net.closed_i:
            outer = (0, self.net.edges - 1)
            parts += [(self.coarse, every[[k]]) for k in outer if k not in self.held.edges]
        terms: list[Objective] = []
        for sites, edges in parts:
            points = sites.evaluate(start)[edges]
            out = self.reference.outwards(points)
            beyond = np.linalg.norm(out, axis=-1, keepdims=True)
            out = np.where(beyond > COVER_MARGIN, out / np.maximum(beyond, COVER_MARGIN), 0.0)
            if out.any():
                room = np.maximum(beyond[..., 0] - COVER_MARGIN, 0.0)
                terms.append(Cover(sites, edges, points, out, room))
        return terms

    def _boundary(self, normals: Array, state: State) -> list[Objective]:
        share = self.options.weights.boundary_normal_share
        terms: list[Objective] = []
        for edge, side in self.held.edges.items():
            window = np.array([edge])
            terms.append(Boundary(self.coarse, window, side, normals[window], share))
        window = np.arange(self.net.edges)
        for end, side in self.held.ends.items():
            near = normals[:, [0 if end == 0 else -1]][:, :, [0 if end == 0 else -1]]
            terms.append(Boundary(self.ends[end], window, side, near, share))
        return terms
