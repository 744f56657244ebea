"""Files of a package damaged beyond reading: findings that name them, never a traceback."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from review_package import write_package

from fabgeo.errors import InputError
from fabgeo.review.check import check_package


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("package") / "roof"
    write_package(folder, 1, 3)
    return folder


def edited(path: Path, change: Callable[[dict[str, object]], object]) -> None:
    content = json.loads(path.read_text("utf-8"))
    change(content)
    path.write_text(json.dumps(content), "utf-8")


DAMAGES: dict[str, tuple[str, Callable[[Path], object], str]] = {
    "no text": (
        "schedules/panels.csv",
        lambda p: p.write_bytes(p.read_bytes().replace(b"P-00-01", b"P-00-0\x8a")),
        "P-00-01",
    ),
    "rows of any length": (
        "schedules/panels.csv",
        lambda p: p.write_text("mark,mark\nP-00-00\n1,2,3,4\n\n"),
        "P-00-01",
    ),
    "a cell without end": (
        "schedules/panels.csv",
        lambda p: p.write_text('mark\n"' + "9" * 200_000),
        "P-00-01",
    ),
    "no number": (
        "cut/parts/P-00-01.dxf",
        lambda p: p.write_text(p.read_text().replace("\n 10\n", "\n 10\n1-2")),
        "P-00-01",
    ),
    "bends": ("cut/parts/P-00-01.bends.csv", lambda p: p.write_bytes(b"\x8a\n\x8a"), "P-00-01"),
    "words": (
        "checks/review.json",
        lambda p: edited(
            p, lambda r: r.update(summary={"solids": "x"}, limits=[1], parts={"a": 1})
        ),
        "checks/review.json",
    ),
    "a list": ("checks/review.json", lambda p: p.write_text("[[1]]"), "checks/review.json"),
    "depth": ("checks/review.json", lambda p: p.write_text("[" * 90_000), "checks/review.json"),
    "project": (
        "manifest.json",
        lambda p: edited(
            p, lambda m: m.update(project={"panels": 1, "cutting": {"tolerance": []}})
        ),
        "",
    ),
    "no project": ("manifest.json", lambda p: edited(p, lambda m: m.update(project=[1])), ""),
    "a model that kills the kernel": (
        "model/facade.step",
        lambda p: p.write_text(
            re.sub(r"EDGE_LOOP\(''(, ?)\(#\d+", r"EDGE_LOOP(''\1(#1", p.read_text())
        ),
        "model/facade.step",
    ),
    "half a model": (
        "model/facade.step",
        lambda p: p.write_bytes(p.read_bytes()[:9000]),
        "model/facade.step",
    ),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_damaged_files_are_findings(package: Path, tmp_path: Path, name: str) -> None:
    file, damage, part = DAMAGES[name]
    copy = shutil.copytree(package, tmp_path / "roof")
    damage(copy / file)
    report = check_package(copy)
    assert not part or part in report.parts, list(report.lines())
    assert not any(finding.what.startswith("files for") for finding in report.findings)


@pytest.mark.parametrize("text", ["[" * 90_000, "{", "[]"])
def test_no_manifest(package: Path, tmp_path: Path, text: str) -> None:
    copy = shutil.copytree(package, tmp_path / "roof")
    (copy / "manifest.json").write_text(text)
    with pytest.raises(InputError, match=r"manifest\.json: "):
        check_package(copy)


def test_a_workbook_that_unpacks_to_too_much_is_not_read(
    package: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert check_package(package).ok
    monkeypatch.setattr("fabgeo.review.check_tables.LARGEST_BOOK", 1000)
    (finding,) = check_package(package).findings
    assert (finding.part, finding.expected) == ("schedules/fabgeo.xlsx", "of bearable size")
