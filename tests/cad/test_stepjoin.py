"""A file joined from pieces says what the kernel says of the whole, and refers to nothing else."""

from __future__ import annotations

import re

import numpy as np
import pytest
from cad_helpers import revolution

from fabgeo.cad.assembly import Node
from fabgeo.cad.readback import ReadPart, read_package_step
from fabgeo.cad.solids import prism_solid
from fabgeo.cad.step import step_bytes, write_step
from fabgeo.cad.stepjoin import StepJoin
from fabgeo.errors import InputError

NAME = "Dach #7 über Hof, 屋根 it's; \\ here"


def cell(i: int) -> Node:
    solid = prism_solid(revolution(start=0.3 * i, end=0.3 * i + 0.3))
    return Node(f"C#{i} it's", solid, colour=(0.1 * i, 0.5, 0.9), layer="Zellen ß #1")


def bolts() -> list[Node]:
    bolt = Node("bolt", prism_solid(revolution(start=2.0, end=2.1)), colour=(0.4, 0.4, 0.4))
    product = Node("fixing", children=(bolt,))
    places = np.repeat(np.eye(4)[None], 3, axis=0)
    places[:, 0, 3] = [0.0, 500.0, 1000.0]
    return [
        Node(f"K-{k}", instance_of=product, location=place, layer="connectors")
        for k, place in enumerate(places)
    ]


@pytest.fixture(scope="module")
def cells() -> list[Node]:
    return [cell(i) for i in range(5)]


@pytest.fixture(scope="module")
def joined(cells, tmp_path_factory):
    path = tmp_path_factory.mktemp("joined") / "facade.step"
    with StepJoin(path, NAME) as file:
        file.add("cells", step_bytes(Node("cells", children=tuple(cells[:3]))))
        file.add("connectors", step_bytes(Node("connectors", children=tuple(bolts()))))
        file.add("cells", step_bytes(Node("cells", children=tuple(cells[3:]))))
    return path


def told(part: ReadPart) -> tuple[object, ...]:
    frame = np.round(part.location, 9).tolist()
    volume = round(part.report.volume, 3)
    return part.name, part.product, part.path, part.colour, part.layers, frame, volume


def test_it_reads_as_the_whole_tree_written_at_once(cells, joined, tmp_path):
    groups = (Node("cells", children=tuple(cells)), Node("connectors", children=tuple(bolts())))
    whole = write_step(tmp_path / "whole.step", Node(NAME, children=groups))
    expected = [told(part) for part in read_package_step(whole)]
    found = [told(part) for part in read_package_step(joined)]
    assert found == expected
    assert {part.report.sound for part in read_package_step(joined)} == {True}


def test_every_reference_is_to_one_entity(joined):
    text = re.sub(r"'(?:[^']|'')*'", "''", joined.read_text())
    defined = [int(n) for n in re.findall(r"^#(\d+) =", text, re.MULTILINE)]
    assert len(defined) == len(set(defined))
    assert {int(n) for n in re.findall(r"#(\d+)", text)} <= set(defined)
    numbers = re.findall(r"NEXT_ASSEMBLY_USAGE_OCCURRENCE\('(\d+)'", joined.read_text())
    assert sorted(map(int, numbers)) == list(range(1, len(numbers) + 1))


def test_the_file_of_one_assembly_has_it_as_root(cells, tmp_path):
    single = {"connectors": tmp_path / "connectors.step"}
    with StepJoin(tmp_path / "facade.step", NAME, single) as file:
        file.add("cells", step_bytes(Node("cells", children=tuple(cells))))
        file.add("connectors", step_bytes(Node("connectors", children=tuple(bolts()))))
    assert {path.name for path in tmp_path.iterdir()} == {"facade.step", "connectors.step"}
    alone = [told(part) for part in read_package_step(single["connectors"])]
    whole = [told(part) for part in read_package_step(tmp_path / "facade.step")][-len(alone) :]
    assert [(*told[:2], *told[3:]) for told in alone] == [(*t[:2], *t[3:]) for t in whole]
    assert [told[2] for told in alone] == [told[2][1:] for told in whole]


def test_nothing_is_left_of_a_file_that_fails(cells, tmp_path):
    def broken(*pieces: bytes) -> None:
        with StepJoin(tmp_path / "x.step", "x") as file:
            for piece in pieces:
                file.add("cells", piece)

    with pytest.raises(InputError, match="root"):
        broken(step_bytes(Node("cells", children=(cells[0],))), b"DATA;\nnothing\n")
    with pytest.raises(InputError, match="no part"):
        broken()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("count", range(8, 12))
def test_any_number_of_parts_is_joined(count, tmp_path):
    """The kernel breaks the root's list of places where its line is full, or after it."""
    made = [cell(i % 5) for i in range(count)]
    parts = tuple(Node(f"W-{i}", own.shape) for i, own in enumerate(made))
    path = tmp_path / "walls.step"
    with StepJoin(path, "roof") as file:
        file.add("walls", step_bytes(Node("walls", children=parts)))
    assert [part.name for part in read_package_step(path)] == [part.name for part in parts]
