"""Single panels in materials of their own: the shapes stay, forming and plates follow."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from fabgeo.build import Design, design
from fabgeo.build.cache import Cache
from fabgeo.errors import InputError
from fabgeo.project import parse_project

DATA: dict[str, Any] = {
    "surface": {
        "unit": "m",
        "u": [-3.0, 3.0],
        "v": [-4.0, 4.0],
        "x": "u",
        "y": "v",
        "z": "3 - 0.05*u**2 - 0.03*v**2",
    },
    "strips": {"count": 3, "start": "iso"},
    "panels": {"count": 2, "thickness": 12.0},
}


def made(cache: Cache | None = None, **materials: str) -> Design:
    panels = {**DATA["panels"], "materials": {k.replace("_", "-"): m for k, m in materials.items()}}
    return design(parse_project({**DATA, "panels": panels}), cache=cache)


def test_one_panel_of_another_material_keeps_every_shape(tmp_path: Path) -> None:
    plain = made(Cache(tmp_path))
    cache = Cache(tmp_path)
    other = made(cache, P_01_00="glass")
    assert cache.made == 0  # fit and shapes are found: they do not depend on the material
    for before, after in zip(plain.panels, other.panels, strict=True):
        assert after.material == ("glass" if after.mark == "P-01-00" else "aluminium")
        assert (before.mid.poles == after.mid.poles).all()
    changed = {m for m in plain.choices if plain.choices[m].reason != other.choices[m].reason}
    assert changed <= {"P-01-00"}


def test_forming_is_that_of_the_panels_own_material() -> None:
    """Springing radius E t / 2 f_y: 3.2 m of aluminium, 18.0 m of glass, 12 mm thick."""
    choices = made(P_01_00="glass").choices
    radius = choices["P-01-00"].radius_min_mm
    assert 70000.0 * 12.0 / 2.0 / 130.0 < radius < 70000.0 * 12.0 / 2.0 / 23.3
    assert choices["P-01-00"].forming in ("roll", "press")
    assert choices["P-00-00"].forming == "spring"


def test_a_mark_that_is_not_there_is_refused() -> None:
    with pytest.raises(InputError, match=r"no panel 'P-09-00', did you mean 'P-0.-00'"):
        made(P_09_00="glass")
    with pytest.raises(InputError, match=r"panels.materials.P-00-00: unknown material 'galss'"):
        made(P_00_00="galss")
