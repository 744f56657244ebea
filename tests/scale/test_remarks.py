"""Remarks of a build: what no verdict covers."""

from __future__ import annotations

import tomllib

from builds import ROOF

from fabgeo.build import design
from fabgeo.build.record import _uncovered, _unfixed
from fabgeo.project import parse_project


def test_a_surface_left_bare_is_told_with_its_share() -> None:
    assert _uncovered(None) == _uncovered(0.995) == ()
    (remark,) = _uncovered(0.375)
    assert "62.5 % of the surface" in remark
    assert "overhang" in remark


def test_panels_without_their_fixings_are_told() -> None:
    """Flanges of 100 mm have no room for fixings 45 mm from the panels' edges."""
    project = parse_project({**tomllib.loads(ROOF), "connectors": {"spacing": 900.0}})
    made = design(project)
    assert made.connectors == ()
    (remark,) = _unfixed(made)
    assert "12 of 12 panels lack fixings, 0 are made in all; P-00-00: no fixing at" in remark
    assert "needs a flange" in remark
