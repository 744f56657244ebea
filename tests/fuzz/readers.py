"""What is fuzzed: each reader of files with seeds, as a function from bytes to nothing.

A reader may answer or raise an error of fabgeo; anything else is a finding. A surface that is
read must also answer the first questions that a build asks: finite points, no silent NaN.
"""

from __future__ import annotations

import contextlib
import io
import json
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from cadfiles import Forked, iges_files, rhino_files, step_files
from packagefiles import check_damaged, package_files

from fabgeo.errors import FabgeoError

GRID = [(float(i), float(j), 0.1 * i * j) for j in range(4) for i in range(4)]
QUADS = [
    (4 * j + i, 4 * j + i + 1, 4 * j + i + 5, 4 * j + i + 4) for j in range(3) for i in range(3)
]
OBJ = "".join(f"v {x} {y} {z}\n" for x, y, z in GRID) + "".join(
    "f " + " ".join(str(k + 1) for k in quad) + "\n" for quad in QUADS
)
OFF = (
    "OFF\n16 9 0\n"
    + "".join(f"{x} {y} {z}\n" for x, y, z in GRID)
    + "".join("4 " + " ".join(map(str, quad)) + "\n" for quad in QUADS)
)
RINGS = [
    [(9 * np.cos(t), 6 * np.sin(t), 3.0 * k) for t in np.linspace(0, 2 * np.pi, 12, endpoint=False)]
    for k in range(3)
]
CSV = "section,x,y,z\n" + "".join(
    f"{k},{x:.6f},{y:.6f},{z}\n" for k, ring in enumerate(RINGS) for x, y, z in ring
)
PROJECT = """
name = "x"
[surface]
unit = "m"
u = [0.0, 1.0]
v = [0.0, 1.0]
x = "u"
y = "v"
z = "u*v + sin(a)"
[surface.define]
a = "2*u"
[strips]
kind = "conical"
count = 4
[panels]
length = 900.0
materials = { P-00-00 = "glass" }
[cells]
depth = -200.0
[[stock]]
material = "aluminium"
length = 4000.0
width = 2000.0
"""
TOKENS = (
    b"nan",
    b"inf",
    b"-1",
    b"0",
    b"1e999",
    b"99999999999",
    b"\n",
    b"\x00",
    b"\xff",
    b"..",
    b"/",
)


@dataclass(frozen=True)
class Reader:
    """A reader under test: the suffix of its files, seeds, and what reads a file."""

    suffix: str
    seeds: Callable[[], list[bytes]]
    read: Callable[[Path], object]

    def __call__(self, data: bytes) -> None:
        """Read these bytes as a file; errors of fabgeo are answers."""
        with contextlib.suppress(FabgeoError):
            self.read_bytes(data)

    def read_bytes(self, data: bytes) -> None:
        """Read these bytes as a file in a folder of its own: no other file may appear there."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"x{self.suffix}"
            path.write_bytes(data)
            try:
                self.read(path)
            finally:
                strange = [p.name for p in Path(folder).iterdir() if p != path]
                assert not strange, f"files appeared: {strange}"


def _surface(path: Path, unit: str | None = "m") -> None:
    from fabgeo.cad.read_surface import read_surface

    surface = read_surface(path, unit=unit)
    found = surface.closest(np.array([[1500.0, 1500.0, 200.0]]))
    assert np.isfinite(found.point).all(), found
    assert np.isfinite(found.normal).all(), found


def _forked() -> None:
    """Let native readers work in a process that is ready at once, and not for long."""
    from fabgeo.cad import isolated

    isolated.SECONDS, isolated.start = 5.0, Forked


def _native(path: Path) -> None:
    """Files that state their unit."""
    _forked()
    _surface(path, None)


def _in_package(path: Path) -> None:
    _forked()
    check_damaged(path)


def _project(path: Path) -> None:
    from fabgeo.project import parse_project, read_project

    project = read_project(path)
    again = parse_project(project.model_dump(mode="json", exclude_none=True))
    assert again == project


def _model(path: Path) -> None:
    from fabgeo.fitting.store import load_model

    assert np.isfinite(load_model(path).control).all()


def _part(path: Path) -> None:
    from fabgeo.sheets.dxf_read import read_part

    read_part(path)


def _entry(path: Path) -> None:
    from fabgeo.build.cache import read_entry
    from fabgeo.build.plain import unpack

    read_entry(path)
    unpack(path.read_bytes())


def model_bytes() -> bytes:
    """A small strip model as fabgeo stores it."""
    from fabgeo.fitting.store import save_model
    from fabgeo.strips.model import StripModel

    control = np.zeros((3, 7, 3))
    control[..., 0] = np.arange(7)
    control[..., 1] = np.arange(3)[:, None]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "strips.json"
        save_model(path, StripModel(control))
        return path.read_bytes()


def _drawings() -> list[bytes]:
    import ezdxf

    out = []
    for version in ("R12", "R2010"):
        document = ezdxf.new(version)
        space = document.modelspace()
        for ring in RINGS:
            if version == "R12":
                space.add_polyline3d([*ring, ring[0]])
            else:
                points = [(x, y) for x, y, _ in ring]
                made = space.add_lwpolyline(points, close=True, dxfattribs={"layer": "CUT_OUTER"})
                made.dxf.elevation = ring[0][2]
        stream = io.StringIO()
        document.write(stream)
        out.append(stream.getvalue().encode())
    return out


def _parts() -> list[bytes]:
    """One flat part as fabgeo writes it."""
    from fabgeo.panels.unfold import unfold
    from fabgeo.sheets.dxf import write_part
    from fabgeo.strips.ruled import RuledPatch

    s = np.linspace(0.0, 500.0, 4)
    edges = np.stack([np.stack([s, 0 * s + y, 1e-4 * s**2], axis=-1) for y in (0.0, 300.0)])
    mid = RuledPatch(np.repeat([0.0, 1.0], 4), edges)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "P-00-00.dxf"
        write_part(unfold(mid, "P-00-00", "steel", 3.0), path)
        return [path.read_bytes()]


def _entries() -> list[bytes]:
    from fabgeo.build.plain import pack
    from fabgeo.panels.flat import BendLine

    bends = tuple(BendLine(k * np.ones(2), np.arange(2.0), 9.0) for k in range(4))
    return [pack({"a": (np.arange(6.0), [1, None, "x"]), "b": b"bytes"}), pack(bends)]


def _archives() -> list[bytes]:
    """Once packed, once as it is: changes reach the XML only there."""
    mesh = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in GRID)
    faces = [f for a, b, c, d in QUADS for f in ((a, b, c), (a, c, d))]
    mesh = f"<vertices>{mesh}</vertices><triangles>" + "".join(
        f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in faces
    )
    move = 'transform="1 0 0 0 1 0 0 0 1 5 6 7"'
    text = (
        f'<model unit="meter"><resources><object id="1"><mesh>{mesh}</triangles></mesh></object>'
        f'<object id="2"><components><component objectid="1" {move}/></components></object>'
        f'</resources><build><item objectid="2" {move}/></build></model>'
    )
    out = []
    for method in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        stream = io.BytesIO()
        with zipfile.ZipFile(stream, "w", method) as archive:
            archive.writestr("3D/3dmodel.model", text)
        out.append(stream.getvalue())
    return out


def _meshes(kind: str) -> Callable[[], list[bytes]]:
    def seeds() -> list[bytes]:
        import trimesh

        faces = [f for a, b, c, d in QUADS for f in ((a, b, c), (a, c, d))]
        mesh = trimesh.Trimesh(GRID, faces, process=False)
        data = mesh.export(file_type=kind)
        return [data if isinstance(data, bytes) else str(data).encode()]

    return seeds


def _sections() -> list[bytes]:
    return [
        json.dumps(
            {"sections": [{"name": str(k), "points": r} for k, r in enumerate(RINGS)]}
        ).encode()
    ]


READERS = {
    "project": Reader(".toml", lambda: [PROJECT.encode()], _project),
    "obj": Reader(".obj", lambda: [OBJ.encode()], _surface),
    "off": Reader(".off", lambda: [OFF.encode()], _surface),
    "stl": Reader(".stl", _meshes("stl"), _surface),
    "ply": Reader(".ply", _meshes("ply"), _surface),
    "3mf": Reader(".3mf", _archives, _surface),
    "csv": Reader(".csv", lambda: [CSV.encode()], _surface),
    "json": Reader(".json", _sections, _surface),
    "dxf": Reader(".dxf", _drawings, _surface),
    "step": Reader(".step", step_files, _native),
    "iges": Reader(".igs", iges_files, _native),
    "3dm": Reader(".3dm", rhino_files, _native),
    "part": Reader(".dxf", _parts, _part),
    "model": Reader(".json", lambda: [model_bytes()], _model),
    "package": Reader("", package_files, _in_package),
    "cache": Reader("", _entries, _entry),
}
