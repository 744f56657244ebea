"""3MF files: placed triangles; bombs of either kind are refused."""

from __future__ import annotations

import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest

from fabgeo.errors import InputError
from fabgeo.surfaces.meshfile import read_mesh

SHEET = (
    '<vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="1" y="1" z="0"/>'
    '<vertex x="0" y="1" z="0"/></vertices><triangles><triangle v1="0" v2="1" v3="2"/>'
    '<triangle v1="0" v2="2" v3="3"/></triangles>'
)
HEAD = '<?xml version="1.0"?>'


def write(path: Path, inside: str, head: str = HEAD) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/3dmodel.model", f"{head}<model>{inside}</model>")
    return path


def objects(components: str, build: str) -> str:
    return (
        f'<resources><object id="1"><mesh>{SHEET}</mesh></object><object id="2"><components>'
        f"{components}</components></object></resources><build>{build}</build>"
    )


def test_components_are_placed_inside_out(tmp_path: Path) -> None:
    """Rows times matrices: first the component's quarter turn about z, then the item's shift."""
    turn = '<component objectid="1" transform="0 1 0 -1 0 0 0 0 1 0 0 5"/>'
    item = '<item objectid="2" transform="1 0 0 0 1 0 0 0 1 10 0 0"/>'
    mesh = read_mesh(write(tmp_path / "a.3mf", objects(turn, item)))
    assert np.allclose(mesh.vertices, [[10, 0, 5], [10, 1, 5], [9, 1, 5], [9, 0, 5]])
    assert len(mesh.triangles) == 2


@pytest.mark.parametrize(
    ("inside", "words"),
    [
        (objects('<component objectid="2"/>', '<item objectid="2"/>'), "without end"),
        (objects("", '<item objectid="7"/>'), "'7'"),
        (objects("", ""), "builds no mesh"),
        (objects("", '<item objectid="1" transform="1 2"/>'), "reshape"),
        (objects("", '<item objectid="1"/>').replace('v3="3"', 'v3="9"'), "not there"),
        (objects("", '<item objectid="1"/>').replace('"0"', '"nan"', 1), "finite|nan"),
        ("<vertex", "can't be read as 3MF"),
    ],
)
def test_damage_is_named(tmp_path: Path, inside: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_mesh(write(tmp_path / "a.3mf", inside))


def test_entities_that_multiply_are_refused(tmp_path: Path) -> None:
    doctype = '<!DOCTYPE m [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;">]>'
    with pytest.raises(InputError, match="document type"):
        read_mesh(write(tmp_path / "a.3mf", "&b;", HEAD + doctype))


def test_an_archive_that_unpacks_to_too_much_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.3mf"
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open("3D/3dmodel.model", "w", force_zip64=True) as stream,
    ):
        for _ in range(1030):
            stream.write(bytes(1 << 20))
    assert path.stat().st_size < 8 << 20
    with pytest.raises(InputError, match="more than is bearable"):
        read_mesh(path)


def test_no_more_is_unpacked_than_the_archive_says(tmp_path: Path) -> None:
    """A header that says 100 bytes of a megabyte: the rest is never unpacked."""
    path = tmp_path / "a.3mf"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/3dmodel.model", HEAD + " " * (1 << 20))
    size = struct.pack("<I", len(HEAD) + (1 << 20))
    data = path.read_bytes()
    assert data.count(size) >= 2
    path.write_bytes(data.replace(size, struct.pack("<I", 100)))
    with pytest.raises(InputError, match=r"a\.3mf: (is not a 3MF file|can't be)"):
        read_mesh(path)


def test_names_in_an_archive_lead_nowhere(tmp_path: Path) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    with zipfile.ZipFile(folder / "a.3mf", "w") as archive:
        archive.writestr("../../evil.model", "<model/>")
        archive.writestr("/tmp/evil.txt", "x")
    with pytest.raises(InputError, match="builds no mesh"):
        read_mesh(folder / "a.3mf")
    assert [p.name for p in tmp_path.rglob("*")] == ["in", "a.3mf"]


def test_components_that_multiply_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ten of ten of ten ... of nothing, 10^15 placings in 2 KB."""
    monkeypatch.setattr("fabgeo.surfaces.threemf.MOST_COMPONENTS", 1000)
    objects = '<object id="0"><mesh/></object>'
    for k in range(1, 16):
        ten = f'<component objectid="{k - 1}"/>' * 10
        objects += f'<object id="{k}"><components>{ten}</components></object>'
    inside = f'<resources>{objects}</resources><build><item objectid="15"/></build>'
    with pytest.raises(InputError, match="without end"):
        read_mesh(write(tmp_path / "a.3mf", inside))


def test_units_that_there_are_not_are_refused(tmp_path: Path) -> None:
    inside = objects("", '<item objectid="1"/>')
    path = write(tmp_path / "a.3mf", inside)
    for unit, right in [("meter", True), ("parsec", False)]:
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("3D/3dmodel.model", f'{HEAD}<model unit="{unit}">{inside}</model>')
        if right:
            assert len(read_mesh(path).triangles) == 2
        else:
            with pytest.raises(InputError, match="unknown unit 'parsec'; use micron"):
                read_mesh(path)


@pytest.mark.parametrize("method", [zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2])
def test_ways_of_packing_that_3mf_has_not_are_refused(tmp_path: Path, method: int) -> None:
    """A damaged byte makes one of them; their unpackers have errors of their own."""
    path = tmp_path / "x.3mf"
    with zipfile.ZipFile(path, "w", method) as archive:
        archive.writestr("3D/3dmodel.model", HEAD)
    with pytest.raises(InputError, match=r"^x\.3mf: is packed as 3MF files never are"):
        read_mesh(path)
