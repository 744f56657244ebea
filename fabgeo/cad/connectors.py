"""The point fixing between a panel and a beam's outer flange as a product (paper, Fig. 9).

Adjustable in three directions: the base plate slides in its own slots along x, its bolts in the
flange's slots along y, the threaded rod turns along z. The product's origin is on the flange's
outer face where the rod's axis meets it; z points outwards.

Glossary
--------
stand-off
    Clear distance from the flange's outer face to the panel's inner face.
rod
    The bolt that carries the panel: from the base plate through stand-off sleeve and panel.
disc
    The round clamp plate on the panel's outer face.
"""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from OCP.TopoDS import TopoDS_Shape, TopoDS_Solid

from fabgeo.arrays import Array
from fabgeo.cad import fasteners
from fabgeo.cad.assembly import FAMILY_COLOURS, Colour, Node
from fabgeo.cad.measure import bounding_box
from fabgeo.cad.primitives import cut, cylinder, prism, rectangle, rounded_bar, tube
from fabgeo.errors import InputError
from fabgeo.structures.parts import Connector

if TYPE_CHECKING:
    from build123d.topology import Shape

_STEEL: Colour = (0.62, 0.64, 0.67)
_ZINC: Colour = (0.78, 0.79, 0.80)


def fixing_product(
    name: str,
    *,
    flange: float,
    panel: float,
    standoff: float = 25.0,
    rod: float = 12.0,
    base: tuple[float, float, float] = (120.0, 60.0, 8.0),
    base_bolt: float = 10.0,
    base_pitch: float = 80.0,
    base_slot: float = 10.0,
    disc: tuple[float, float] = (60.0, 6.0),
    library: bool = False,
) -> Node:
    """A point fixing of separate solids.

    Parameters
    ----------
    name : str
        Key of the product.
    flange, panel : float
        Thicknesses that it clamps.
    standoff : float
        From the flange's outer to the panel's inner face.
    rod, base_bolt : float
        Thread sizes (M) of the rod and of the two base bolts.
    base : tuple
        Length along x, width along y and thickness of the base plate.
    base_pitch, base_slot : float
        Distance of the two base bolts along x; length that their slots in the base plate add.
    disc : tuple
        Diameter and thickness of the clamp disc.
    library : bool
        Take bolts, nuts and washers from bd_warehouse (extra ``fasteners``).

    Raises
    ------
    InputError
        If the parts don't fit between flange and panel.
    """
    length, _, thick = base
    m, mb = fasteners.metric(rod), fasteners.metric(base_bolt)
    room = standoff - thick
    if room < max(mb.head + mb.washer[2], m.nut) or base_pitch + base_slot + mb.flats > length:
        raise InputError(
            f"connector {name}",
            f"a stand-off of {standoff:g} mm and a base of {length:g} mm leave no room for "
            f"M{rod:g} and M{base_bolt:g}",
            "take a larger stand-off, a longer base or smaller bolts",
        )
    made: list[Node] = []

    def add(label: str, shape: TopoDS_Shape, colour: Colour, place: Array | None = None) -> None:
        made.append(Node(label, shape=shape, colour=colour, location=place))

    add("base plate", _base_plate(base, m.size, mb.clearance, base_pitch, base_slot), _STEEL)
    # The rod is screwed into the base plate, a nut locks it, a sleeve carries the panel.
    add("stand-off", tube(1.8 * m.size + 4.0, m.size, thick, standoff), _STEEL)
    top = standoff + panel
    add("disc", tube(disc[0], m.clearance, top, top + disc[1]), FAMILY_COLOURS["connectors"])
    part = _library if library else _plain
    washer = part("washer", rod)
    grip = top + disc[1] + _height(washer)
    add("washer", washer, _ZINC, _at(top + disc[1]))
    add("rod", part("bolt", rod, grip), _ZINC, _at(grip))
    mirror = np.diag([1.0, -1.0, -1.0, 1.0])
    w = _height(part("washer", base_bolt))
    for x in (-base_pitch / 2.0, base_pitch / 2.0):
        bolt_length = _round_up(thick + flange + 2.0 * w + mb.nut + 2.0 * mb.pitch)
        add("base washer", part("washer", base_bolt), _ZINC, _at(thick, x))
        add("base bolt", part("bolt", base_bolt, bolt_length), _ZINC, _at(thick + w, x))
        add("flange washer", part("washer", base_bolt), _ZINC, _at(-flange - w, x))
        add("flange nut", part("nut", base_bolt), _ZINC, _at(-flange - w, x) @ mirror)
    return Node(name, children=_shared(made), layer="connectors")


def place_connectors(connectors: Sequence[Connector], products: dict[str, Node]) -> list[Node]:
    """Every connector as a node of its own mark that holds an instance of its product.

    Some programs (FreeCAD 0.20) show a product's name only, never an instance's: the node in
    between keeps the mark visible there.

    Raises
    ------
    InputError
        If a connector's product is missing.
    """
    out = []
    for connector in connectors:
        if connector.product not in products:
            raise InputError(
                f"connector {connector.mark}",
                f"its product {connector.product!r} is not among {sorted(products)}",
                "build it with fixing_product or user_product",
            )
        product = products[connector.product]
        placed = Node(product.name, instance_of=product, location=connector.frame)
        out.append(Node(connector.mark, children=(placed,)))
    return out


def user_product(name: str, make: Callable[[], Shape]) -> Node:
    """A product from a user's function that returns a build123d part.

    The part stands like `fixing_product`: origin on the flange's outer face, z outwards.

    Raises
    ------
    InputError
        If the function returns no solid.
    """
    from fabgeo.cad.convert import of_build123d

    part = make()
    if not hasattr(part, "wrapped"):
        raise InputError(f"connector {name}", f"expected a build123d part, found {type(part)}")
    node = of_build123d(part, name)
    return Node(name, shape=node.shape, children=node.children, colour=node.colour)


def _base_plate(
    base: tuple[float, float, float], bore: float, slot_width: float, pitch: float, slot: float
) -> TopoDS_Solid:
    length, width, thick = base
    z, x = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    tools: list[TopoDS_Shape] = [
        rounded_bar(np.array([sign * pitch / 2.0, 0.0, -1.0]), z, x, slot_width, slot, thick + 2.0)
        for sign in (-1.0, 1.0)
    ]
    tools.append(cylinder(bore, -1.0, thick + 1.0))
    return cut(prism(rectangle(length, width), 0.0, thick), tools, "base plate")


def _plain(kind: str, size: float, length: float = 0.0) -> TopoDS_Shape:
    if kind == "bolt":
        return fasteners.bolt(size, length)
    return fasteners.nut(size) if kind == "nut" else fasteners.washer(size)


def _library(kind: str, size: float, length: float = 0.0) -> TopoDS_Shape:
    return fasteners.from_library(kind, size, length)


def _height(shape: TopoDS_Shape) -> float:
    low, high = bounding_box(shape)
    return float(high[2] - low[2])


def _round_up(length: float, step: float = 5.0) -> float:
    return step * float(np.ceil(length / step))


def _at(z: float, x: float = 0.0) -> Array:
    place = np.eye(4)
    place[[0, 2], 3] = x, z
    return place


def _shared(nodes: list[Node]) -> tuple[Node, ...]:
    """Equal parts (by label) as instances of one product; numbered from 1."""
    products: dict[str, Node] = {}
    out = []
    for node in nodes:
        product = products.setdefault(
            node.name, Node(node.name, shape=node.shape, colour=node.colour)
        )
        count = sum(1 for other in out if other.instance_of is product)
        label = node.name if count == 0 else f"{node.name} {count + 1}"
        out.append(Node(label, instance_of=product, location=node.location))
    return tuple(out)
