"""FreeCAD opens what is written: every part valid, closed, under its mark, of its volume."""

from __future__ import annotations

import pytest
from freecad import open_step
from test_step import parts, roof, written  # noqa: F401 - fixtures


@pytest.mark.freecad
def test_freecad_sees_every_part(written, parts, tmp_path):  # noqa: F811
    view = open_step(written, tmp_path)
    assert len(view.parts) == len(parts)
    assert all(p.valid and p.closed and p.solids == 1 for p in view.parts)
    labels = {p.label for p in view.parts} | set(view.groups)
    assert {"C-00-00", "C-00-01", "C-00-02", "P-00-00"} <= labels
    assert {"K-00-00-0", "K-00-00-1", "K-00-00-2"} <= labels
    assert {"cells", "panels", "connectors"} <= labels
    ours = sorted(p.report.volume for p in parts)
    theirs = sorted(p.volume for p in view.parts)
    assert theirs == pytest.approx(ours, rel=2e-6)  # its default integral is off by 7e-7
