"""Arguments that are no model, no number of parts, no strip: told by name."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fabgeo.errors import InputError
from fabgeo.strips.draw import draw
from fabgeo.strips.measures import measure
from fabgeo.strips.model import MOST_PARTS, Patch, StripModel
from fabgeo.strips.offset import offset
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.patches import CutRule, cut

U, V = np.meshgrid(np.arange(7.0), np.arange(4.0))
MODEL = StripModel(np.stack([1000.0 * U, 1000.0 * V, 20.0 * U**2], axis=-1), kind="conical")
HOLDER = SimpleNamespace(model=MODEL)
NAN = float("nan")
KNOTS = np.repeat([0.0, 1.0], 4)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: measure(HOLDER), r"found a SimpleNamespace; pass simplenamespace\.model"),
        (lambda: measure(None), "expected a strip model"),
        (lambda: measure(MODEL, "roof.step"), "as_surface"),
        *[(lambda x=x: measure(MODEL, None, x), "per_segment") for x in (0, -1, 1.5, "a", 10**9)],
        (lambda: draw(HOLDER), "expected a strip model"),
        (lambda: draw(MODEL, "roof.step"), "as_surface"),
        (lambda: draw(MODEL, None, 5), "expected measures"),
        (lambda: draw(MODEL, history=5), "history of records"),
        (lambda: draw(MODEL, path=f"{__file__}/a.png"), "cannot be drawn to"),
        (lambda: draw(MODEL, path="/tmp/a.xyz"), r"name a \.png"),
        (lambda: offset(HOLDER, 1.0), "expected a strip model"),
        *[(lambda x=x: offset(MODEL, x), "offset distance") for x in ("a", None, NAN, [1])],
        *[(lambda x=x: offset(MODEL, 1.0, x), "offset tolerance") for x in ("a", 0, NAN)],
        *[
            (lambda x=x: MODEL.edge(x, np.zeros(1)), "edge: expected .* from 0 to 3")
            for x in (99, "a", 1.5)
        ],
        *[(lambda x=x: MODEL.divided(x), "divided") for x in (0, "a", None, [1.5, 1, 1], 10**9)],
        (lambda: MODEL.divided([1, 2]), "3 strips each"),
        (lambda: replace(MODEL, info="abc"), "expected a mapping"),
        *[(lambda x=x: Patch(x, 0, 0.0, 1.0), "patch strip") for x in ("a", None, 1.5, -1)],
        (lambda: Patch(0, 0, 0.0, NAN), "patch u1"),
        (lambda: RuledPatch.of_model(MODEL, Patch(3, 0, 0.0, 1.0)), "strips are 0 to 2"),
        (lambda: RuledPatch(np.repeat([0.0, 1.0], 3), np.zeros((2, 2, 3))), "4 or more an edge"),
        (lambda: RuledPatch.through(KNOTS, np.zeros(4), *np.zeros((2, 4, 3))), "no curve runs"),
        (lambda: CutRule(count=10**9), "CutRule.count.*from 1 to 100,000"),
        (lambda: CutRule(length=NAN), "CutRule.length"),
        (lambda: CutRule(at=(1.0, 1.0)), "cuts: hold a parameter twice"),
        (lambda: cut(MODEL, CutRule(length=1e-6)), "panels.length.*more than 100,000 panels"),
        (lambda: cut(MODEL, CutRule(length=1e-320)), "panels.length"),
    ],
)
def test_wrong_arguments_are_named(call, words: str) -> None:
    with pytest.raises(InputError, match=words):
        call()


def test_panels_of_all_strips_together_are_bounded() -> None:
    many = MODEL.divided(4)  # 12 strips
    with pytest.raises(InputError, match="1,000,000 panels at most, found more on 12 strips"):
        cut(many, CutRule(count=100_000))
    with pytest.raises(InputError, match="from 1 to 10,000"):
        many.divided(MOST_PARTS + 1)
    with pytest.raises(InputError, match="100,000 parts at most, found 120,000"):
        many.divided(MOST_PARTS)
