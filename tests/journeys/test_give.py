"""Strips give way towards cheaper panels, within what the project allows."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

from fabgeo.arrays import Array, IntArray
from fabgeo.build import Design, design
from fabgeo.fitting.objectives.base import State
from fabgeo.fitting.objectives.towards import Towards
from fabgeo.fitting.reference import Reference
from fabgeo.fitting.samples import Net, Sites
from fabgeo.project import parse_project

DOME = """
name = "Dome"
[surface]
unit = "m"
u = [-3.0, 3.0]
v = [-4.0, 4.0]
x = "u"
y = "v"
z = "3 - 0.05*u**2 - 0.03*v**2 + 0.004*v**3"
[strips]
count = 4
start = "iso"
[panels]
count = 4
tolerance = 1.0
"""


def built(strips: str = "", panels: str = "") -> Design:
    text = DOME.replace("[panels]", strips + "[panels]") + panels
    return design(parse_project(tomllib.loads(text)))


@pytest.fixture(scope="module")
def before() -> Design:
    return built()


@pytest.fixture(scope="module")
def after() -> Design:
    return built("give = 45.0\n")


def cost(made: Design) -> float:
    return sum(choice.cost for choice in made.choices.values())


@pytest.mark.slow
def test_panels_cost_less_and_the_model_stays_near(before: Design, after: Design) -> None:
    assert cost(after) < cost(before)
    assert after.fit.statistics["deviation_max"] <= 45.0
    assert after.fit.status == "converged"
    assert any(note.startswith("give: panels cost") for note in after.notes)
    assert after.worth["give_panels_cost_after"] < after.worth["give_panels_cost_before"]
    assert after.worth["panels_cost"] == cost(after)
    assert after.worth["panels_cost_bound"] <= cost(after) <= after.worth["panels_cost_one_by_one"]


@pytest.mark.slow
def test_no_room_to_give_changes_nothing(before: Design) -> None:
    tight = built("give = 0.01\n")
    assert np.array_equal(tight.model.control, before.model.control)
    assert any("stays as fitted" in note for note in tight.notes)


@pytest.mark.slow
def test_divided_strips_give_way_too() -> None:
    made = built("give = 45.0\n", "width = 1000.0\n")
    assert made.lanes.strips > made.model.strips
    assert made.worth["give_panels_cost_after"] < made.worth["give_panels_cost_before"]
    assert made.fit.statistics["deviation_max"] <= 45.0


def test_gradients_are_those_of_the_distances(before: Design) -> None:
    control = np.array(before.fit.model.control)
    net = Net.of(before.fit.model)
    reference = Reference(before.start.reference, 1.0)

    class Plane:
        """Of every strip, lane and place its own, all parallel."""

        lanes = np.arange(before.fit.model.strips) % 3 + 1

        def __call__(
            self, strip: IntArray, lane: IntArray, t: Array, points: Array
        ) -> tuple[Array, Array]:
            normal = np.array([0.6, 0.0, 0.8]) + 0.0 * points
            assert np.all(lane < self.lanes[strip])
            return points @ np.array([0.6, 0.0, 0.8]) + strip + t + 0.1 * lane, normal

    term = Towards(Sites.gauss(net, 2), Plane(), 1.0)
    values, gradients = term.evaluate(State(net, control, reference), True)
    step = np.random.default_rng(1).normal(size=control.shape)
    moved = term.evaluate(State(net, control + 1e-3 * step, reference), False)[0]
    ways = Sites.gauss(net, 2).evaluate(step)
    a, b = ways[:-1], ways[1:]
    slope = np.einsum("neqrwk,wneqk->neqr", gradients[0], np.stack([a, b]))
    assert np.allclose((moved - values) / 1e-3, slope, atol=1e-6)
