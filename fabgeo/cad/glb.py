"""A product tree as glb (binary glTF 2.0) for viewing: names, colours, shared products.

glTF counts in metres with y upwards; the file holds metres under one root that turns z to y.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from fabgeo.arrays import Array
from fabgeo.cad.assembly import Colour, Node
from fabgeo.cad.mesh import shape_mesh
from fabgeo.errors import InputError

_GREY: Colour = (0.7, 0.7, 0.7)
_TO_GLTF = np.array([[1e-3, 0, 0, 0], [0, 0, 1e-3, 0], [0, -1e-3, 0, 0], [0, 0, 0, 1]])


def write_glb(path: str | os.PathLike[str], root: Node, sag: float = 1.0) -> Path:
    """Write a product tree as glb, beside and then moved into place.

    Parameters
    ----------
    path : path
    root : Node
        Nodes with a `mesh` are written as it tells; other shapes are meshed by the kernel.
    sag : float
        Greatest distance of the kernel's triangles from the shape, mm.

    Returns
    -------
    Path
        The file.
    """
    import trimesh

    if next(root.parts(), None) is None:
        raise InputError(f"assembly {root.name!r}", "holds no part", "leave the file out")
    scene = trimesh.Scene(base_frame="world")
    _Scene(scene, sag).add(root, "world", _TO_GLTF, root.colour)
    target = Path(path)
    data: Any = scene.export(file_type="glb")
    beside = target.with_name(f".{target.name}.part")
    beside.write_bytes(bytes(data))
    os.replace(beside, target)
    return target


class _Scene:
    """A scene while it is filled; a product's mesh is stored once."""

    def __init__(self, scene: Any, sag: float) -> None:
        self.scene = scene
        self.sag = sag
        self.names: set[str] = set()
        self.counts: dict[str, int] = {}
        self.meshes: dict[tuple[int, Colour], str] = {}

    def add(self, node: Node, parent: str, matrix: Array, colour: Colour | None) -> None:
        if node.location is not None:
            matrix = matrix @ node.location
        product = node.instance_of or node
        colour = node.colour or product.colour or colour
        name = self._free(node.name)
        if product.shape is not None or product.mesh is not None:
            geometry = self._geometry(product, colour or _GREY)
            self.scene.graph.update(
                frame_from=parent, frame_to=name, matrix=matrix, geometry=geometry
            )
            return
        self.scene.graph.update(frame_from=parent, frame_to=name, matrix=matrix)
        for child in product.children:
            self.add(child, name, np.eye(4), colour)

    def _free(self, name: str) -> str:
        """The name, numbered where another node has it: frames must differ."""
        free = name
        while free in self.names:
            self.counts[name] = self.counts.get(name, 1) + 1
            free = f"{name} ({self.counts[name]})"
        self.names.add(free)
        return free

    def _geometry(self, product: Node, colour: Colour) -> str:
        import trimesh
        from trimesh.visual.material import PBRMaterial
        from trimesh.visual.texture import TextureVisuals

        key = (id(product), colour)
        if key not in self.meshes:
            shape = product.shape
            mesh = product.mesh or (shape_mesh(shape, self.sag) if shape is not None else None)
            if mesh is None:
                raise InputError(product.name, "has neither shape nor mesh")
            linear = [*(_linear(c) for c in colour), 1.0]
            material = PBRMaterial(
                name=product.name, baseColorFactor=linear, metallicFactor=0.1, roughnessFactor=0.7
            )
            visual = TextureVisuals(material=material)
            body = trimesh.Trimesh(*mesh, process=False, visual=visual)
            name = f"{product.name}#{len(self.meshes)}"
            self.scene.geometry[name] = body
            self.meshes[key] = name
        return self.meshes[key]


def _linear(value: float) -> float:
    """SRGB to linear light, as glTF's factors are."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
