"""Readers on damaged and made-up files: a clear error of fabgeo or a right answer, in time."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from readers import CSV, OBJ, OFF, PROJECT, model_bytes

from fabgeo.errors import FabgeoError
from fabgeo.fitting.store import load_model
from fabgeo.project import Project, parse_project, read_project
from fabgeo.surfaces.base import DesignSurface

quick = settings(
    max_examples=60,
    deadline=60_000,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
plain = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner),
    max_leaves=12,
)


@st.composite
def damaged(draw: st.DrawFn, text: str) -> bytes:
    """A file with a few bytes or lines changed, taken out, doubled."""
    data = text.encode()
    for _ in range(draw(st.integers(1, 3))):
        place = draw(st.integers(0, len(data)))
        length = draw(st.integers(0, 12))
        new = draw(
            st.binary(max_size=6) | st.sampled_from([b"nan", b"-1", b"1e999", b"\n", b"99999"])
        )
        data = data[:place] + new + data[place + length :]
    return data


def answer[T](read: Callable[[], T], *names: str) -> T | None:
    """What a reader gives, or None for an error of fabgeo that names one of `names`."""
    try:
        return read()
    except FabgeoError as error:
        if not any(name in str(error) for name in names):
            raise AssertionError(f"{error} names none of {names}") from error
        return None


@quick
@given(damaged(PROJECT))
def test_damaged_project_files(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "p.toml").write_bytes(data)
    project = answer(lambda: read_project(tmp_path / "p.toml"), "p.toml")
    if project is not None:
        assert parse_project(project.model_dump(mode="json", exclude_none=True)) == project


@quick
@given(st.dictionaries(st.sampled_from([*Project.model_fields, "other"]), plain))
def test_made_up_projects(data: dict[str, Any]) -> None:
    try:
        project = parse_project(data)
    except FabgeoError:
        return
    assert parse_project(project.model_dump(mode="json", exclude_none=True)) == project


@quick
@given(st.data())
def test_damaged_models(tmp_path: Path, data: st.DataObject) -> None:
    content = data.draw(damaged(model_bytes().decode()))
    path = tmp_path / "other.json"
    path.write_bytes(content)
    model = answer(lambda: load_model(path), "other.json", "StripModel")
    if model is not None:
        assert np.isfinite(model.control).all()


@quick
@given(st.sampled_from(["control", "kind", "info", "history", "closed_u", "unit"]), plain)
def test_made_up_entries_of_models(tmp_path: Path, key: str, value: Any) -> None:
    content = json.loads(model_bytes().decode())
    content[key] = value
    (tmp_path / "other.json").write_text(json.dumps(content))
    model = answer(lambda: load_model(tmp_path / "other.json"), "other.json", "StripModel")
    if model is not None:
        assert np.isfinite(model.control).all()


@pytest.mark.parametrize(("name", "text"), [("a.obj", OBJ), ("a.off", OFF), ("a.csv", CSV)])
@quick
@given(data=st.data())
def test_damaged_surface_files(tmp_path: Path, name: str, text: str, data: st.DataObject) -> None:
    from fabgeo.cad.read_surface import read_surface

    (tmp_path / name).write_bytes(data.draw(damaged(text)))
    try:
        surface = read_surface(tmp_path / name, unit="m")
    except FabgeoError:
        return
    assert isinstance(surface, DesignSurface)


@quick
@given(st.text("uvxysincoexp0123456789.+-*/()[]_ ,'\"=:lambd", max_size=40))
def test_formulas_are_arithmetic_only(text: str) -> None:
    from fabgeo.surfaces.formula import FormulaSurface

    try:
        surface = FormulaSurface("u", "v", text, (0.0, 1.0), (0.0, 1.0), scale=1000.0)
    except FabgeoError:
        return
    assert isinstance(surface, DesignSurface)
