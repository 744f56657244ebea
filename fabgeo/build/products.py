"""Products of point fixings: made when a file needs their shapes, else known by figures."""

from __future__ import annotations

import importlib.util
import math
import os
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import fields
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

from fabgeo.build.cache import Cache
from fabgeo.build.geometry import Design
from fabgeo.cad.assembly import Node
from fabgeo.structures.fixing import Fixing

if TYPE_CHECKING:
    from fabgeo.cad.kernel import Shape

STEEL = 7.85e-6  # kg/mm3


class ProductFacts(NamedTuple):
    """What the review tells of one product: mass in kg, its solids, how many are not sound."""

    mass: float
    solids: int
    unsound: int


def nodes_of(design: Design) -> list[Node]:
    """Every connector as a placed instance of its product."""
    from fabgeo.cad.connectors import place_connectors

    return place_connectors(design.connectors, products_of(design)) if design.connectors else []


def products_of(design: Design) -> dict[str, Node]:
    """The products by key; equal stand-offs are one product."""
    project = design.project
    if not design.connectors or project.panels is None or project.beams is None:
        return {}
    return products((design.products, project.panels.thickness, project.beams.flange))


type Wanted = tuple[Mapping[str, Fixing], float, float]
"""Fixings by key, and the thicknesses of panel and flange that they clamp."""


def products(wanted: Wanted) -> dict[str, Node]:
    """The products by key."""
    fixings, panel, flange = wanted
    return _products(tuple(fixings.items()), panel, flange)


@lru_cache(maxsize=4)
def _products(
    wanted: tuple[tuple[str, Fixing], ...], panel: float, flange: float
) -> dict[str, Node]:
    """Made once a process: the library of fasteners takes seconds to load."""
    from fabgeo.cad.connectors import fixing_products

    library = importlib.util.find_spec("bd_warehouse") is not None
    return fixing_products(dict(wanted), panel=panel, flange=flange, library=library)


def made_of(design: Design) -> Any:
    """Plain data that the products depend on; those of a user's function are like no others."""
    project = design.project
    if project.panels is None or project.beams is None:
        return None
    sizes = [
        os.urandom(16)
        if product.maker
        else repr([getattr(product, f.name) for f in fields(product)])
        for product in design.products.values()
    ]
    return list(design.products), sizes, project.panels.thickness, project.beams.flange


def product_facts(design: Design, cache: Cache) -> dict[str, ProductFacts]:
    """Figures of every product by key, all of steel."""
    if not design.connectors:
        return {}

    def measured() -> dict[str, ProductFacts]:
        return {key: _facts(list(_shapes(node))) for key, node in products_of(design).items()}

    known = cache.once("products", (made_of(design),), measured)
    return {key: ProductFacts(*facts) for key, facts in known.items()}


def _facts(shapes: list[Shape]) -> ProductFacts:
    from fabgeo.cad.measure import is_closed, is_valid, volume

    count = Counter(hash(shape) for shape in shapes)
    distinct = {hash(shape): shape for shape in shapes}  # most are placed more than once
    unsound = sum(not (is_valid(shape) and is_closed(shape)) for shape in distinct.values())
    whole = math.fsum(count[key] * volume(shape)[0] for key, shape in distinct.items())
    return ProductFacts(STEEL * whole, len(shapes), unsound)


def _shapes(node: Node) -> Iterator[Shape]:
    """The solids of one product, each as often as it is placed in it."""
    product = node.instance_of or node
    if product.shape is not None:
        yield product.shape
    for child in product.children:
        yield from _shapes(child)
