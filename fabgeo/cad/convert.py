"""Product trees as build123d and CadQuery objects: the same geometry, nothing is copied."""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from OCP.TopLoc import TopLoc_Location

from fabgeo.cad import kernel
from fabgeo.cad.assembly import Colour, Node
from fabgeo.errors import InputError, MissingExtraError

if TYPE_CHECKING:
    import build123d
    import cadquery
    from build123d.topology import Shape


def to_build123d(root: Node) -> build123d.Compound:
    """The tree as a build123d `Compound` with labels, colours and children.

    Parts are `Solid` objects around the very shapes of the tree; instances share theirs.
    """
    import build123d as b3d

    def convert(node: Node, inherited: Colour | None, above: TopLoc_Location) -> Any:
        product = node.instance_of or node
        colour = node.colour or product.colour or inherited
        place = above.Multiplied(_location(node))
        if product.shape is not None:
            shape = product.shape.Moved(place)
            solids = kernel.solids(shape)
            made = b3d.Solid(solids[0]) if len(solids) == 1 else b3d.Compound(shape)
            made.color = b3d.Color(*colour) if colour else None
        else:
            # Children stand in the model's own coordinates, as build123d's exporters expect.
            below = [convert(child, colour, place) for child in product.children]
            made = b3d.Compound(children=below)
        made.label = node.name
        return made

    made = convert(root, None, TopLoc_Location())
    return made if isinstance(made, b3d.Compound) else b3d.Compound(children=[made])


def to_cadquery(root: Node) -> cadquery.Assembly:
    """The tree as a CadQuery `Assembly` with names, colours and locations.

    Raises
    ------
    MissingExtraError
        Without the extra ``cadquery``.
    """
    try:
        import cadquery as cq
    except ImportError as error:
        raise MissingExtraError("to_cadquery", "cadquery") from error

    def convert(node: Node, inherited: Colour | None, name: str) -> cadquery.Assembly:
        product = node.instance_of or node
        colour = node.colour or product.colour or inherited
        made = cq.Assembly(
            cq.Shape.cast(product.shape) if product.shape is not None else None,
            loc=cq.Location(kernel.to_location(node.location))
            if node.location is not None
            else None,
            name=name,
            color=cq.Color(*colour, 1.0) if colour and product.shape is not None else None,
        )
        seen: dict[str, int] = {}
        for child in product.children:
            seen[child.name] = seen.get(child.name, 0) + 1
            unique = child.name if seen[child.name] == 1 else f"{child.name} {seen[child.name]}"
            made.add(convert(child, colour, unique), name=unique)
        return made

    return convert(root, None, root.name)


def of_build123d(part: Shape, name: str = "") -> Node:
    """A build123d object, with its labels, colours and children, as a product tree.

    This is how a user's own connector enters: a function that returns such an object.
    """
    label = part.label or name
    if not label:
        raise InputError("of_build123d", "expected an object with a label", "set `.label`")
    colour = None if part.color is None else _rgb(part.color)
    if part.children:
        children = tuple(
            of_build123d(child, f"{label}-{k}") for k, child in enumerate(part.children, 1)
        )
        return Node(label, children=children, colour=colour)
    if part.wrapped is None or not kernel.solids(part.wrapped):
        raise InputError(f"part {label!r}", "holds no solid")
    return Node(label, shape=part.wrapped, colour=colour)


def _location(node: Node) -> TopLoc_Location:
    return TopLoc_Location() if node.location is None else kernel.to_location(node.location)


def _rgb(colour: build123d.Color) -> Colour:
    red, green, blue, *_ = tuple(colour)
    return float(red), float(green), float(blue)
