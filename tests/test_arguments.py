"""Whatever is given to a public function: an error of fabgeo, or numbers that are numbers."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import fabgeo
from fabgeo import spline
from fabgeo.build.flats import flats_of
from fabgeo.build.nests import nests_of
from fabgeo.build.solids import solids_of
from fabgeo.errors import FabgeoError, GeometryError, InputError
from fabgeo.fitting.covering import cover, seam_points
from fabgeo.structures.fixing import Fixing, LocalHole
from fabgeo.structures.mixed import admits

U, V = np.meshgrid(np.arange(7.0), np.arange(4.0))
CONTROL = np.stack([1000.0 * U, 1000.0 * V, 20.0 * U**2], axis=-1)
MODEL = fabgeo.StripModel(CONTROL, kind="conical")
DOME = fabgeo.FormulaSurface("u", "v", "3 - u**2/9", (-3, 3), (-4, 4), scale=1000.0)
POINTS = DOME.sample(9)
PATCH = fabgeo.Patch(0, 0, 0.5, 2.5)
RULED = fabgeo.RuledPatch.of_model(MODEL, PATCH)
KNOTS, AT = spline.clamped_knots(0.0, 2.0, 2), np.array([0.5, 1.5])
SITES, SIDE = spline.greville(KNOTS), np.arange(15.0).reshape(5, 3)
PROJECT = fabgeo.Project(surface={"unit": "m", "file": "a.step"})

CALLS: dict[str, Callable[[Any], Any]] = {
    "segments_of": lambda x: spline.segments_of(x, False),
    "basis u": lambda x: spline.basis(x, 4, False),
    "basis u, closed": lambda x: spline.basis(x, 4, True),
    "basis segments": lambda x: spline.basis(AT, x, False),
    "basis closed": lambda x: spline.basis(AT, 4, x),
    "basis derivative": lambda x: spline.basis(AT, 4, False, x),
    "evaluate control": lambda x: spline.evaluate(x, AT),
    "evaluate u": lambda x: spline.evaluate(CONTROL, x),
    "evaluate derivative": lambda x: spline.evaluate(CONTROL, AT, False, x),
    "refine": spline.refine,
    "interpolate": spline.interpolate,
    "interpolate, closed": lambda x: spline.interpolate(x, True),
    "to_clamped": spline.to_clamped,
    "greville": spline.greville,
    "clip u0": lambda x: spline.clip(CONTROL, False, x, 4.0),
    "clip u1, closed": lambda x: spline.clip(CONTROL, True, 0.5, x),
    "clamped_knots u1": lambda x: spline.clamped_knots(0.0, x, 3),
    "StripModel": fabgeo.StripModel,
    "StripModel closed_i": lambda x: fabgeo.StripModel(CONTROL, closed_i=x),
    "points": MODEL.points,
    "points derivative": lambda x: MODEL.points(AT, x),
    "edge": lambda x: MODEL.edge(x, AT),
    "rulings": MODEL.rulings,
    "pairs": lambda x: [len(side) for side in MODEL.pairs(x)],
    "parameters": MODEL.parameters,
    "with_control": MODEL.with_control,
    "Patch u1": lambda x: fabgeo.Patch(0, 0, 0.0, x),
    "Patch edges": lambda x: PATCH.edges(MODEL, x),
    "Patch edges model": lambda x: PATCH.edges(x, AT),
    "RuledPatch knots": lambda x: fabgeo.RuledPatch(x, RULED.poles),
    "RuledPatch poles": lambda x: fabgeo.RuledPatch(RULED.knots, x),
    "RuledPatch edges": RULED.edges,
    "RuledPatch edges derivative": lambda x: RULED.edges(AT, x),
    "RuledPatch points": lambda x: RULED.points(AT, x),
    "RuledPatch of_model": lambda x: fabgeo.RuledPatch.of_model(MODEL, x),
    "RuledPatch through knots": lambda x: fabgeo.RuledPatch.through(x, SITES, SIDE, SIDE),
    "RuledPatch through points": lambda x: fabgeo.RuledPatch.through(KNOTS, SITES, x, SIDE),
    "closest": lambda x: DOME.closest(x).point,
    "surface at u": lambda x: DOME.evaluate(x, 0.0).point,
    "surface face": lambda x: DOME.evaluate(0.0, 0.0, x).point,
    "face_bounds": DOME.face_bounds,
    "normal_curvature": POINTS.normal_curvature,
    "measure": fabgeo.measure,
    "admits": admits,
    "cover": lambda x: cover(x),
    "cover models": lambda x: cover(DOME, x if not isinstance(x, int) or x < 1 else 0),
    "seam_points": lambda x: seam_points(MODEL, x),
    "stoppable": lambda x: fabgeo.stoppable(x if not callable(x) else 5).__enter__(),
    "as_surface name": lambda x: fabgeo.as_surface(DOME, name=x) and None,
    "LocalHole": lambda x: LocalHole(diameter=x),
    "Fixing step": lambda x: Fixing(step=x).limits,
    "Fixing reach": lambda x: Fixing(reach=x).limits,
    "Fixing name": lambda x: Fixing(name=x).limits,
    "Fixing holes": lambda x: Fixing(panel_holes=x).limits,
    "material": PROJECT.material,
    "stock_for": lambda x: PROJECT.stock_for("steel", x),
}
single = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=2),
    st.binary(max_size=2),
    st.complex_numbers(),
    st.sampled_from([10**400, 1e200, -1e30, float("nan"), "3", object(), np.bool_(True), range(3)]),
)
shapes = st.sampled_from([(), (0,), (2,), (3,), (0, 3), (1, 3), (4, 3), (2, 5, 3), (5, 2, 2, 2)])
hostile = st.one_of(
    single,
    st.lists(single, max_size=4),
    st.dictionaries(st.text(max_size=2), single, max_size=2),
    hnp.arrays(st.sampled_from([np.float64, np.int64, bool, np.complex128, "U2", "S2"]), shapes),
    hnp.arrays(np.float64, shapes, elements=st.sampled_from([0.0, 1.0, np.nan, np.inf, 1e200])),
    hnp.arrays(object, shapes, elements=single),
)


def numbers_of(answer: Any) -> list[np.ndarray]:
    """All arrays and numbers that an answer holds."""
    if isinstance(answer, float | np.ndarray):
        return [np.asarray(answer)]
    if isinstance(answer, tuple | list):
        return [number for part in answer for number in numbers_of(part)]
    return [x for x in vars(answer).values() if isinstance(x, np.ndarray)] if hasattr(
        answer, "__dict__"
    ) else []  # fmt: skip


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", CALLS)
@settings(max_examples=25, deadline=None)
@given(value=hostile)
def test_an_error_of_fabgeo_or_finite_numbers(name: str, value: Any) -> None:
    try:
        answer = CALLS[name](value)
    except FabgeoError:
        return
    for array in numbers_of(answer):
        assert array.dtype.kind in "fiub"
        assert np.isfinite(array).all()


@pytest.mark.parametrize(
    "value",
    [
        [["1", "2", "3"]] * 4,
        np.ones((4, 3), dtype=bool),
        np.ones((4, 3), dtype=complex),
        np.full((4, 3), 20, dtype="timedelta64[s]"),
        np.ma.masked_equal(np.arange(12.0).reshape(4, 3), 5.0),
        [[1.0, None, 2.0]] * 4,
        np.full((4, 3), np.nan),
        np.full((4, 3), 1e101),
    ],
)
@pytest.mark.parametrize("closed", [False, True])
def test_what_is_no_number_is_not_interpolated(value: Any, closed: bool) -> None:
    with pytest.raises(InputError, match="interpolate"):
        spline.interpolate(value, closed)


def test_what_numpy_holds_otherwise_is_the_same_numbers() -> None:
    expected = spline.refine(CONTROL)
    fixed = CONTROL.copy()
    fixed.flags.writeable = False
    for same in (CONTROL.tolist(), CONTROL.astype(object), fixed, np.asfortranarray(CONTROL)):
        np.testing.assert_array_equal(spline.refine(same), expected)


def test_far_parameters_continue_the_last_piece() -> None:
    """Beyond its ends a curve is the polynomial of its last segment; too far, it is refused."""
    last = np.array([1e3])
    t = last - 3.0
    b = CONTROL[0, 3:7, 2]
    powers = spline._POWERS
    expected = np.stack([t**0, t, t**2, t**3], axis=-1) @ powers @ b
    np.testing.assert_allclose(spline.evaluate(CONTROL[0], last)[:, 2], expected, rtol=1e-9)
    with pytest.raises(InputError, match="beyond"):
        spline.evaluate(CONTROL[0], np.array([1e12]))


@pytest.mark.parametrize("count", [0, -1, 1.5, "9", None, float("nan"), True, 10**30])
def test_samples_are_counted(count: Any) -> None:
    with pytest.raises(InputError, match="samples: expected a whole number"):
        DOME.sample(count)


@pytest.mark.parametrize(
    ("control", "words"),
    [
        (0.0 * CONTROL, "ruling"),
        (np.repeat(CONTROL[:1], 4, axis=0), "ruling"),
        (np.repeat(CONTROL[:, :1], 7, axis=1), "tangent"),
        ((CONTROL + 0.1 * CONTROL[..., [1, 1, 1]]) * [1.0, 0.0, 0.0], "normal"),
        (1e-160 * CONTROL, "ruling"),
    ],
)
def test_what_has_no_normals_is_not_measured(control: np.ndarray, words: str) -> None:
    model = fabgeo.StripModel(control, kind="conical")
    for told in (fabgeo.measure, lambda x: fabgeo.offset(x, 1.0), lambda x: fabgeo.fit(DOME, x)):
        with pytest.raises(GeometryError, match=f"the {words}: has no length"):
            told(model)
    assert not admits(model).beams


def test_models_of_no_building_are_refused() -> None:
    with pytest.raises(InputError, match=r"control: expected numbers up to 1e\+12"):
        fabgeo.StripModel(1e200 * CONTROL)


@pytest.mark.parametrize(
    "knots", [[0.0] * 8, [0, 1, 2, 3, 4, 5, 6, 7], [0, 0, 0, 0, 0, 1, 1, 1], [0, 0, 0, 1] * 2]
)
def test_knots_that_are_not_clamped_are_refused(knots: list[float]) -> None:
    with pytest.raises(InputError, match=r"RuledPatch\.knots"):
        fabgeo.RuledPatch(np.array(knots, dtype=float), np.zeros((2, 4, 3)))


def test_init_follows_no_link(tmp_path: Path) -> None:
    from fabgeo.build.template import write_template

    link = tmp_path / "project.toml"
    link.symlink_to(tmp_path / "elsewhere.toml")
    with pytest.raises(InputError, match="is there already"):
        write_template(link)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["project.toml"]
    for path in (None, 5, "a\0", tmp_path / ("a" * 300), tmp_path / "none" / "a.toml", "\ud800"):
        with pytest.raises(InputError):
            write_template(path)  # type: ignore[arg-type]


PROJECT_OF_STAGES = {
    "surface": {
        "unit": "m",
        "u": [-2.0, 2.0],
        "v": [-2.0, 2.0],
        "x": "u",
        "y": "v",
        "z": "3-u*u/20",
    },
    "strips": {"count": 2, "segments": 4},
    "panels": {"count": 1},
}


def test_stages_name_what_they_are_not_given() -> None:
    made = fabgeo.design(PROJECT_OF_STAGES)
    flats = flats_of(made.project, made.plates)
    calls: list[tuple[str, Callable[[Any], Any]]] = [
        ("project", lambda x: flats_of(x, made.plates)),
        ("project", lambda x: nests_of(x, made.plates, flats)),
        ("plates", lambda x: flats_of(made.project, x)),
        ("plates", lambda x: nests_of(made.project, x, flats)),
        ("flats", lambda x: nests_of(made.project, made.plates, x)),
        ("parts", solids_of),
        ("jobs", lambda x: flats_of(made.project, made.plates, x)),
        ("jobs", lambda x: solids_of(made.plates, x)),
    ]
    for name, call in calls:
        for wrong in (5, "x", b"x", [1], {"P-00-00": 1}, 10**30, object):
            if name == "jobs" and wrong == 5:
                continue
            with pytest.raises(InputError, match=f"^{name}"):
                call(wrong)
    with pytest.raises(InputError, match="plates: P-00-00: is there 2 times"):
        flats_of(made.project, [*made.plates, *made.plates])
