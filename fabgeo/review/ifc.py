"""The building as IFC4x3: what an architect's or a contractor's model takes in.

Panels are `IfcPlate` CURTAIN_PANEL; webs and flanges are `IfcPlate` WEB_PLATE and FLANGE_PLATE,
gathered in one `IfcElementAssembly` a beam segment; fixings are `IfcMember` at their places. Shapes
are the triangulated rails of the review; the schedules' figures stand in property sets.

Glossary
--------
rails
    See `fabgeo.review.record`: the edge curves that a part is drawn by.
"""

from __future__ import annotations

import importlib.util
import uuid
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from fabgeo.arrays import Array, IntArray, cross
from fabgeo.errors import MissingExtraError
from fabgeo.review.record import ReviewRecord, Row
from fabgeo.review.verdicts import judged

ROLES = {"web": "WEB_PLATE", "flange_inner": "FLANGE_PLATE", "flange_outer": "FLANGE_PLATE"}
MEASURES = {"mm": "IfcLengthMeasure", "kg": "IfcMassMeasure", "m2": "IfcAreaMeasure"}
SKIPPED = ("mark", "reason", "sheet_rotation_deg")


def need_ifc() -> None:
    """Refuse at once what `write_ifc` could not do after all other work."""
    if importlib.util.find_spec("ifcopenshell") is None:
        raise MissingExtraError("ifc", "ifc")


def write_ifc(path: Path, record: ReviewRecord) -> Path:
    """Write panels, beams and fixings as IFC4x3 (extra ``ifc``).

    Parameters
    ----------
    path : Path
        Usually ``DIR/model/facade.ifc``.

    Raises
    ------
    MissingExtraError
        Without the extra ``ifc``.
    """
    need_ifc()
    path.parent.mkdir(parents=True, exist_ok=True)
    _Model(judged(record)).file.write(str(path))
    return path


def triangles(rails: Array) -> tuple[Array, IntArray]:
    """Points (N k, 3) and outward triangles (t, 3) of a solid given by N closed-up rails."""
    n, k = rails.shape[:2]
    corner = np.arange(n * k).reshape(n, k)
    across = np.roll(corner, -1, axis=0)
    a, b = corner[:, :-1].ravel(), corner[:, 1:].ravel()
    c, d = across[:, 1:].ravel(), across[:, :-1].ravel()
    sides = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    fan = np.arange(1, n - 1)
    start = np.stack([np.zeros_like(fan), fan, fan + 1], axis=1) * k
    faces = np.concatenate([sides, start, start[:, ::-1] + k - 1])
    points = rails.reshape(-1, 3)
    p, q, r = (points[faces[:, m]] - points.mean(axis=0) for m in range(3))
    inward = np.einsum("ij,ij->", p, cross(q, r)) < 0.0
    return points, faces[:, ::-1] if inward else faces


class _Model:
    """One IFC file in the making."""

    def __init__(self, record: ReviewRecord) -> None:
        import ifcopenshell

        self.file: Any = ifcopenshell.file(schema="IFC4X3")
        self.record = record
        self.origin = self._placement(np.zeros(3))
        self.context: Any = None
        self.shapes = {part.mark: part.rails for part in record.shown}
        building = self._frame()
        elements = [*self._panels(), *self._beams(), *self._fixings()]
        if elements:
            self._root(
                "IfcRelContainedInSpatialStructure",
                "contents",
                RelatedElements=elements,
                RelatingStructure=building,
            )

    def _root(self, kind: str, key: str, **given: Any) -> Any:
        """An entity with a GUID that depends on the project and its key alone."""
        import ifcopenshell.guid

        name = uuid.uuid5(uuid.NAMESPACE_URL, f"fabgeo/{self.record.name}/{kind}/{key}")
        return self.file.create_entity(kind, ifcopenshell.guid.compress(name.hex), **given)

    def _placement(self, point: Array, axis: Array | None = None) -> Any:
        make = self.file.create_entity
        place = make("IfcCartesianPoint", [float(v) for v in point])
        ways: dict[str, Any] = {}
        if axis is not None:
            side = cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
            side /= np.linalg.norm(side)
            for key, way in (("Axis", axis), ("RefDirection", side)):
                ways[key] = make("IfcDirection", [float(v) for v in way])
        frame = make("IfcAxis2Placement3D", Location=place, **ways)
        return make("IfcLocalPlacement", RelativePlacement=frame)

    def _frame(self) -> Any:
        """Project, site and building, in millimetres; returns the building."""
        make, name = self.file.create_entity, self.record.name
        units = [
            make("IfcSIUnit", UnitType="LENGTHUNIT", Prefix="MILLI", Name="METRE"),
            make("IfcSIUnit", UnitType="AREAUNIT", Name="SQUARE_METRE"),
            make("IfcSIUnit", UnitType="VOLUMEUNIT", Name="CUBIC_METRE"),
            make("IfcSIUnit", UnitType="MASSUNIT", Prefix="KILO", Name="GRAM"),
            make("IfcSIUnit", UnitType="PLANEANGLEUNIT", Name="RADIAN"),
        ]
        world = self.origin.RelativePlacement
        whole = make("IfcGeometricRepresentationContext", None, "Model", 3, 1e-5, world)
        self.context = make(
            "IfcGeometricRepresentationSubContext",
            ContextIdentifier="Body",
            ContextType="Model",
            ParentContext=whole,
            TargetView="MODEL_VIEW",
        )
        project = self._root(
            "IfcProject",
            "project",
            Name=name,
            RepresentationContexts=[whole],
            UnitsInContext=make("IfcUnitAssignment", units),
        )
        site = self._root("IfcSite", "site", Name="Site", ObjectPlacement=self.origin)
        building = self._root("IfcBuilding", "building", Name=name, ObjectPlacement=self.origin)
        for above, below in ((project, site), (site, building)):
            self._gather(above, [below])
        return building

    def _gather(self, above: Any, below: list[Any]) -> None:
        key = f"{above.is_a()}/{above.Name}"
        self._root("IfcRelAggregates", key, RelatingObject=above, RelatedObjects=below)

    def _panels(self) -> Iterable[Any]:
        for row in self.record.panels:
            yield self._plate(row, "CURTAIN_PANEL", "Fabgeo_Panel")

    def _beams(self) -> Iterable[Any]:
        """One assembly a beam segment; plates that belong to none stand for themselves."""
        children: dict[str, list[Any]] = defaultdict(list)
        beams = {str(row["mark"]) for row in self.record.beams}
        for row in self.record.plates:
            plate = self._plate(row, ROLES.get(str(row.get("role")), "SHEET"), "Fabgeo_Plate")
            if str(row.get("parent")) in beams:
                children[str(row["parent"])].append(plate)
            else:
                yield plate
        for row in self.record.beams:
            mark = str(row["mark"])
            beam = self._element("IfcElementAssembly", row, "GIRDER", "Fabgeo_Beam")
            if children[mark]:
                self._gather(beam, children[mark])
            yield beam

    def _fixings(self) -> Iterable[Any]:
        rows = {str(row["mark"]): row for row in self.record.connectors}
        for shown in self.record.shown_connectors:
            row = rows.get(shown.mark, {"mark": shown.mark})
            fixing = self._element("IfcMember", row, "STUD", "Fabgeo_Fixing")
            fixing.ObjectPlacement = self._placement(shown.origin, shown.axis)
            yield fixing

    def _plate(self, row: Row, kind: str, title: str) -> Any:
        plate = self._element("IfcPlate", row, kind, title)
        rails = self.shapes.get(str(row["mark"]))
        if rails is not None and len(rails) > 2:
            plate.Representation = self._shape(rails)
        return plate

    def _element(self, kind: str, row: Row, predefined: str, title: str) -> Any:
        mark = str(row["mark"])
        element = self._root(
            kind,
            mark,
            Name=mark,
            Tag=mark,
            ObjectPlacement=self.origin,
            PredefinedType=predefined,
        )
        self._figures(element, row, title)
        return element

    def _shape(self, rails: Array) -> Any:
        make = self.file.create_entity
        points, faces = triangles(rails)
        mesh = make(
            "IfcTriangulatedFaceSet",
            Coordinates=make("IfcCartesianPointList3D", np.round(points, 4).tolist()),
            Closed=True,
            CoordIndex=(faces + 1).tolist(),
        )
        body = make("IfcShapeRepresentation", self.context, "Body", "Tessellation", [mesh])
        return make("IfcProductDefinitionShape", Representations=[body])

    def _figures(self, element: Any, row: Row, title: str) -> None:
        """The row's figures as one property set; angles in degrees are plain numbers."""
        make, known = self.file.create_entity, []
        for key, value in row.items():
            if key in SKIPPED or value is None or value == "":
                continue
            if isinstance(value, str):
                nominal = make("IfcLabel", value[:255])
            elif isinstance(value, int):
                nominal = make("IfcInteger", value)
            elif np.isfinite(value):
                nominal = make(MEASURES.get(key.rsplit("_", 1)[-1], "IfcReal"), float(value))
            else:
                continue
            known.append(make("IfcPropertySingleValue", Name=key, NominalValue=nominal))
        if known:
            key = element.Name
            own = self._root("IfcPropertySet", key, Name=title, HasProperties=known)
            self._root(
                "IfcRelDefinesByProperties",
                key,
                RelatedObjects=[element],
                RelatingPropertyDefinition=own,
            )
