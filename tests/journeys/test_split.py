"""Parts too long for every sheet, divided at rulings from the design on."""

from __future__ import annotations

import tomllib
from itertools import pairwise

import numpy as np
import pytest

from fabgeo.build import Design, design
from fabgeo.build.flats import flats_of, refuse_oversize
from fabgeo.errors import InputError
from fabgeo.panels.flat import FlatPart
from fabgeo.panels.unfold import smallest_rectangle
from fabgeo.project import parse_project

ROOF = """
name = "Roof"
[surface]
unit = "m"
u = [-0.30, 0.30]
v = [-0.45, 0.45]
x = "8*cos(v) * sin(u)"
y = "8*sin(v)"
z = "8*cos(v) * cos(u)"
[strips]
kind = "conical"
count = 4
start = "iso"
direction = "v"
segments = 6
[panels]
count = 1
choice = "single"
[cells]
depth = -150.0
walls = true
[beams]
depth = 140.0
flange_width = 100.0
weld_gap = 2.0
[nesting]
split = true
[[stock]]
material = "aluminium"
length = 3000.0
width = 1500.0
[[stock]]
material = "steel"
length = 3000.0
width = 1000.0
"""


@pytest.fixture(scope="module")
def made() -> Design:
    return design(parse_project(tomllib.loads(ROOF)))


@pytest.fixture(scope="module")
def flats(made: Design) -> dict[str, FlatPart]:
    return flats_of(made.project, made.plates)


def size(part: FlatPart) -> tuple[float, float]:
    _, length, width = smallest_rectangle(np.concatenate([e.points for e in part.outline]))
    return length, width


def test_every_piece_fits_its_sheet(made: Design, flats: dict[str, FlatPart]) -> None:
    for part in flats.values():
        length, width = size(part)
        assert length <= 2980.0
        assert width <= (1480.0 if part.material == "aluminium" else 980.0)
    refuse_oversize(made.project, made.plates, flats)


def test_cuts_of_panels_run_through_the_cells(made: Design) -> None:
    cuts = [[(p.u0, p.u1) for p in made.patches if p.strip == s] for s in range(4)]
    assert len(cuts[0]) > 1
    assert all(row == cuts[0] for row in cuts)
    marks = [f"P-{s:02d}-{c:02d}" for s in range(4) for c in range(len(cuts[0]))]
    assert [panel.mark for panel in made.panels] == marks
    assert len(made.cells) == len(made.panels)
    assert made.panels[0].shared["end"] == "P-00-01"


def test_pieces_of_a_beam_meet_but_for_the_weld(made: Design, flats: dict[str, FlatPart]) -> None:
    webs = [plate for plate in made.beams[0].plates if plate.role == "web"]
    assert [web.mark for web in webs] == ["B-00-1-WEBa", "B-00-1-WEBb", "B-00-1-WEBc"]
    for one, other in pairwise(webs):
        assert (one.shared["end"], other.shared["start"]) == (other.mark, one.mark)
        ends = one.mid.edges(np.array([one.mid.u1]))[:, 0]
        starts = other.mid.edges(np.array([other.mid.u0]))[:, 0]
        gap = np.linalg.norm(starts - ends, axis=-1)
        assert gap.mean() == pytest.approx(2.0, abs=0.02)
        assert np.ptp(gap) < 0.1
        end = next(e for e in flats[one.mark].outline if e.name == "end")
        start = next(e for e in flats[other.mark].outline if e.name == "start")
        assert end.length == pytest.approx(start.length, abs=0.1)


def test_without_it_they_are_refused_by_name() -> None:
    project = parse_project(tomllib.loads(ROOF.replace("split = true", "seconds = 1.0")))
    whole = design(project)
    flats = flats_of(project, whole.plates)
    with pytest.raises(InputError, match="larger than every sheet"):
        refuse_oversize(project, whole.plates, flats)
