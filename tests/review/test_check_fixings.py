"""Products of fixings that are not built as bolts, holes and their names ask for."""

from __future__ import annotations

import copy
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_check_real import PROJECT

from fabgeo.build import build_package
from fabgeo.project import parse_project
from fabgeo.review.check_fixings import check_fixings
from fabgeo.review.check_solids import check_solids
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured, Piece
from fabgeo.review.package import WrittenPackage

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Measured]:
    folder = tmp_path_factory.mktemp("fixings") / "out"
    build_package(parse_project(PROJECT), folder)
    measured, findings = Measured(), Findings()
    check_solids(WrittenPackage.open(folder), measured, findings)
    assert not findings.items
    return folder, measured


def found(folder: Path, measured: Measured) -> set[str]:
    findings = Findings()
    check_fixings(WrittenPackage.open(folder), measured, findings)
    return {finding.part for finding in findings.items}


def test_sound_products_are_told_piece_by_piece(package: tuple[Path, Measured]) -> None:
    assert not found(*package)
    for name, pieces in package[1].pieces.items():
        kinds = [piece.kind for piece in pieces]
        assert kinds.count("bolt") == 3  # the rod, and one at each end of the base plate
        assert kinds.count("washer") == 5
        top = next(piece.high[2] for piece in pieces if piece.kind == "stand-off")
        assert f"{top:g}" == name.rpartition("-")[2]


def moved(*by: float) -> Callable[[Piece], Piece]:
    return lambda piece: replace(piece, low=piece.low + by, high=piece.high + by)


def wider(x: float, y: float) -> Callable[[Piece], Piece]:
    by = np.array([x, y, 1.0])
    return lambda piece: replace(piece, low=piece.low * by, high=piece.high * by)


@pytest.mark.parametrize(
    ("kind", "change"),
    [
        ("washer", moved(0.5, 0.0, 0.0)),
        ("washer", moved(0.0, 0.0, 0.5)),
        ("disc", moved(0.0, 0.3, 0.0)),
        ("stand-off", moved(0.0, 0.0, -0.2)),
        ("bolt", moved(0.0, 0.0, -0.5)),
        ("bolt", moved(0.5, 0.0, 0.0)),
        ("nut", moved(0.0, 0.0, 1.0)),
        ("base plate", moved(0.0, 0.4, 0.0)),
        ("disc", wider(1.0, 1.1)),
        ("stand-off", wider(1.1, 1.0)),
        ("nut", lambda piece: replace(piece, high=np.add(piece.high, [1, 0, 0]))),
        *((kind, None) for kind in ("base plate", "stand-off", "disc", "washer", "bolt", "nut")),
    ],
)
def test_a_piece_out_of_place_out_of_shape_or_left_out_is_named_by_its_product(
    package: tuple[Path, Measured], kind: str, change: Callable[[Piece], Piece] | None
) -> None:
    folder, measured = package[0], copy.copy(package[1])
    name = min(measured.pieces)
    pieces = list(measured.pieces[name])
    at = next(k for k, piece in enumerate(pieces) if piece.kind == kind)
    pieces[at : at + 1] = [] if change is None else [change(pieces[at])]
    measured.pieces = {**measured.pieces, name: tuple(pieces)}
    assert found(folder, measured) == {name}


def test_a_piece_of_another_size_than_in_most_products_is_named(
    package: tuple[Path, Measured],
) -> None:
    folder, measured = package[0], copy.copy(package[1])
    own = next(iter(measured.pieces.values()))
    made = {f"FX-{k}": own for k in (1, 2, 3)}
    larger = [wider(1.1, 1.1)(piece) if piece.kind == "disc" else piece for piece in own]
    measured.pieces, measured.fixings = made | {"FX-4": tuple(larger)}, {}
    findings = Findings()
    check_fixings(WrittenPackage.open(folder), measured, findings)
    sizes = [finding for finding in findings.items if "size" in finding.what]
    assert [(finding.part, finding.what) for finding in sizes] == [
        ("FX-4", "size of its disc, elsewhere")
    ]


@pytest.mark.parametrize("degrees", [1.0, 30.0, 90.0])
def test_a_fixing_turned_about_its_own_axis_is_named(
    package: tuple[Path, Measured], degrees: float
) -> None:
    folder, measured = package[0], copy.copy(package[1])
    path, frame = next(iter(measured.fixings.items()))
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    measured.fixings = {**measured.fixings, path: frame @ turn}
    assert found(folder, measured) == {path[-1]}


def test_names_in_the_model_are_the_projects_and_the_products_own(
    package: tuple[Path, Measured], tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    shutil.copytree(package[0], folder)
    one, other = sorted(package[1].pieces)[:2]
    path = folder / "model" / "facade.step"
    text = path.read_text().replace("'Pavilion'", "'Another'")
    text = text.replace(f"'{one}'", "'~'").replace(f"'{other}'", f"'{one}'")
    path.write_text(text.replace("'~'", f"'{other}'"), newline="")
    measured, findings = Measured(), Findings()
    check_solids(WrittenPackage.open(folder), measured, findings)
    assert "model/facade.step" in {finding.part for finding in findings.items}
    assert found(folder, measured) == {one, other}
