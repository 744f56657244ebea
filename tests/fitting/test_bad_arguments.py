"""Arguments that are no surface, no model or no number: told by name, before anything is begun."""

from __future__ import annotations

import json
import os

import numpy as np
import pytest

from fabgeo.errors import InputError
from fabgeo.fitting.fit import fit
from fabgeo.fitting.options import FitOptions, Weights
from fabgeo.fitting.starts import start
from fabgeo.fitting.store import load_model, save_model
from fabgeo.strips.model import StripModel
from fabgeo.surfaces.formula import FormulaSurface

DOME = FormulaSurface("u", "v", "3000 - 5e-5*u**2 - 3e-5*v**2", (-3000, 3000), (-4000, 4000))
BEGUN = start(DOME, "iso", strips=3, segments=4)
MODEL = BEGUN.model
NAN = float("nan")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"surface": "roof.step"}, "as_surface"),
        ({"start": BEGUN}, r"found a Start; pass start\.model"),
        ({"start": MODEL.control}, "expected a strip model, found a ndarray"),
        ({"kind": "bogus"}, "expected a kind"),
        ({"kind": np.ones(3)}, "expected a kind"),
        ({"options": {}}, "expected FitOptions"),
        ({"listener": 5}, "listener"),
        ({"start": MODEL.with_control(MODEL.control, info={"fit": 5})}, r"info\.fit"),
        ({"start": MODEL.with_control(MODEL.control, info={"fit": {"cost": 1}})}, "developabi"),
    ],
)
def test_a_fit_names_what_it_is_not_given(arguments: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        fit(**{"surface": DOME, "start": MODEL, **arguments})


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *[("twist_limit_deg", x) for x in (0, -1, NAN, np.inf, "a", None)],
        *[("weights", x) for x in (None, {})],
        *[("points", x) for x in (5, [[1, 2]], [[NAN, 0, 0]], "a")],
        *[(name, "x") for name in ("minimise", "solver", "boundary", "towards", "kind_limit_deg")],
        *[(name, x) for name in ("levels", "across", "refinements") for x in (-1, 1.5, "a", True)],
        *[(name, x) for name in ("iterations", "stages") for x in (0, -1, 1.5, "a")],
        *[(name, np.ones(3)) for name in ("boundary", "continuation", "minimise", "solver")],
        *[("growth", x) for x in (1, NAN, np.inf, "a", 1e300)],
    ],
)
def test_options_of_a_fit_are_checked(name: str, value: object) -> None:
    with pytest.raises(InputError, match=rf"FitOptions\.{name}"):
        FitOptions(**{name: value})


@pytest.mark.parametrize("value", [-1, NAN, np.inf, "a", None, [1], 1e300])
def test_weights_are_finite(value: object) -> None:
    with pytest.raises(InputError, match=r"Weights\.cover"):
        Weights(cover=value)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        *[
            ({"strips": x}, "strips: expected a whole number")
            for x in (2.5, "3", NAN, True, 10**12)
        ],
        *[({"segments": x}, "segments: expected a whole") for x in (2.5, "3", NAN, -1, 10**9)],
        *[({"kind": x}, "start kind: expected one of general") for x in ("bogus", None)],
        *[({"strips": None, "sag": x}, "sag: expected a finite") for x in (0, -1, NAN, "a")],
        ({"method": "principal", "seed": "w"}, "expected a point"),
        ({"method": "principal", "overhang": (0.1, 0.1)}, "overhang: expected a finite number"),
        ({"method": "model", "seed": 5}, "expected a model or the path of one"),
        *[({"overhang": x}, "overhang: expected") for x in (1e30, "a", (1, 2, 3), (-0.6, -0.6))],
        *[({"overhang": x}, "overhang: expected") for x in ([NAN, 0.0], np.array(NAN))],
        ({"direction": np.ones(3)}, "direction: expected 'u' or 'v'"),
        ({"options": 5}, "no option 'options'"),
        ({"method": np.ones(3)}, "start method"),
        ({"method": "sections", "seed": 5}, "expected sections as curves"),
        ({"method": "principal", "seed": (10**400, 0, 0)}, "expected a point"),
        ({"method": "principal", "seed": ("1", "2", "3")}, "expected a point"),
        ({"method": "principal", "overhang": 1e30}, "overhang: expected 1000 at most"),
        ({"surface": "roof.step"}, "as_surface"),
    ],
)
def test_a_start_names_what_it_is_not_given(arguments: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        start(**{"surface": DOME, "method": "iso", "strips": 3, **arguments})


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"version":1', '"version":true', "version"),
        ('"unit":"mm"', '"unit":"parsec"', "unit.*expected one of mm"),
        ('"info":{', '"info":{"fit":5', r"info\.fit: expected names"),
        ('"history":[]', '"history":[5]', "history: expected a list of records"),
        ('"info":{', '"info":{"a":' + "9" * 5000, "no JSON"),
        ('"info":{', '"info":{"a":' + "[" * 100_000, "no JSON"),
        ('"control":[[[', '"control":[[[1' + "0" * 400 + ",0,0],[", "control: expected numbers"),
    ],
)
def test_a_model_file_names_what_is_wrong(tmp_path, old: str, new: str, words: str) -> None:
    path = tmp_path / "strips.json"
    save_model(path, StripModel(MODEL.control))
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError, match=words):
        load_model(path)


@pytest.mark.parametrize(
    ("value", "words"), [("7", "found text"), (True, "found truth values"), (None, "found")]
)
def test_coordinates_in_a_model_file_are_numbers(tmp_path, value: object, words: str) -> None:
    path = tmp_path / "strips.json"
    save_model(path, StripModel(MODEL.control))
    data = json.loads(path.read_text())
    data["control"][1][2][0] = value
    path.write_text(json.dumps(data))
    with pytest.raises(InputError, match=rf"control: expected numbers.*{words}"):
        load_model(path)


def test_models_are_read_from_files_and_written_to_files(tmp_path) -> None:
    os.mkfifo(tmp_path / "pipe.json")
    for path, words in [
        (tmp_path / "pipe.json", "is no file"),
        ("/dev/zero", "is no file"),
        (None, "expected a path"),
        ("a\0", "expected a path"),
    ]:
        with pytest.raises(InputError, match=words):
            load_model(path)  # type: ignore[arg-type]
    before = sorted(tmp_path.iterdir())
    for path, words in [
        (tmp_path / "none" / "x.json", "cannot be written"),
        (tmp_path, "is a folder"),
        ("", "is a folder"),
        (tmp_path / ("a" * 300), "cannot be written"),
        ("\ud800", "cannot be written"),
        (None, "expected a path"),
    ]:
        with pytest.raises(InputError, match=words):
            save_model(path, MODEL)  # type: ignore[arg-type]
    for keywords, words in [({"unit": "furlong"}, "unit"), ({"history": 5}, "history")]:
        with pytest.raises(InputError, match=words):
            save_model(tmp_path / "x.json", MODEL, **keywords)
    with pytest.raises(InputError, match=r"pass start\.model"):
        save_model(tmp_path / "x.json", BEGUN)  # type: ignore[arg-type]
    assert sorted(tmp_path.iterdir()) == before
