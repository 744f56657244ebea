"""Remarks of a build: what no verdict covers."""

from __future__ import annotations

from fabgeo.build.record import _uncovered


def test_a_surface_left_bare_is_told_with_its_share() -> None:
    assert _uncovered(None) == _uncovered(0.995) == ()
    (remark,) = _uncovered(0.375)
    assert "62.5 % of the surface" in remark
    assert "overhang" in remark
