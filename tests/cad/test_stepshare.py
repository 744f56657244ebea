"""Shares of a STEP file hold together what the file holds, each solid once."""

from __future__ import annotations

import re

import numpy as np
import pytest
from cad_helpers import revolution
from OCP.BRep import BRep_Builder
from OCP.TopoDS import TopoDS_Compound

from fabgeo.cad.assembly import Node
from fabgeo.cad.readback import ReadPart, read_package_step
from fabgeo.cad.solids import prism_solid
from fabgeo.cad.step import write_step
from fabgeo.cad.stepshare import step_shares


@pytest.fixture(scope="module")
def roof(tmp_path_factory):
    """Six cells of their own, and a bolt with a washer that is placed three times."""

    def solid(start: float, length: float = 0.3):
        return prism_solid(revolution(start=start, end=start + length))

    cells = tuple(
        Node(f"C-{i} #{i}", solid(0.3 * i), colour=(0.1 * i, 0.5, 0.9), layer="Zellen ß")
        for i in range(6)
    )
    pieces = (
        Node("bolt", solid(2.0, 0.1), colour=(0.4, 0.4, 0.4)),
        Node("washer", solid(2.2, 0.05)),
    )
    product = Node("fixing", children=pieces)
    places = np.repeat(np.eye(4)[None], 3, axis=0)
    places[:, 0, 3] = [0.0, 500.0, 1000.0]
    placed = tuple(Node(f"K-{k}", instance_of=product, location=m) for k, m in enumerate(places))
    groups = (Node("cells", children=cells), Node("connectors", children=placed))
    return write_step(tmp_path_factory.mktemp("roof") / "roof.step", Node("roof", children=groups))


def told(part: ReadPart) -> tuple[object, ...]:
    frame = np.round(part.location, 9).tolist()
    return part.path, part.product, part.colour, part.layers, frame, part.report.volume


@pytest.mark.parametrize("count", [2, 3, 4])
def test_shares_hold_every_part_once_in_its_place(roof, tmp_path, count):
    expected = [told(part) for part in read_package_step(roof)]
    found, solids = [], []
    whole = len(roof.read_bytes())
    for k, text in enumerate(step_shares(roof, whole // count)):
        file = tmp_path / f"{k}.step"
        file.write_bytes(text)
        found += [told(part) for part in read_package_step(file)]
        defined = re.findall(rb"^#(\d+) = ", text, re.M)
        assert set(re.findall(rb"#(\d+)", re.sub(rb"'[^']*'", b"", text))) <= set(defined)
        solids.append(text.count(b"ADVANCED_FACE"))
        assert len(text) < 1.3 * whole / count + 10_000  # and the trunk of the product tree
    assert len(expected) == 12
    assert sorted(map(str, found)) == sorted(map(str, expected))
    assert len(solids) == count
    assert sum(solids) == roof.read_bytes().count(b"ADVANCED_FACE")


def test_a_file_that_can_not_be_divided_is_one_share(roof, tmp_path):
    other = tmp_path / "other.step"
    for old, new in ((b"\n#", b" #"), (b"DATA;\n", b"DATA;\n/* by hand */\n")):
        other.write_bytes(roof.read_bytes().replace(old, new))
        assert list(step_shares(other, 20_000)) == [other.read_bytes()]
    assert list(step_shares(roof)) == [roof.read_bytes()]


def test_solids_of_no_product_are_left_in_one_share(roof, tmp_path):
    other = tmp_path / "other.step"
    cut = re.sub(rb"#\d+ = SHAPE_DEFINITION_REPRESENTATION[^;]*;", b"", roof.read_bytes(), count=3)
    other.write_bytes(cut)
    assert list(step_shares(other, 20_000)) == [cut]


def test_solids_of_one_shape_stay_together(tmp_path):
    def pair(place: float) -> TopoDS_Compound:
        builder, both = BRep_Builder(), TopoDS_Compound()
        builder.MakeCompound(both)
        for start in (place, place + 0.4):
            builder.Add(both, prism_solid(revolution(start=start, end=start + 0.3)))
        return both

    parts = tuple(Node(f"C-{i}", pair(1.0 * i)) for i in range(3))
    file = write_step(tmp_path / "pairs.step", Node("pairs", children=parts))
    texts = list(step_shares(file, len(file.read_bytes()) // 6))
    assert [text.count(b"MANIFOLD_SOLID_BREP") for text in texts] == [2, 2, 2]
