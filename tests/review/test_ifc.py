"""IFC4x3: valid by ifcopenshell's own rules, closed shapes, the schedules' figures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from review_synthetic import record

from fabgeo.review.ifc import triangles, write_ifc


def test_a_box_becomes_twelve_outward_triangles_with_its_volume() -> None:
    square = np.array([[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 2.0, 3.0], [0.0, 0.0, 3.0]])
    rails = np.stack([square, np.add(square, [5.0, 0.0, 0.0])], axis=1)
    for own in (rails, rails[::-1]):
        points, faces = triangles(own)
        p, q, r = (points[faces[:, k]] for k in range(3))
        assert len(faces) == 12
        assert np.einsum("ij,ij->", p, np.cross(q, r)) / 6.0 == pytest.approx(30.0)
        directed = {tuple(e) for f in faces.tolist() for e in zip(f, f[1:] + f[:1], strict=True)}
        assert {(b, a) for a, b in directed} == directed  # every edge once in either sense


def test_the_file_is_valid_and_holds_every_panel_with_its_figures(tmp_path: Path) -> None:
    ifcopenshell = pytest.importorskip("ifcopenshell")
    from ifcopenshell.util.element import get_psets
    from ifcopenshell.validate import json_logger, validate

    own = record(2, 3)
    path = write_ifc(tmp_path / "facade.ifc", own)
    log = json_logger()
    validate(str(path), log)
    assert log.statements == []
    model = ifcopenshell.open(str(path))
    assert model.schema == "IFC4X3"
    plates = [p for p in model.by_type("IfcPlate") if p.PredefinedType == "CURTAIN_PANEL"]
    assert {p.Name for p in plates} == {row["mark"] for row in own.panels}
    row = own.panels[0]
    found = next(get_psets(p)["Fabgeo_Panel"] for p in plates if p.Name == row["mark"])
    assert found["class"] == row["class"]
    assert found["mass_kg"] == pytest.approx(row["mass_kg"])
    again = write_ifc(tmp_path / "again.ifc", own)
    bodies = [p.read_text().split("DATA;")[1] for p in (path, again)]
    assert bodies[0] == bodies[1]
