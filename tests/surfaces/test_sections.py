"""Sections: reading, checks, correspondence, and the surface through them."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fabgeo.errors import FabgeoError, InputError
from fabgeo.surfaces.loft import SectionSurface
from fabgeo.surfaces.sectionfile import parse_csv, parse_json, read_sections
from fabgeo.surfaces.sections import checked_sections


def ellipse(z, a=15.0, b=11.0, turn=0.0, count=60, start=0.0):
    t = start + 2 * np.pi * np.arange(count) / count
    x, y = a * np.cos(t), b * np.sin(t)
    c, s = np.cos(turn), np.sin(turn)
    return np.column_stack([c * x - s * y, s * x + c * y, np.full(count, float(z))])


def test_tower_fixture(fixtures):
    sections = read_sections(fixtures / "tower" / "sections.csv")
    assert len(sections.points) == 13
    assert sections.closed
    assert sections.convex
    assert sections.normal.tolist() == [0.0, 0.0, 1.0]
    assert np.ptp(sections.points[0], axis=0)[:2] == pytest.approx([30.0, 22.0], abs=1e-4)
    surface = SectionSurface(sections, "tower")
    assert surface.correspondence == "parallel tangents"
    assert len(surface.loops) == 2
    given = np.concatenate(sections.points)
    assert np.abs(surface.closest(given).point - given).max() < 1e-4  # 0.1 mm of 56 m


def test_parallel_tangents_correspond():
    sections = checked_sections(
        "s", [ellipse(3.5 * k, 15 - k, 11 - k / 2, 0.1 * k) for k in range(5)]
    )
    grid = sections.grid(400)
    tangent = np.roll(grid, -1, axis=1) - np.roll(grid, 1, axis=1)
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    angle = np.degrees(np.arccos(np.clip((tangent[0] * tangent).sum(axis=-1), -1, 1)))
    assert angle.max() < 0.5


def test_a_cone_is_found_again():
    """Circles of linearly growing radius: the loft is the cone, with its curvature."""
    sections = checked_sections(
        "cone", [ellipse(z, 10 - z, 10 - z, start=0.3 * z) for z in range(5)]
    )
    surface = SectionSurface(sections)
    at = surface.sample(1000)
    radius = np.hypot(at.point[:, 0], at.point[:, 1])
    assert np.abs(radius - (10 - at.point[:, 2])).max() < 1e-3
    kappa, _ = at.principal()
    assert np.abs(kappa[:, 1]).max() < 1e-3
    assert kappa[:, 0] == pytest.approx(-np.sqrt(0.5) / radius, rel=0.01)


def test_levels_between_sections_are_planar_and_z_is_u():
    sections = checked_sections("s", [ellipse(z, 12 + np.sin(z), 9) for z in (0.0, 3.0, 7.0, 9.0)])
    surface = SectionSurface(sections)
    v = np.linspace(*surface.charts[0].domain[1], 50)
    assert surface.evaluate(np.full(50, 4.2), v).point[:, 2] == pytest.approx(4.2)


def test_sections_that_are_not_convex_go_by_arc_length():
    t = 2 * np.pi * np.arange(80) / 80
    r = 10 + 3 * np.cos(3 * t)
    flower = [np.column_stack([r * np.cos(t), r * np.sin(t), np.full(80, z)]) for z in (0.0, 4.0)]
    flower[1] = np.roll(flower[1], 17, axis=0)  # another starting point
    surface = SectionSurface(checked_sections("flower", flower))
    assert surface.correspondence == "arc length"
    grid = surface.section_grid(60)
    assert (
        np.abs(grid[0, :, :2] - grid[1, :, :2]).max() < 0.3
    )  # straight up, within the start's step


def test_open_sections():
    x = np.linspace(-10, 10, 30)
    arches = [np.column_stack([x, np.full(30, y), 6 - x**2 / (30 + y)]) for y in (0.0, 5.0, 10.0)]
    arches[1] = arches[1][::-1]  # drawn the other way
    sections = checked_sections("arches", arches)
    assert not sections.closed
    surface = SectionSurface(sections)
    assert len(surface.loops) == 1
    assert np.abs(surface.closest(arches[1]).point - arches[1]).max() < 2e-3


@pytest.mark.parametrize(
    ("curves", "message"),
    [
        ([ellipse(0)], "two sections or more"),
        ([ellipse(0), ellipse(0)], "lie in one plane"),
        (
            [ellipse(0), ellipse(3)[::2][[0, 3, 1, 4, 2, *range(5, 30)]]],
            "section 1: crosses itself",
        ),
        ([ellipse(0), ellipse(3) + np.outer(np.sin(np.arange(60.0)), [0, 0, 1])], "not planar"),
        ([ellipse(0), ellipse(3) @ np.array([[1, 0, 0.2], [0, 1, 0], [-0.2, 0, 1]])], "parallel"),
        ([ellipse(0), ellipse(3)[:30]], "open or all closed"),
        ([ellipse(0), ellipse(3)[:1]], "needs two points or more"),
        ([ellipse(0) * [1, 0, 1], ellipse(3) * [1, 0, 1]], "straight|crosses"),
    ],
)
def test_bad_sections(curves, message):
    with pytest.raises(InputError, match=message):
        checked_sections("slabs", curves)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x,y,z\n1,2,3\n", "line 1: expected a header .* section is missing"),
        ("section,x,y,z\na,1,2\n", "line 2: expected 4 columns"),
        ("section,x,y,z\na,1,2,nan\n", "line 2: a coordinate is not finite"),
        ("section,x,y,z\na,1,two,3\n", "line 2: expected numbers"),
    ],
)
def test_bad_csv_names_the_line(text, message):
    with pytest.raises(InputError, match=message):
        parse_csv("slabs.csv", text)


def test_json_sections(tmp_path):
    path = tmp_path / "slabs.json"
    floors = [{"z": z, "points": ellipse(z)[:, :2].tolist(), "name": f"L{z}"} for z in (0, 4)]
    path.write_text(json.dumps({"sections": floors}))
    sections = read_sections(path)
    assert sections.names == ("L0", "L4")
    assert sections.heights.tolist() == [0.0, 4.0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "is not JSON"),
        ("3", "expected a list of sections"),
        ('[{"points": [[1, 2]]}]', 'has no z, and the section has no "z"'),
        ('[{"points": [[1, "b", 3]]}]', "expected numbers"),
        ('[{"points": [[1, NaN, 3]]}]', "not finite"),
        ("[" * 100000, "is not JSON"),
    ],
)
def test_bad_json(text, message):
    with pytest.raises(InputError, match=message):
        parse_json("slabs.json", text)


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(max_size=3),
    lambda x: (
        st.lists(x, max_size=4) | st.dictionaries(st.sampled_from(["z", "points", "name"]), x)
    ),
    max_leaves=12,
)


@settings(max_examples=150, deadline=None)
@given(st.text(alphabet='section,xyz;0123456789.-e\n"', max_size=80), JSON)
def test_section_readers_answer_or_refuse(text, content):
    for parse, given_text in (
        (parse_csv, text),
        (parse_csv, "section,x,y,z\n" + text),
        (parse_json, json.dumps(content)),
    ):
        try:
            names, curves = parse("fuzz", given_text)
            checked_sections("fuzz", curves, names)
        except FabgeoError:
            continue
