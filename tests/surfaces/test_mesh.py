"""Meshes: readers, checks, grids, and the smooth surfaces over them."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fabgeo.errors import FabgeoError, InputError
from fabgeo.surfaces.mesh import Mesh, checked_mesh
from fabgeo.surfaces.meshfile import parse_obj, parse_off, read_mesh
from fabgeo.surfaces.meshsurface import MeshSurface
from fabgeo.surfaces.quadgrid import GridSurface, quad_grid

OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nf 1 2 3 4\nf 2/1 5/2/3 6//1 3\n"


def grid_mesh(
    rows: int, columns: int, closed=(False, False), shuffle=True
) -> tuple[Mesh, np.ndarray]:
    """A regular mesh (open: a wavy sheet, closed columns: a tube, both: a torus) and its grid."""
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    if closed[1]:
        t = 2 * np.pi * j / columns
        s = 2 * np.pi * i / rows
        r = 5 + 2 * np.cos(s) if closed[0] else 5 + 0.1 * i
        z = 2 * np.sin(s) if closed[0] else 1.0 * i
        points = np.stack([r * np.cos(t), r * np.sin(t), z], axis=-1)
    else:
        points = np.stack([1.0 * i, 1.0 * j, np.sin(0.5 * i) * np.cos(0.4 * j)], axis=-1)
    last = [rows if closed[0] else rows - 1, columns if closed[1] else columns - 1]
    index = np.arange(rows * columns).reshape(rows, columns)
    faces = [
        [
            index[a, b],
            index[(a + 1) % rows, b],
            index[(a + 1) % rows, (b + 1) % columns],
            index[a, (b + 1) % columns],
        ]
        for a in range(last[0])
        for b in range(last[1])
    ]
    if shuffle:
        random = np.random.default_rng(1)
        faces = [
            list(np.roll(f, k))
            for f, k in zip(faces, random.integers(0, 4, len(faces)), strict=True)
        ]
        faces = [faces[k] for k in random.permutation(len(faces))]
    return checked_mesh("grid", points.reshape(-1, 3), faces), points


def test_obj_keeps_quads():
    vertices, faces = parse_obj("a.obj", OBJ)
    assert faces == [[0, 1, 2, 3], [1, 4, 5, 2]]
    mesh = checked_mesh("a.obj", vertices, faces)
    assert len(mesh.quads) == 2
    assert len(mesh.triangles) == 0
    assert [len(x) for x in mesh.loops] == [6]


def test_obj_negative_indices_and_continued_lines():
    text = "v 0 0 0\nv 1 0 0\nv 1 1 \\\n 0\nf -3 -2 -1\n"
    vertices, faces = parse_obj("a.obj", text)
    assert vertices.tolist()[2] == [1.0, 1.0, 0.0]
    assert faces == [[0, 1, 2]]


OFF = "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"


def test_off():
    vertices, faces = parse_off("a.off", OFF)
    assert vertices.shape == (4, 3)
    assert faces == [[0, 1, 2, 3]]


# The second face lies on the first.
FOLDED = "v 0 0 0\nv 2 0 0\nv 1 1 0\nv 1 1 1e-3\nf 1 2 3\nf 2 1 4\n"


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.off", OFF.replace("4 0 1 2 3", "4 1 2 3 4"), "look 1-based"),
        ("a.off", OFF.replace("1 1 0", "1 nan 0"), "a.off, line 5: a coordinate is not finite"),
        ("a.off", OFF.replace("4 1 0\n", "9 1 0\n"), "announces 9 vertices"),
        ("a.off", "ply\n", "expected the word OFF"),
        ("a.off", OFF.replace("0 1 2 3", "0 1 2"), "line 7: expected a count"),
        ("a.obj", OBJ.replace("f 1", "f 0"), "a.obj, line 7: a face refers to vertex 0"),
        ("a.obj", OBJ.replace("f 1", "f 77"), "line 7: a face refers to vertex 77"),
        ("a.obj", OBJ.replace("v 1 1 0", "v 1 inf 0"), "line 3: a coordinate is not finite"),
        ("a.obj", OBJ.replace("v 1 1 0", "v 1 one 0"), "line 3: expected three coordinates"),
        ("a.obj", "v 0 0 0\n", "the mesh is empty"),
        ("a.obj", OBJ + "f 1 1 2\n", "is degenerate|no area"),
        ("a.obj", OBJ + "v 1 0 5\nf 2 3 7\n", r"edge between vertices 1 and 2 .* has 3 faces"),
        ("a.obj", OBJ + "v 9 9 9\nv 9 8 9\nv 8 8 9\nf 7 8 9\n", "2 separate pieces of 2, 1 faces"),
        ("a.obj", OBJ + "v -1 -1 0\nv -1 0 0\nf 1 7 8\n", "two sheets touch at vertex 0"),
        ("a.obj", FOLDED, "around vertex 0 .* fold back on each other"),
    ],
)
def test_bad_files_name_the_place(tmp_path, name, text, message):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        read_mesh(path)


def test_missing_file(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_mesh(tmp_path / "nothing.obj")


def test_a_piece_can_be_chosen(tmp_path):
    path = tmp_path / "two.obj"
    path.write_text(OBJ + "v 9 9 9\nv 9 8 9\nv 8 8 9\nf 7 8 9\n")
    assert len(read_mesh(path, piece="largest").quads) == 2
    assert len(read_mesh(path, piece=1).triangles) == 1


def test_turned_faces_are_put_right_and_moebius_refused():
    vertices, faces = parse_obj("a.obj", OBJ)
    mesh = checked_mesh("a", vertices, [faces[0], faces[1][::-1]])
    normal = np.cross(
        *(mesh.vertices[mesh.quads][:, k] - mesh.vertices[mesh.quads][:, 0] for k in (1, 3))
    )
    assert (np.sign(normal[:, 2]) == np.sign(normal[0, 2])).all()
    t = np.arange(8) * 2 * np.pi / 8
    half = np.column_stack([np.cos(t / 2) * np.cos(t), np.cos(t / 2) * np.sin(t), np.sin(t / 2)])
    ring = 4 * np.column_stack([np.cos(t), np.sin(t), 0 * t])
    band = np.concatenate([ring + half, ring - half])
    strips = [[k, k + 1, 9 + k, 8 + k] for k in range(7)] + [[7, 8, 0, 15]]
    with pytest.raises(InputError, match="one-sided"):
        checked_mesh("band", band, strips)


@pytest.mark.parametrize("kind", [".stl", ".ply"])
def test_through_trimesh(tmp_path, kind):
    import trimesh

    path = tmp_path / f"ball{kind}"
    ball = trimesh.creation.icosphere(2, 3.0)
    ball.export(path)
    mesh = read_mesh(path)
    assert len(mesh.triangles) == len(ball.faces)
    assert len(mesh.vertices) == len(ball.vertices)  # STL's copies are welded
    assert mesh.loops == ()


@pytest.mark.parametrize("kind", [".stl", ".ply", ".3mf"])
def test_nonsense_for_trimesh(tmp_path, kind):
    path = tmp_path / f"junk{kind}"
    path.write_bytes(b"\x00\x01 nothing of the sort" * 20)
    with pytest.raises(InputError):
        read_mesh(path)


@pytest.mark.parametrize("closed", [(False, False), (False, True), (True, True)])
def test_grids_are_found(closed):
    mesh, points = grid_mesh(7, 9, closed)
    grid = quad_grid(mesh)
    assert grid is not None
    assert sorted(grid.index.shape) == [7, 9]
    assert {grid.closed_rows, grid.closed_columns} == set(closed)
    edges = {frozenset(e) for f in mesh.faces for e in zip(f, f[1:] + f[:1], strict=True)}
    along = zip(grid.index[:-1].ravel(), grid.index[1:].ravel(), strict=True)
    across = zip(grid.index[:, :-1].ravel(), grid.index[:, 1:].ravel(), strict=True)
    assert {frozenset(map(int, pair)) for pair in (*along, *across)} <= edges
    assert points.shape == (7, 9, 3)


def test_irregular_meshes_have_no_grid():
    mesh, _ = grid_mesh(6, 6, shuffle=False)
    middle = [f for f in mesh.quads.tolist() if f != mesh.quads.tolist()[12]]
    assert quad_grid(checked_mesh("hole", mesh.vertices, middle)) is None
    vertices, faces = parse_obj("a.obj", OBJ + "v 3 0.5 0\nf 5 7 6\n")
    assert quad_grid(checked_mesh("mixed", vertices, faces)) is None


@pytest.mark.parametrize("closed", [(False, False), (False, True), (True, True)])
def test_grid_surface_passes_its_points(closed):
    mesh, _ = grid_mesh(12, 16, closed)
    grid = quad_grid(mesh)
    surface = GridSurface(mesh.vertices[grid.index], grid.closed_rows, grid.closed_columns)
    assert np.abs(surface.closest(mesh.vertices).point - mesh.vertices).max() < 1e-8
    assert len(surface.loops) == {(False, False): 1, (False, True): 2, (True, True): 0}[closed]
    assert pickle.loads(pickle.dumps(surface)).fingerprint == surface.fingerprint


def test_grid_surface_converges_with_the_fourth_power():
    errors = []
    for n in (8, 16, 32):
        mesh, _ = grid_mesh(n, 2 * n, (True, True), shuffle=False)
        grid = quad_grid(mesh)
        surface = GridSurface(mesh.vertices[grid.index], True, True)
        p = surface.sample(2000).point
        ring = np.hypot(p[:, 0], p[:, 1]) - 5.0
        errors.append(np.abs(np.hypot(ring, p[:, 2]) - 2.0).max())
    assert errors[0] / errors[1] > 12.0
    assert errors[1] / errors[2] > 12.0


@pytest.mark.parametrize("count", [3, 4])
def test_closed_rows_of_few_points(count):
    t = 2 * np.pi * np.arange(count) / count
    rows = [np.column_stack([np.cos(t), np.sin(t), 0 * t + z]) for z in (0.0, 1.0)]
    surface = GridSurface(np.stack(rows), False, True)
    assert surface.charts[0].closed == (False, True)
    assert np.abs(surface.closest(np.concatenate(rows)).point - np.concatenate(rows)).max() < 1e-9


def test_smooth_mesh_converges_to_the_sphere():
    import trimesh

    point, bend = [], []
    for level in (2, 3, 4):
        ball = trimesh.creation.icosphere(level, 10.0)
        surface = MeshSurface(checked_mesh("ball", ball.vertices, ball.faces.tolist()))
        x = surface.sample(500).point * 1.03
        at = surface.closest(x)
        point.append(np.abs(np.linalg.norm(at.point, axis=1) - 10.0).max())
        bend.append(np.abs(at.principal()[0] * 10.0 + 1.0).max())
        out = x / np.linalg.norm(x, axis=1)[:, None]
        assert np.abs(at.point - 10.0 * out).max() < 20.0 * point[-1]
    assert point[0] / point[1] > 7.0  # third order or better
    assert point[1] / point[2] > 7.0
    assert bend[2] < 0.01
    assert bend[0] / bend[1] > 3.0


def test_smooth_mesh_foot_points_and_boundary():
    mesh, _ = grid_mesh(12, 14)
    surface = MeshSurface(mesh)
    assert surface.grid is None
    x = surface.sample(300).point + np.array([0.0, 0.0, 0.3])
    at = surface.closest(x)
    r = x - at.point
    inner = ~at.on_boundary
    assert inner.mean() > 0.9
    assert np.abs(np.cross(r, at.normal))[inner].max() < 0.01
    beside = surface.closest(np.array([[-3.0, 5.0, 0.0], [5.0, 20.0, 0.0]]))
    assert beside.on_boundary.all()
    assert np.abs(beside.point[0] - [0.0, 5.0, 0.0]).max() < 0.2
    lengths = [np.linalg.norm(np.roll(x, -1, 0) - x, axis=1).sum() for x in surface.loops]
    assert lengths == pytest.approx([48.0], rel=0.08)


def test_shared_meshes(shared_data):
    shapes = {}
    for path in sorted((shared_data / "surfaces").glob("*.obj")):
        mesh = read_mesh(path)
        grid = quad_grid(mesh)
        shapes[path.stem] = None if grid is None else grid.index.shape
    assert shapes["conical1"] == (31, 37)
    assert shapes["enneper2"] == (31, 31)
    assert shapes["barrel"] == (21, 21)
    assert shapes["botanic-garden-bubble-0"] is None


LINES = st.lists(
    st.one_of(
        st.builds(lambda *a: "v " + " ".join(map(str, a)), *[st.floats(-9, 9)] * 3),
        st.builds(lambda a: "f " + " ".join(map(str, a)), st.lists(st.integers(-4, 9), max_size=6)),
        st.text(alphabet="vf#OFF/.\\ 0123456789-e\t", max_size=20),
    ),
    max_size=40,
)


@settings(max_examples=150, deadline=None)
@given(LINES)
def test_readers_answer_or_refuse(lines):
    """Whatever the text: a mesh that obeys its laws, or an error of ours."""
    for parse, text in ((parse_obj, "\n".join(lines)), (parse_off, "OFF\n" + "\n".join(lines))):
        try:
            mesh = checked_mesh("fuzz", *parse("fuzz", text))
        except FabgeoError:
            continue
        edges = [tuple(sorted(e)) for f in mesh.faces for e in zip(f, f[1:] + f[:1], strict=True)]
        _, counts = np.unique(edges, axis=0, return_counts=True)
        assert counts.max() <= 2
        assert sum(len(x) for x in mesh.loops) == (counts == 1).sum()


def test_a_ply_file_that_ends_too_early_is_refused(tmp_path):
    head = "ply\nformat ascii 1.0\nelement vertex 4\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz")
    head += "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    lines = ["0 0 0", "1 0 0", "1 1 0", "0 1 0", "3 0 1 2", "3 0 2 3"]
    path = tmp_path / "a.ply"
    path.write_text(head + "\n".join(lines) + "\n")
    assert len(read_mesh(path).triangles) == 2
    path.write_text(head + "\n".join(lines[:-1]) + "\n")
    with pytest.raises(InputError, match=r"a\.ply: "):
        read_mesh(path)


@pytest.mark.parametrize(
    ("vertices", "faces", "words"),
    [
        (np.eye(3), [(0.5, 1, 2)], "whole vertex indices"),
        (np.eye(3), [(0, 1, 10**30)], "whole vertex indices"),
        (np.eye(3), ["abc"], "whole vertex indices"),
        (np.eye(3), [None], "faces of vertex indices"),
        (np.eye(3) + 1j, [(0, 1, 2)], "vertices: expected numbers: found complex ones"),
        ([["a", "b", "c"]] * 3, [(0, 1, 2)], "vertices: expected numbers"),
        (np.eye(3).ravel(), [(0, 1, 2)], r"expected vertices \(n, 3\)"),
    ],
)
def test_what_is_no_mesh_is_refused(vertices, faces, words):
    with pytest.raises(InputError, match=words):
        checked_mesh("a", vertices, faces)


@pytest.mark.parametrize("far", [1e3, 1e6])
def test_a_grid_whose_surface_would_swing_out_between_its_points_is_refused(far: float) -> None:
    """One point of 30 far off: at 100 times its place the surface stays within 3 %."""
    i, j = np.meshgrid(np.arange(5.0), np.arange(6.0), indexing="ij")
    grid = np.stack([i, j, 0.1 * i * j], axis=-1) * 1000.0
    grid[-1, -1] *= far
    with pytest.raises(InputError, match=r"net: .*look for points far off the others"):
        GridSurface(grid, name="net")
