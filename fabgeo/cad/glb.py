"""A product tree as glb (binary glTF 2.0) for viewing: names, colours, shared products.

glTF counts in metres with y upwards; the file holds metres under one root that turns z to y.
Source: the glTF 2.0 specification (ISO/IEC 12113), chapters 3 and 4.

Glossary
--------
primitive
    The triangles of one material in a mesh. A product that is an assembly of its own (a fixing)
    is one mesh with a primitive a colour: viewers open tens of thousands of nodes, not more.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from fabgeo.arrays import Array
from fabgeo.cad.assembly import Colour, Node
from fabgeo.cad.boredmesh import Mesh, joined
from fabgeo.cad.mesh import shape_mesh
from fabgeo.errors import InputError

_GREY: Colour = (0.7, 0.7, 0.7)
_TO_GLTF = np.array([[1e-3, 0, 0, 0], [0, 0, 1e-3, 0], [0, -1e-3, 0, 0], [0, 0, 0, 1]])
_VERTICES, _INDICES = 34962, 34963  # targets of buffer views
_NUMBERS = {np.dtype("<f4"): 5126, np.dtype("<u2"): 5123, np.dtype("<u4"): 5125}
_FEW = 2**16 - 1  # vertices whose indices are written in 16 bits
_SMALL = 10  # decimals of placements


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
    if next(root.parts(), None) is None:
        raise InputError(f"assembly {root.name!r}", "holds no part", "leave the file out")
    scene = _Scene(sag)
    scene.add(root, None, _TO_GLTF)
    target = Path(path)
    beside = target.with_name(f".{target.name}.part")
    with beside.open("wb") as file:
        file.writelines(scene.chunks())
    os.replace(beside, target)
    return target


class _Scene:
    """A scene while it is filled; a product's mesh is stored once."""

    def __init__(self, sag: float) -> None:
        self.sag = sag
        self.nodes: list[dict[str, Any]] = []
        self.meshes: list[dict[str, Any]] = []
        self.materials: dict[Colour, int] = {}
        self.accessors: list[dict[str, Any]] = []
        self.views: list[dict[str, Any]] = []
        self.data: list[bytes] = []
        self.size = 0
        self._made: dict[tuple[int, Colour], int] = {}
        self._meshed: dict[int, Mesh] = {}

    def add(self, node: Node, colour: Colour | None, frame: Array | None = None) -> int:
        """Number of the node; `frame` is what its parent is placed by, of the root."""
        product = node.instance_of or node
        colour = node.colour or product.colour or colour
        entry: dict[str, Any] = {"name": node.name}
        number = len(self.nodes)
        self.nodes.append(entry)
        place = node.location
        if frame is not None:
            place = frame if place is None else frame @ place
        if place is not None:
            entry["matrix"] = np.round(place.T.ravel(), _SMALL).tolist()
        if node.instance_of is not None or node.shape is not None or node.mesh is not None:
            entry["mesh"] = self._mesh(product, colour or _GREY)
        elif node.children:
            entry["children"] = [self.add(child, colour) for child in node.children]
        return number

    def _mesh(self, product: Node, colour: Colour) -> int:
        """Number of the product's mesh."""
        key = (id(product), colour)
        if key not in self._made:
            parts: dict[Colour, list[Mesh]] = {}
            for own, mesh in self._bodies(product, np.eye(4), colour):
                parts.setdefault(own, []).append(mesh)
            primitives = [self._primitive(own, *joined(some)) for own, some in parts.items()]
            self._made[key] = len(self.meshes)
            self.meshes.append({"name": product.name, "primitives": primitives})
        return self._made[key]

    def _bodies(self, product: Node, frame: Array, colour: Colour) -> Iterator[tuple[Colour, Mesh]]:
        """Colours and triangles of all that a product holds, in its own frame."""
        mesh = self._triangles(product)
        if mesh is not None:
            points, triangles = mesh
            yield colour, (points @ frame[:3, :3].T + frame[:3, 3], triangles)
        for child in product.children:
            inner = child.instance_of or child
            own = child.colour or inner.colour or colour
            at = frame if child.location is None else frame @ child.location
            yield from self._bodies(inner, at, own)

    def _triangles(self, product: Node) -> Mesh | None:
        if product.mesh is not None or product.shape is None:
            return product.mesh
        if id(product) not in self._meshed:
            self._meshed[id(product)] = shape_mesh(product.shape, self.sag)
        return self._meshed[id(product)]

    def _primitive(self, colour: Colour, points: Array, triangles: Any) -> dict[str, Any]:
        xyz = np.ascontiguousarray(points, dtype="<f4")
        index = np.ascontiguousarray(triangles.ravel(), dtype="<u2" if len(xyz) < _FEW else "<u4")
        place = self._accessor(xyz, "VEC3", _VERTICES)
        self.accessors[place] |= {
            "min": xyz.min(axis=0).tolist(),
            "max": xyz.max(axis=0).tolist(),
        }
        return {
            "attributes": {"POSITION": place},
            "indices": self._accessor(index, "SCALAR", _INDICES),
            "material": self.materials.setdefault(colour, len(self.materials)),
        }

    def _accessor(self, values: Any, kind: str, target: int) -> int:
        data = values.tobytes()
        view = {"buffer": 0, "byteOffset": self.size, "byteLength": len(data), "target": target}
        padded = data + b"\0" * (-len(data) % 4)
        self.data.append(padded)
        self.size += len(padded)
        self.views.append(view)
        self.accessors.append(
            {
                "bufferView": len(self.views) - 1,
                "componentType": _NUMBERS[values.dtype],
                "count": len(values),
                "type": kind,
            }
        )
        return len(self.accessors) - 1

    def chunks(self) -> Iterator[bytes]:
        """The file: its header, the scene as JSON, the numbers."""
        scene = {
            "asset": {"version": "2.0", "generator": "fabgeo"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": [_material(colour) for colour in self.materials],
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": self.size}],
        }
        text = json.dumps(scene, separators=(",", ":"), ensure_ascii=False).encode()
        text += b" " * (-len(text) % 4)
        whole = 12 + 8 + len(text) + 8 + self.size
        yield b"glTF" + _u32(2) + _u32(whole) + _u32(len(text)) + b"JSON" + text
        yield _u32(self.size) + b"BIN\0"
        yield from self.data


def _u32(number: int) -> bytes:
    return number.to_bytes(4, "little")


def _material(colour: Colour) -> dict[str, Any]:
    return {
        "pbrMetallicRoughness": {
            "baseColorFactor": [*(_linear(value) for value in colour), 1.0],
            "metallicFactor": 0.1,
            "roughnessFactor": 0.7,
        },
    }


def _linear(value: float) -> float:
    """SRGB to linear light, as glTF's factors are."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
