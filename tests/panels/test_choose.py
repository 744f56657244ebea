"""The joint choice keeps its limits, measured again from the made panels alone."""

from __future__ import annotations

import pickle
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from panel_patches import cone_strips, panels_of
from scipy.sparse import csr_array

from fabgeo import spline
from fabgeo.errors import InputError
from fabgeo.panels.choose import JointChoice, choose
from fabgeo.panels.classify import classify, distinct_radii
from fabgeo.panels.forming import Sheet, beyond_standards, forming_of
from fabgeo.panels.groups import strips_of, windows_of
from fabgeo.panels.highs import Programme, solved
from fabgeo.panels.joints import joints_of
from fabgeo.panels.limits import Costs, Tolerances
from fabgeo.panels.pool import CLASSES
from fabgeo.panels.radii import fewest
from fabgeo.panels.samples import PanelInput
from fabgeo.panels.shapes import Cylinder
from fabgeo.panels.tradeoff import plot, table, trade_off
from fabgeo.strips.model import StripModel
from fabgeo.strips.ruled import RuledPatch

LIMITS = Tolerances(deviation_mm=3.0, kink_deg=1.0, gap_mm=2.0)


@pytest.fixture(scope="module")
def panels() -> list[PanelInput]:
    return panels_of(cone_strips(), 6)


@pytest.fixture(scope="module")
def chosen(panels: list[PanelInput]) -> JointChoice:
    return choose(panels, LIMITS, rounds=2)


def boundary(patch: RuledPatch, side: str) -> tuple[np.ndarray, np.ndarray]:
    """Points and normals along one side of a patch, from the patch alone."""
    v = {"first": 0.0, "second": 1.0}.get(side)
    if v is None:
        t = np.linspace(0.0, 1.0, 801)
        u = np.full(801, patch.u0 if side == "start" else patch.u1)
    else:
        u, t = np.linspace(patch.u0, patch.u1, 801), np.full(801, v)
    points = patch.points(u, t)
    speed = patch.edges(u, 1)
    ends = patch.edges(u)
    x_u = speed[0] + t[:, None] * (speed[1] - speed[0])
    normal = np.cross(x_u, ends[1] - ends[0])
    return points, normal / np.linalg.norm(normal, axis=-1, keepdims=True)


def between(p: np.ndarray, q: np.ndarray, side: str) -> np.ndarray:
    """Vectors from one boundary to the other, of edges from the nearest point to the curve."""
    if side in ("start", "end"):  # straight lines that begin and end together
        return p - q
    p = p[8:-8:8]  # where the other surely runs beside it
    nearest = np.linalg.norm(p[:, None] - q, axis=-1).argmin(axis=1)
    tangent = np.gradient(q, axis=0)[nearest]
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    away = p - q[nearest]
    return away - (away * tangent).sum(-1)[:, None] * tangent


ACROSS = {"first": "second", "second": "first", "start": "end", "end": "start"}


def test_limits_hold_between_made_panels(panels: list[PanelInput], chosen: JointChoice) -> None:
    made = {c.mark: c for c in chosen.panels}
    for panel in panels:
        own = made[panel.mark]
        for side in panel.neighbours:
            for mark in panel.beyond(side):
                other = made[mark]
                p, n = boundary(own.made, side)
                q, m = boundary(other.made, ACROSS[side])
                f, g = (
                    boundary(panel.patch, side)[1],
                    boundary(other.fitted, ACROSS[side])[1],
                )
                gap = np.linalg.norm(between(p, q, side), axis=-1).max()
                assert gap <= LIMITS.gap_mm * 1.01
                assert gap <= own.gap_mm * 1.01 + 0.01
                kink = np.degrees(np.arccos(np.clip((n * m).sum(-1), -1, 1)))
                before = np.degrees(np.arccos(np.clip((f * g).sum(-1), -1, 1)))
                assert np.abs(kink - before).max() <= LIMITS.kink_deg + 0.06


def test_costs_and_bounds_are_in_order(chosen: JointChoice) -> None:
    prices = Costs()
    assert chosen.cost == sum(getattr(prices, c.cls) for c in chosen.panels)
    assert chosen.floor <= chosen.bound + 1e-6
    assert chosen.bound <= chosen.cost + 1e-6
    assert chosen.cost <= chosen.one_by_one
    assert all(c.bound_mm <= LIMITS.deviation_mm for c in chosen.panels)
    assert all(c.kink_added_deg <= LIMITS.kink_deg for c in chosen.panels)


def test_panel_by_panel_keeps_the_same_limits(panels: list[PanelInput]) -> None:
    alone = classify(panels, LIMITS)
    assert all(c.gap_mm <= LIMITS.gap_mm for c in alone)
    assert all(c.kink_added_deg <= LIMITS.kink_deg for c in alone)


def test_neighbours_are_checked(panels: list[PanelInput]) -> None:
    far = PanelInput("P-X", panels[0].patch, {"first": panels[-1].mark})
    with pytest.raises(InputError, match=r"P-X.*lies .* mm from"):
        classify([far, panels[-1]])
    with pytest.raises(InputError, match="names a neighbour P-Y"):
        classify([PanelInput("P-X", panels[0].patch, {"first": "P-Y"})])


@pytest.mark.parametrize("apart", [1.5, 3.0])
def test_short_neighbours_may_lie_apart_as_whole_ones_do(apart: float) -> None:
    """Pieces of 0.3 m beside each other, at a height above a general model."""
    knots, sites = np.repeat([0.0, 300.0], 4), np.linspace(0.0, 300.0, 4)
    edge = np.column_stack([sites, np.zeros((4, 2))])
    one = RuledPatch.through(knots, sites, edge, edge + np.array([0.0, 900.0, 0.0]))
    beyond = edge + np.array([0.0, 900.0 + apart, 0.0])
    other = RuledPatch.through(knots, sites, beyond, beyond + np.array([0.0, 900.0, 0.0]))
    joints = joints_of([PanelInput("A", one, {"second": "B"}), PanelInput("B", other)])
    assert len(joints) == 1
    with pytest.raises(InputError, match=r"A.*lies 900 mm from side 'second'"):
        joints_of([PanelInput("A", one, {"first": "B"}), PanelInput("B", one)])


def test_fewest_radii_serve_all_and_no_fewer_could() -> None:
    rng = np.random.default_rng(3)
    curvature, slack = rng.uniform(1e-4, 3e-4, 60), rng.uniform(2e-6, 2e-5, 60)
    offered = 1.0 / fewest(curvature, slack)
    assert np.all((np.abs(curvature[:, None] - offered) <= slack[:, None] * (1 + 1e-9)).any(axis=1))
    # Disjoint intervals need a radius each: as many as radii were found.
    low, high = curvature - slack, curvature + slack
    disjoint, end = 0, -np.inf
    for i in np.argsort(high):
        if low[i] > end:
            disjoint, end = disjoint + 1, high[i]
    assert len(offered) == disjoint
    served = (np.abs(curvature[:, None] - 1.0 / fewest(curvature, slack, 3)) <= slack[:, None]).any(
        axis=1
    )
    assert 3 <= served.sum() < 60


def test_more_radii_than_needed_come_nearer() -> None:
    rng = np.random.default_rng(3)
    curvature, slack = rng.uniform(1e-4, 3e-4, 60), rng.uniform(2e-6, 2e-5, 60)

    def used(most: int | None) -> float:
        """The largest share of its slack that a cylinder uses at its nearest radius."""
        offered = 1.0 / fewest(curvature, slack, most)
        assert most is None or len(offered) <= most
        return float((np.abs(curvature[:, None] - offered) / slack[:, None]).min(axis=1).max())

    needed = len(fewest(curvature, slack))
    shares = [used(most) for most in (None, needed + 3, 2 * needed, 60)]
    assert np.all(np.diff(shares) < 0.0)
    assert shares[0] <= 1.0 + 1e-9
    assert shares[-1] == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize(("count", "shift"), [(2, 0), (2, 1), (3, 2)])
def test_windows_are_neighbours_and_no_strip_is_in_two(
    panels: list[PanelInput], count: int, shift: int
) -> None:
    joints = joints_of(panels)
    groups = strips_of(len(panels), joints)
    windows = windows_of(groups, joints, count, shift)
    every = np.concatenate(windows)
    assert len(np.unique(every)) == len(every) >= len(groups) - 2
    label = np.empty(len(panels), dtype=np.int64)
    for k, group in enumerate(groups):
        label[group] = k
    beside = {tuple(sorted(pair)) for pair in label[joints.panels].tolist()}
    for window in windows:
        assert 2 <= len(window) <= count
        assert all(tuple(sorted(p)) in beside for p in pairwise(window))


@pytest.mark.slow
def test_few_radii(panels: list[PanelInput]) -> None:
    found = choose(panels, LIMITS, rounds=1, radii=2)
    assert distinct_radii(found.panels) <= 2
    assert all(c.gap_mm <= LIMITS.gap_mm for c in found.panels)


@pytest.mark.slow
def test_offered_radii_cost_no_more_where_a_free_choice_has_them(panels: list[PanelInput]) -> None:
    """Cylinders of offered radii settle with their neighbours as others do."""
    free = choose(panels, LIMITS, rounds=1)
    own = [c.shape.radius for c in free.panels if isinstance(c.shape, Cylinder)]
    assert len(own) > 3
    found = choose(panels, LIMITS, rounds=1, radii=own)
    assert found.cost <= free.cost
    rolled = [c.shape.radius for c in found.panels if isinstance(c.shape, Cylinder)]
    assert np.abs(np.array(rolled)[:, None] / own - 1.0).min(axis=1).max() < 1e-9
    assert choose(panels, LIMITS, rounds=1, radii_step=250.0).cost <= 1.03 * free.cost


def test_reasons_name_what_excludes_cheaper_classes(chosen: JointChoice) -> None:
    assert all("flat: beyond the deviation" in c.reason for c in chosen.panels)


def test_springing_radius_is_the_published_one() -> None:
    """Hand-over table: 296 t for S355, 269 t for 5754-H22 (E 210 and 70 GPa, f_y 355, 130)."""
    assert Sheet(1.0, 210000.0, 355.0).springing_radius == pytest.approx(296, abs=0.5)
    assert Sheet(1.0, 70000.0, 130.0).springing_radius == pytest.approx(269, abs=0.5)
    sheet = Sheet(4.0, 70000.0, 130.0, rolls=300.0)
    assert forming_of("cylinder", 1100.0, sheet)[0] == "spring"
    assert forming_of("cylinder", 1000.0, sheet)[0] == "roll"
    assert forming_of("developable", 1000.0, sheet)[0] == "press"
    assert forming_of("cylinder", 200.0, sheet)[0] == "press"


def test_glass_springs_or_is_bent_hot_and_is_flagged_unless_a_cylinder() -> None:
    sheet = Sheet(6.0, 70000.0, 23.3, glass=True)
    assert [forming_of(c, 10000.0, sheet)[0] for c in ("cylinder", "cone")] == ["spring"] * 2
    assert [forming_of(c, 8000.0, sheet)[0] for c in ("cylinder", "cone")] == ["press"] * 2
    flagged = [bool(beyond_standards(c, sheet)) for c in CLASSES]
    assert flagged == [False, False, True, True]
    assert not any(beyond_standards(c, Sheet()) for c in CLASSES)


@pytest.mark.slow
def test_wider_tolerances_cost_no_more(panels: list[PanelInput], tmp_path) -> None:
    rows = list(trade_off(panels, (0.3, 3.0), (0.5, 3.0), rounds=1))
    cost = np.array([r.cost for r in rows]).reshape(2, 2)
    assert np.all(np.diff(cost, axis=0) <= 0.0)
    assert np.all(np.diff(cost, axis=1) <= 0.0)
    assert np.all([r.floor <= r.cost <= r.one_by_one for r in rows])
    assert len(table(rows).splitlines()) == 6
    assert plot(rows, tmp_path / "tradeoff.png").stat().st_size > 5000


@pytest.mark.slow
def test_radii_are_multiples_of_a_step() -> None:
    """Strips of a vault with parallel rulings and a varying radius: all can be cylinders."""
    i, u = np.arange(3)[:, None] + np.zeros(25), np.linspace(-0.3, 0.3, 25) + np.zeros((3, 1))
    r = 20000.0 + 1000.0 * np.sin(9.0 * u)
    points = np.stack([r * np.sin(u), 1500.0 * i, r * np.cos(u)], axis=-1)
    panels = panels_of(StripModel(spline.interpolate(points)), 6)
    found = choose(panels, Tolerances(6.0, 3.0, 6.0), rounds=1, radii=2, radii_step=250.0)
    rolled = {round(c.shape.radius, 6) for c in found.panels if isinstance(c.shape, Cylinder)}
    assert 1 <= len(rolled) <= 2
    assert all(radius % 250.0 == pytest.approx(0.0, abs=1e-5) for radius in rolled)


def test_no_choice_undercuts_the_bound(panels: list[PanelInput]) -> None:
    """Two routes: the strips' programmes, and every choice of classes that sweeps can place."""
    strip = [p for p in panels if p.mark.startswith("P-02")]
    alone = [
        PanelInput(
            p.mark, p.patch, {s: m for s, m in p.neighbours.items() if s in ("start", "end")}
        )
        for p in strip
    ]
    found = choose(alone, LIMITS, rounds=2)
    assert found.floor <= found.bound + 1e-6 <= found.among + 2e-6
    assert 0.0 <= found.saving <= found.most + 1e-9


@pytest.mark.slow
def test_threads_change_nothing(panels: list[PanelInput], chosen: JointChoice) -> None:
    again = choose(panels, LIMITS, rounds=2, jobs=2)
    assert again.history == chosen.history
    assert again.bound == chosen.bound
    assert [pickle.dumps(c.made) for c in again.panels] == [
        pickle.dumps(c.made) for c in chosen.panels
    ]


@pytest.mark.parametrize("seed", range(6))
def test_branching_here_finds_what_highs_finds(seed: int) -> None:
    """Two routes to the least cost of random choices with continuous steps."""
    rng = np.random.default_rng(seed)
    sets, options, steps = 6, 4, 2
    n = sets * options
    prices = np.tile([1.0, 2.0, 3.0, 5.0], sets)
    one = np.hstack([np.kron(np.eye(sets), np.ones(options)), np.zeros((sets, steps))])
    limits = rng.normal(size=(90, n + steps)) * (rng.random((90, n + steps)) < 0.4)
    limits[:, 3:n:options] = 0.0  # the dearest option is always open
    high = np.concatenate([np.ones(sets), np.full(90, 0.9)])
    low = np.concatenate([np.ones(sets), np.full(90, -np.inf)])
    whole = np.arange(n + steps) < n
    cost = np.concatenate([prices, np.zeros(steps)])
    lower = np.where(whole, 0.0, -1.0)
    given = Programme(
        cost,
        csr_array(np.vstack([one, limits])),
        low,
        high,
        lower,
        np.ones(n + steps),
        whole,
        nodes=500,
    )
    here, there = solved(given), solved(replace(given, small=False))
    assert here.status == there.status == "optimal"
    assert here.x is not None
    assert cost @ here.x == pytest.approx(here.bound)
    assert here.bound == pytest.approx(there.bound, rel=2e-4)
    cut = solved(replace(given, nodes=1))
    assert cut.bound <= here.bound + 1e-9


def test_ends_stay_near_the_fitted_ones(panels: list[PanelInput], chosen: JointChoice) -> None:
    for choice in chosen.panels:
        for made, fitted in zip(
            choice.made.edges(np.array([choice.made.u0, choice.made.u1])).reshape(-1, 3),
            choice.fitted.edges(np.array([choice.fitted.u0, choice.fitted.u1])).reshape(-1, 3),
            strict=True,
        ):
            off = np.linalg.norm(made - fitted)
            assert off <= np.hypot(LIMITS.ends_mm, LIMITS.deviation_mm) * 1.01
