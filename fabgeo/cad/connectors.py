"""The point fixing between a panel and a beam's outer flange as a product (paper, Fig. 9).

Adjustable in three directions: the slots of flange and base plate cross each other, and the
stand-off sleeve turns on the bolt's thread. Origin and axes are those of
`fabgeo.structures.fixing`: on the flange's outer face, z towards the panel, x along its edge.

Glossary
--------
rod
    The bolt that carries the panel, screwed into the base plate.
through bolt
    Where a hole of the panel and one of the flange are in line: one bolt holds disc, panel,
    sleeve, base plate and flange, with washers at both ends and a nut under the flange.
base bolt
    A hole of the flange alone: a bolt from the base plate through the flange.
disc
    The round clamp plate on the panel's outer face.
"""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from OCP.TopoDS import TopoDS_Shape, TopoDS_Solid

from fabgeo.arrays import Array
from fabgeo.cad import fasteners
from fabgeo.cad.assembly import FAMILY_COLOURS, Colour, Node
from fabgeo.cad.measure import bounding_box
from fabgeo.cad.primitives import cut, cylinder, prism, rectangle, rounded_bar, tube
from fabgeo.errors import InputError
from fabgeo.structures.fixing import Fixing, LocalHole
from fabgeo.structures.parts import Connector

_STEEL: Colour = (0.62, 0.64, 0.67)
_ZINC: Colour = (0.78, 0.79, 0.80)
_DISC: Colour = FAMILY_COLOURS["connectors"]


def fixing_product(
    fixing: Fixing | str,
    *,
    flange: float,
    panel: float,
    library: bool = False,
    standoff: float = 25.0,
    rod: float = 12.0,
    base: tuple[float, float, float] = (120.0, 60.0, 8.0),
    base_bolt: float = 10.0,
    base_pitch: float = 80.0,
    base_slot: float = 10.0,
    disc: tuple[float, float] = (60.0, 6.0),
) -> Node:
    """The product of a fixing: separate solids, or what the user's own maker returns.

    Parameters
    ----------
    fixing : Fixing or str
        With its real stand-off; or a product's name, then the sizes below apply.
    flange, panel : float
        Thicknesses that it clamps, mm.
    library : bool
        Take bolts, nuts and washers from bd_warehouse (extra ``fasteners``).
    standoff, rod, base_bolt, base_pitch, base_slot : float
        Stand-off, thread sizes, distance of the two base bolts, length of their slots.
    base, disc : tuple
        Length, width, thickness of the base plate; diameter, thickness of the disc.

    Raises
    ------
    InputError
        If there is no such bolt, or the stand-off leaves no room for the sleeve.
    """
    if isinstance(fixing, Fixing):
        return _product(fixing.product, fixing, panel, flange, library)
    slotted = [
        LocalHole(x, 0.0, fasteners.metric(base_bolt).clearance, base_slot, np.pi / 2.0)
        for x in (-base_pitch / 2.0, base_pitch / 2.0)
    ]
    drawn = Fixing(
        name=fixing,
        stand_off=standoff,
        rod=rod,
        base_bolt=base_bolt,
        base_length=base[0],
        base_width=base[1],
        base_thickness=base[2],
        disc_diameter=disc[0],
        disc_thickness=disc[1],
        flange_holes=tuple(slotted),
    )
    return _product(fixing, drawn, panel, flange, library)


def _product(name: str, fixing: Fixing, panel: float, flange: float, library: bool) -> Node:
    if fixing.maker is not None:
        maker = fixing.maker
        return user_product(name, lambda: maker(fixing))
    m = fasteners.metric(fixing.rod)
    rods = _Fasteners(fixing.rod, library)
    thick, top = fixing.base_thickness, fixing.stand_off + panel
    if fixing.stand_off - thick < 1.0:
        raise InputError(
            f"connector {name}",
            f"a stand-off of {fixing.stand_off:g} mm leaves no room for a sleeve over the base "
            f"plate of {thick:g} mm",
            "take a larger stand-off or a thinner base plate",
        )
    made = [("base plate", _base_plate(fixing), _STEEL, np.eye(4))]
    for hole in fixing.panel_holes:
        at = _at(hole.x, hole.y)
        sleeve = tube(1.8 * m.size + 4.0, m.clearance, thick, fixing.stand_off)
        disc = tube(fixing.disc_diameter, m.clearance, top, top + fixing.disc_thickness)
        made += [("stand-off", sleeve, _STEEL, at), ("disc", disc, _DISC, at)]
        through = _in_line(hole, fixing.flange_holes)
        end = -flange if through else 0.0
        made += rods.bolted(top + fixing.disc_thickness, end, at, nut=through)
    for hole in fixing.flange_holes:
        if not _in_line(hole, fixing.panel_holes):
            bolts = _Fasteners(fixing.base_bolt, library)
            made += bolts.bolted(thick, -flange, _at(hole.x, hole.y), nut=True)
    return Node(name, children=_shared(made), layer="connectors")


def fixing_products(
    products: Mapping[str, Fixing], *, panel: float, flange: float, library: bool = False
) -> dict[str, Node]:
    """All products of a set of fixings (`Fixings.products`) by key, each built once."""
    return {
        key: fixing_product(fixing, panel=panel, flange=flange, library=library)
        for key, fixing in products.items()
    }


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


def user_product(name: str, make: Callable[[], object]) -> Node:
    """A product from a user's function that returns a build123d part.

    The part stands like `fixing_product`: origin on the flange's outer face, z outwards.

    Raises
    ------
    InputError
        If the function returns no solid.
    """
    from build123d.topology import Shape

    from fabgeo.cad.convert import of_build123d

    part = make()
    if not isinstance(part, Shape):
        raise InputError(f"connector {name}", f"expected a build123d part, found {type(part)}")
    node = of_build123d(part, name)
    return Node(name, shape=node.shape, children=node.children, colour=node.colour)


type _Made = tuple[str, TopoDS_Shape, Colour, Array]


class _Fasteners:
    """Bolts, washers and nuts of one size, plain or from the library."""

    def __init__(self, size: float, library: bool) -> None:
        self.size, self.library = size, library
        self.metric = fasteners.metric(size)
        self.washer = self._part("washer")
        self.nut = self._part("nut")
        self.washer_height, self.nut_height = _height(self.washer), _height(self.nut)

    def _part(self, kind: str, length: float = 0.0) -> TopoDS_Shape:
        if self.library:
            return fasteners.from_library(kind, self.size, length)
        if kind == "bolt":
            return fasteners.bolt(self.size, length)
        return fasteners.nut(self.size) if kind == "nut" else fasteners.washer(self.size)

    def bolted(self, top: float, bottom: float, at: Array, nut: bool) -> list[_Made]:
        """Washer and bolt on `top`; at `bottom` washer and nut, or the bolt's end."""
        w, size = self.washer_height, f" M{self.size:g}"
        length = top + w - bottom
        out: list[_Made] = []
        if nut:
            length += w + self.nut_height + 2.0 * self.metric.pitch
            length = 5.0 * float(np.ceil(length / 5.0))
            over = np.diag([1.0, -1.0, -1.0, 1.0])  # upside down, growing downwards
            out.append((f"washer{size}", self.washer, _ZINC, at @ _at(z=bottom) @ over))
            out.append((f"nut{size}", self.nut, _ZINC, at @ _at(z=bottom - w) @ over))
        out.append((f"washer{size}", self.washer, _ZINC, at @ _at(z=top)))
        bolt = self._part("bolt", length)
        out.append((f"bolt{size} x {length:g}", bolt, _ZINC, at @ _at(z=top + w)))
        return out


def _in_line(hole: LocalHole, others: Sequence[LocalHole]) -> bool:
    return any(abs(hole.x - o.x) < 1e-6 and abs(hole.y - o.y) < 1e-6 for o in others)


def _base_plate(fixing: Fixing) -> TopoDS_Solid:
    """The base plate; its slots cross those of the flange."""
    length, width, thick = fixing.base_length, fixing.base_width, fixing.base_thickness
    z = np.array([0.0, 0.0, 1.0])
    tools: list[TopoDS_Shape] = []
    for hole in fixing.flange_holes:
        size = fixing.rod if _in_line(hole, fixing.panel_holes) else fixing.base_bolt
        clearance = fasteners.metric(size).clearance
        across = np.array([-np.sin(hole.angle), np.cos(hole.angle), 0.0])
        slot = min(hole.slot, min(length, width) - clearance - 8.0)
        if slot > 0.0:
            start = np.array([hole.x, hole.y, -1.0])
            tools.append(rounded_bar(start, z, across, clearance, slot, thick + 2.0))
        else:
            tools.append(cylinder(clearance, -1.0, thick + 1.0, hole.x, hole.y))
    for hole in fixing.panel_holes:
        if not _in_line(hole, fixing.flange_holes):  # the rod is screwed into the plate
            tools.append(cylinder(fixing.rod, -1.0, thick + 1.0, hole.x, hole.y))
    body = prism(rectangle(length, width), 0.0, thick)
    return cut(body, tools, f"base plate of {fixing.product}") if tools else body


def _height(shape: TopoDS_Shape) -> float:
    low, high = bounding_box(shape)
    return float(high[2] - low[2])


def _at(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Array:
    place = np.eye(4)
    place[:3, 3] = x, y, z
    return place


def _shared(made: Sequence[_Made]) -> tuple[Node, ...]:
    """Parts of one name as instances of one product; numbered from 2 on."""
    products: dict[str, Node] = {}
    out: list[Node] = []
    for name, shape, colour, place in made:
        product = products.setdefault(name, Node(name, shape=shape, colour=colour))
        count = sum(1 for other in out if other.instance_of is product)
        label = name if count == 0 else f"{name} {count + 1}"
        out.append(Node(label, instance_of=product, location=place))
    return tuple(out)
