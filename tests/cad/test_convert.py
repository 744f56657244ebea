"""The tree as build123d, CadQuery and glb: same geometry, names, colours and places."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from cad_helpers import plate, revolution, square_hole

from fabgeo.cad.assembly import Node
from fabgeo.cad.convert import of_build123d, to_build123d, to_cadquery
from fabgeo.cad.glb import write_glb
from fabgeo.cad.measure import volume
from fabgeo.cad.mesh import prism_mesh, shape_mesh
from fabgeo.cad.solids import prism_solid
from fabgeo.structures.prisms import plate_prism


@pytest.fixture(scope="module")
def tree():
    product = Node("cell", prism_solid(revolution()), colour=(0.2, 0.4, 0.6))
    there = np.eye(4)
    there[2, 3] = 2000.0
    return Node(
        "roof",
        children=(
            Node("C-1", instance_of=product),
            Node("level 2", children=(Node("C-2", instance_of=product),), location=there),
        ),
    )


def test_build123d_shares_the_geometry(tree):
    compound = to_build123d(tree)
    assert compound.label == "roof"
    first, second = compound.leaves
    assert (first.label, second.label) == ("C-1", "C-2")
    assert first.wrapped.IsPartner(tree.children[0].instance_of.shape)
    assert tuple(first.color)[:3] == pytest.approx((0.2, 0.4, 0.6), abs=1e-6)
    assert pytest.approx(2000.0) == second.center().Z - first.center().Z


def test_build123d_and_back(tree):
    back = of_build123d(to_build123d(tree))
    assert [p.name for p in back.parts()] == ["C-1", "C-2"]
    assert next(p.colour for p in back.parts()) == pytest.approx((0.2, 0.4, 0.6), abs=1e-6)


def test_cadquery_shares_the_geometry(tree):
    pytest.importorskip("cadquery")
    assembly = to_cadquery(tree)
    assert [child.name for child in assembly.children] == ["C-1", "level 2"]
    shape = assembly.children[0].obj.wrapped
    assert shape.IsPartner(tree.children[0].instance_of.shape)
    box = assembly.toCompound().BoundingBox()
    assert box.zmax == pytest.approx(3500.0, abs=1.0)


def test_meshes_are_closed_and_converge_to_the_volume():
    trimesh = pytest.importorskip("trimesh")
    prism = revolution()
    exact, _ = volume(prism_solid(prism))
    errors = []
    for per_span in (4, 8):
        body = trimesh.Trimesh(*prism_mesh(prism, per_span))
        assert body.is_watertight
        errors.append(abs(body.volume / exact - 1.0))
    assert errors[1] == pytest.approx(errors[0] / 4.0, rel=0.1)
    body = trimesh.Trimesh(*shape_mesh(prism_solid(prism), 0.1))
    assert body.is_watertight
    assert body.volume == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("slot", [0.0, 30.0])
def test_mesh_of_a_bored_plate_is_closed_and_has_its_holes(slot):
    trimesh = pytest.importorskip("trimesh")
    mid = plate().mid
    holes = [square_hole(mid, u, v, 20.0, slot) for u, v in ((0.15, 0.2), (0.25, 0.5))]
    made = plate(holes=holes)
    prism = plate_prism(made)
    body = trimesh.Trimesh(*prism_mesh(prism, 8, made.holes))
    assert body.is_watertight
    assert body.euler_number == 2 - 2 * len(holes)  # genus 2
    whole = trimesh.Trimesh(*prism_mesh(prism, 8))
    corners = 10.0**2 * 6.0 * np.sin(np.pi / 6.0)  # a round end is a polygon of 12 corners
    taken = len(holes) * 8.0 * (corners + 20.0 * slot)
    assert whole.volume - body.volume == pytest.approx(taken, rel=0.05)


def test_glb_takes_a_mesh_in_place_of_a_shape(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    prism = revolution()
    node = Node("roof", children=(Node("C-1", mesh=prism_mesh(prism)),))
    (body,) = trimesh.load(write_glb(tmp_path / "x.glb", node)).geometry.values()
    assert body.volume == pytest.approx(volume(prism_solid(prism))[0], rel=1e-3)


def test_glb_holds_names_colours_and_metres(tree, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    scene = trimesh.load(write_glb(tmp_path / "x.glb", tree))
    assert {"roof", "C-1", "level 2", "C-2"} <= set(scene.graph.nodes)
    assert len(scene.geometry) == 1  # the product once
    low, high = scene.bounds
    assert high[1] == pytest.approx(3.5, abs=1e-3)  # metres, y up
    assert low[1] == pytest.approx(-0.1, abs=1e-3)
    (body,) = scene.geometry.values()
    linear = ((0.6 + 0.055) / 1.055) ** 2.4
    assert body.visual.material.baseColorFactor[2] == pytest.approx(255 * linear, abs=1.0)


def test_glb_holds_an_assembled_product_once_and_places_it(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    solid = prism_solid(revolution())
    up = np.eye(4)
    up[2, 3] = 5000.0
    two = (Node("a", solid, colour=(0.1, 0.2, 0.3)), Node("b", solid, colour=(0.9, 0.2, 0.3)))
    product = Node("fixing", children=(two[0], Node("b 1", instance_of=two[1], location=up)))
    places = np.repeat(np.eye(4)[None], 3, axis=0)
    places[:, 0, 3] = [0.0, 20_000.0, 40_000.0]
    fixings = [Node(f"K-{k}", instance_of=product, location=p) for k, p in enumerate(places)]
    scene = trimesh.load(write_glb(tmp_path / "x.glb", Node("roof", children=tuple(fixings))))
    assert {"roof", "K-0", "K-1", "K-2"} <= set(scene.graph.nodes)
    assert len(scene.geometry) == 2  # one a colour
    volumes = [body.volume for body in scene.dump()]
    assert volumes == pytest.approx([volume(solid)[0] * 1e-9] * 6, rel=1e-2)
    one = trimesh.load(write_glb(tmp_path / "y.glb", Node("one", solid)))
    low, high = one.bounds
    assert scene.bounds[1] == pytest.approx(np.add(high, [40.0, 5.0, 0.0]), abs=1e-4)  # y is up
    assert scene.bounds[0] == pytest.approx(low, abs=1e-4)


def test_a_tree_goes_to_other_processes_with_shared_products(tree):
    back = pickle.loads(pickle.dumps(tree))
    first, second = back.parts()
    assert first.instance_of is second.instance_of
    expected = volume(tree.children[0].instance_of.shape)[0]
    assert volume(first.instance_of.shape)[0] == pytest.approx(expected, rel=1e-14)
