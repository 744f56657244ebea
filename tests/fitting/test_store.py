"""strips.json: to the last digit and back, and clear words for what is wrong."""

from __future__ import annotations

import json

import numpy as np
import pytest

from fabgeo.errors import InputError
from fabgeo.fitting.store import load_model, save_model
from fabgeo.strips.model import StripModel


@pytest.fixture
def model():
    control = np.random.default_rng(1).standard_normal((4, 7, 3)) / 3.0
    return StripModel(control, False, True, "conical", {"start": {"method": "iso"}})


def test_comes_back_to_the_last_digit(tmp_path, model):
    save_model(tmp_path / "strips.json", model, history=[{"stage": 1, "cost": 0.1}])
    back = load_model(tmp_path / "strips.json")
    np.testing.assert_array_equal(back.control, model.control)
    assert (back.closed_u, back.closed_i, back.kind) == (False, True, "conical")
    assert back.info["start"] == {"method": "iso"}
    assert back.info["history"] == [{"stage": 1, "cost": 0.1}]
    assert back.info["unit"] == "mm"
    assert not list(tmp_path.glob("*.part"))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"format": "other"}, "format"),
        ({"version": 2}, "version"),
        ({"kind": "round"}, "conical"),
        ({"closed_u": 1}, "closed_u"),
        ({"control": [[1.0]]}, "shape"),
        ({"control": None}, "control"),
        ({"typo": 1}, "typo"),
    ],
)
def test_names_what_is_wrong(tmp_path, model, change, words):
    path = tmp_path / "strips.json"
    save_model(path, model)
    path.write_text(json.dumps({**json.loads(path.read_text()), **change}))
    with pytest.raises(InputError, match=words):
        load_model(path)


def test_names_missing_and_broken_files(tmp_path, model):
    with pytest.raises(InputError, match="cannot be read"):
        load_model(tmp_path / "none.json")
    (tmp_path / "broken.json").write_text("{")
    with pytest.raises(InputError, match="no JSON"):
        load_model(tmp_path / "broken.json")
    with pytest.raises(InputError, match="plain data"):
        save_model(tmp_path / "x.json", model.with_control(model.control, info={"a": np.ones(2)}))
    assert not (tmp_path / "x.json").exists()
