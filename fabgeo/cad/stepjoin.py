"""STEP files joined to one assembly, as text: memory does not grow with the number of parts.

The kernel translates a few parts at a time (`fabgeo.cad.step.step_bytes`), here or in other
processes, and every piece serves the file of its family and that of the whole. Source:
ISO 10303-21 (the text), ISO 10303-44 and -242 (assemblies).

Glossary
--------
piece
    The bytes of a STEP file whose root is an assembly.
occurrence
    The place of a product in an assembly, with a name of its own (its mark).
"""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Self

from fabgeo.cad.step import step_text, time_stamp
from fabgeo.cad.stepnumbers import renumbered
from fabgeo.cad.steporder import END
from fabgeo.errors import InputError

_REFERENCE = re.compile(rb"#(\d+)")
_ROOT = re.compile(
    rb"#\d+ = SHAPE_DEFINITION_REPRESENTATION\(#\d+,#(?P<shape>\d+)\);\n"
    rb"#\d+ = PRODUCT_DEFINITION_SHAPE\([^;]*\);\n"
    rb"#(?P<definition>\d+) = PRODUCT_DEFINITION\([^;]*\);\n"
    rb"#\d+ = PRODUCT_DEFINITION_FORMATION\([^;]*\);\n"
    rb"#(?P<product>\d+) = PRODUCT\("
)
_APPLICATION = re.compile(rb"#(\d+) = APPLICATION_CONTEXT\(")
_OCCURRENCE = re.compile(rb"NEXT_ASSEMBLY_USAGE_OCCURRENCE\('\d+'")
_FILE_NAME = re.compile(rb"FILE_NAME\('(?:[^']|'')*','[^']*'")

# The numbers of what the file holds once.
_APPLICATION_CONTEXT, _PRODUCT_CONTEXT, _DEFINITION_CONTEXT, _SPACE = 2, 3, 4, 5
_ORIGIN, _FIRST_FREE = 10, 14

_ONCE = b"""#1 = APPLICATION_PROTOCOL_DEFINITION('international standard',
  'ap242_managed_model_based_3d_engineering',2013,#2);
#2 = APPLICATION_CONTEXT('Managed model based 3d engineering');
#3 = PRODUCT_CONTEXT('',#2,'mechanical');
#4 = PRODUCT_DEFINITION_CONTEXT('part definition',#2,'design');
#5 = ( GEOMETRIC_REPRESENTATION_CONTEXT(3)
GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#9)) GLOBAL_UNIT_ASSIGNED_CONTEXT((#6,#7,#8))
REPRESENTATION_CONTEXT('Context #1','3D Context with UNIT and UNCERTAINTY') );
#6 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) );
#7 = ( NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.) );
#8 = ( NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT() );
#9 = UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-06),#6,
  'distance_accuracy_value','confusion accuracy');
#10 = AXIS2_PLACEMENT_3D('',#11,#12,#13);
#11 = CARTESIAN_POINT('',(0.,0.,0.));
#12 = DIRECTION('',(0.,0.,1.));
#13 = DIRECTION('',(1.,0.,0.));
"""


@dataclass
class _Assembly:
    """A product of products while it is filled: its definition, its shape, the places in it."""

    name: bytes
    definition: int
    shape: int
    items: list[int] = field(default_factory=list)


class StepJoin:
    """STEP files written piece by piece: one of all assemblies, and one of each where asked.

    An entity has the same number in the file of its assembly as in that of all. The files appear
    whole at the end of the context, or not at all.

    Parameters
    ----------
    path : Path
        The file of all.
    name : str
        Of its root.
    single : mapping, optional
        From names of assemblies to files of their own, with the assembly as root.
    """

    def __init__(self, path: Path, name: str, single: Mapping[str, Path] | None = None) -> None:
        self._path, self._single = path, dict(single or {})
        self._next, self._occurrences = _FIRST_FREE, 0
        self._root = self._assembly(name)
        self._assemblies: dict[str, _Assembly] = {}
        self._files: dict[Path, BinaryIO] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            if kind is None:
                self._close()
                for path, file in self._files.items():
                    file.close()
                    os.replace(_beside(path), path)
        finally:
            for path, file in self._files.items():
                file.close()
                _beside(path).unlink(missing_ok=True)

    def add(self, assembly: str, piece: bytes) -> None:
        """Add what the root of a piece holds to an assembly of that name.

        Raises
        ------
        InputError
            If the piece is not a STEP file of an assembly as the kernel writes it.
        """
        root, application = _ROOT.search(piece), _APPLICATION.search(piece)
        if root is None or application is None:
            raise InputError(assembly, "expected a STEP file with an assembly as its root")
        items, places, parts = _opened(piece, root)
        if assembly not in self._assemblies:
            self._assemblies[assembly] = self._assembly(assembly)
        into = self._assemblies[assembly]
        for path in self._paths(assembly):
            if path not in self._files:
                self._begin(path, piece)
        offset = self._next - 1
        known = {
            int(application[1]): _APPLICATION_CONTEXT,
            int(root["definition"]): into.definition,
            int(root["shape"]): into.shape,
        }
        into.items += [item + offset for item in items]
        self._write(renumbered(places + self._counted(parts), offset, known), assembly)
        last = parts.rfind(b"\n#", 0, -1) + 2
        self._next = int(parts[last : parts.index(b" ", last)]) + offset + 1

    def _assembly(self, name: str) -> _Assembly:
        self._next += 2
        return _Assembly(step_text(name), self._next - 2, self._next - 1)

    def _paths(self, assembly: str) -> list[Path]:
        """The files that an assembly is in."""
        single = self._single.get(assembly)
        return [self._path] if single is None else [self._path, single]

    def _begin(self, path: Path, piece: bytes) -> None:
        """Open a file with the header of its first piece, under its own name and moment."""
        names = b"FILE_NAME('%s','%s'" % (step_text(path.name), time_stamp().encode())
        header = piece[: piece.index(b"DATA;\n") + len(b"DATA;\n")]
        self._files[path] = _beside(path).open("wb")
        self._files[path].write(_FILE_NAME.sub(lambda _: names, header, count=1) + _ONCE)

    def _write(self, data: bytes, assembly: str) -> None:
        for path in self._paths(assembly):
            self._files[path].write(data)

    def _counted(self, data: bytes) -> bytes:
        """Occurrences numbered on from those of the pieces before."""

        def count(_: re.Match[bytes]) -> bytes:
            self._occurrences += 1
            return b"NEXT_ASSEMBLY_USAGE_OCCURRENCE('%d'" % self._occurrences

        return _OCCURRENCE.sub(count, data)

    def _close(self) -> None:
        """The assemblies themselves, now that all their places are known."""
        if not self._assemblies:
            raise InputError(self._path.name, "holds no part", "leave the file out")
        for name, assembly in self._assemblies.items():
            self._write(self._product(assembly), name)
        whole = self._files[self._path]
        self._root.items.append(_ORIGIN)
        for assembly in self._assemblies.values():
            whole.write(self._place(self._root, assembly))
        whole.write(self._product(self._root))
        for file in self._files.values():
            file.write(END)

    def _place(self, parent: _Assembly, child: _Assembly) -> bytes:
        """The occurrence of a child at its parent's origin."""
        shape, relation, turn, place, occurrence, own = range(self._next, self._next + 6)
        self._next += 6
        self._occurrences += 1
        name = child.name.decode()
        parent.items.append(own)
        return _joined(
            f"#{shape} = CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#{relation},#{place});",
            f"#{relation} = ( REPRESENTATION_RELATIONSHIP('','',#{child.shape},#{parent.shape})",
            f"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#{turn})",
            "SHAPE_REPRESENTATION_RELATIONSHIP() );",
            f"#{turn} = ITEM_DEFINED_TRANSFORMATION('','',#{_ORIGIN},#{own});",
            f"#{place} = PRODUCT_DEFINITION_SHAPE('Placement','Placement of an item',"
            f"#{occurrence});",
            f"#{occurrence} = NEXT_ASSEMBLY_USAGE_OCCURRENCE('{self._occurrences}','{name}','',"
            f"#{parent.definition},#{child.definition},$);",
            f"#{own} = AXIS2_PLACEMENT_3D('',#{_ORIGIN + 1},#{_ORIGIN + 2},#{_ORIGIN + 3});",
        )

    def _product(self, assembly: _Assembly) -> bytes:
        """The assembly as a product, its shape all the places in it."""
        shape, place, version, product, category = range(self._next, self._next + 5)
        self._next += 5
        name = assembly.name.decode()
        items = ",\n  ".join(_lines(assembly.items))
        return _joined(
            f"#{shape} = SHAPE_DEFINITION_REPRESENTATION(#{place},#{assembly.shape});",
            f"#{place} = PRODUCT_DEFINITION_SHAPE('','',#{assembly.definition});",
            f"#{assembly.definition} = PRODUCT_DEFINITION('design','',#{version},"
            f"#{_DEFINITION_CONTEXT});",
            f"#{version} = PRODUCT_DEFINITION_FORMATION('','',#{product});",
            f"#{product} = PRODUCT('{name}','{name}','',(#{_PRODUCT_CONTEXT}));",
            f"#{category} = PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#{product}));",
            f"#{assembly.shape} = SHAPE_REPRESENTATION('',({items}),#{_SPACE});",
        )


def _joined(*lines: str) -> bytes:
    return ("\n".join(lines) + "\n").encode()


def _beside(path: Path) -> Path:
    return path.with_name(f".{path.name}.part")


def _opened(piece: bytes, root: re.Match[bytes]) -> tuple[list[int], bytes, bytes]:
    """Places in a piece's root: their numbers and their text; and the text of all its parts.

    The kernel writes the root, its places, its space with units and its category before parts.
    """
    shape = re.compile(
        rb"^#%s = SHAPE_REPRESENTATION\('',\(([^)]*)\),\s*#(\d+)\s*\);\n" % root["shape"], re.M
    )
    body = shape.search(piece, root.end())
    category = b"PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#%s));\n" % root["product"]
    at = piece.find(category)
    if body is None or at < 0:
        raise InputError("STEP", "expected the root's places and category before its parts")
    space = piece.index(b"\n#%s = " % body[2], body.end() - 1) + 1
    items = [int(n) for n in _REFERENCE.findall(body[1])]
    return items, piece[body.end() : space], piece[at + len(category) : piece.rindex(END)]


def _lines(numbers: Sequence[int], width: int = 8) -> list[str]:
    """References, a few to a line."""
    texts = [f"#{n}" for n in numbers]
    return [",".join(texts[k : k + width]) for k in range(0, len(texts), width)]
