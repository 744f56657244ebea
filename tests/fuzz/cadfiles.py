"""Small STEP, IGES and 3dm files to damage, as the kernel and rhino3dm write them.

Their readers work in a process of their own; here that process is forked, ready at once.
"""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import multiprocessing
import tempfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any


class Forked(ProcessPoolExecutor):
    """One process that has loaded what this one has."""

    def __init__(self) -> None:
        import OCP.IGESCAFControl
        import OCP.STEPCAFControl  # noqa: F401

        super().__init__(1, mp_context=multiprocessing.get_context("fork"))

    def shutdown(self, *_: Any, kill_workers: bool = False, **__: Any) -> None:
        """As joblib's executor does it."""
        for process in list(self._processes.values()) if kill_workers else ():
            process.kill()
        super().shutdown()


def step_files() -> list[bytes]:
    """A B-spline face with a hole, and a cylinder in feet."""
    from OCP.Interface import Interface_Static
    from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer

    out = []
    for shape, unit in zip(_shapes(), ("MM", "FT"), strict=True):
        writer = STEPControl_Writer()
        Interface_Static.SetCVal_s("write.step.unit", unit)
        writer.Transfer(shape, STEPControl_AsIs)
        out.append(_written(lambda path, w=writer: w.Write(path)))
    Interface_Static.SetCVal_s("write.step.unit", "MM")
    return out


def iges_files() -> list[bytes]:
    """The same as trimmed surfaces, then as boundary representations."""
    from OCP.IGESControl import IGESControl_Writer

    out = []
    for brep in (0, 1):
        for shape in _shapes():
            writer = IGESControl_Writer("MM", brep)
            writer.AddShape(shape)
            out.append(_written(lambda path, w=writer: w.Write(path)))
    return out


def rhino_files() -> list[bytes]:
    """A ball, a trimmed disc, a B-spline surface, a mesh."""
    import rhino3dm as r

    circle = r.Circle(r.Point3d(0, 0, 0), 3.0).ToNurbsCurve()
    surface = r.NurbsSurface.Create(3, False, 4, 4, 5, 5)
    for k, knot in enumerate((0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0)):
        surface.KnotsU[k] = surface.KnotsV[k] = knot
    mesh = r.Mesh()
    for i in range(5):
        for j in range(5):
            surface.Points[i, j] = r.Point4d(i, j, 0.1 * i * j, 1)
            mesh.Vertices.Add(i, j, 0.1 * i * j)
    for k in (5 * i + j for i in range(4) for j in range(4)):
        mesh.Faces.AddFace(k, k + 1, k + 6, k + 5)
    ball = r.Brep.CreateFromSphere(r.Sphere(r.Point3d(0, 0, 0), 3.0))
    disc = r.Brep.CreateTrimmedPlane(r.Plane.WorldXY(), circle)
    out = []
    for add, item in (("Brep", ball), ("Brep", disc), ("Surface", surface), ("Mesh", mesh)):
        model: Any = r.File3dm()
        model.Settings.ModelUnitSystem = r.UnitSystem.Meters
        getattr(model.Objects, f"Add{add}")(item)
        out.append(_written(lambda path, m=model: m.Write(path, 7)))
    return out


def _shapes() -> list[Any]:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
    from OCP.GeomAPI import GeomAPI_PointsToBSplineSurface
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    from fabgeo.cad import kernel

    kernel.be_quiet()
    rows = [[[1e3 * i, 1e3 * j, 30.0 * (i - 2) ** 2 * j] for i in range(5)] for j in range(5)]
    surface = GeomAPI_PointsToBSplineSurface(kernel.point_grid(rows)).Surface()
    face = BRepBuilderAPI_MakeFace(surface, 1e-6).Face()
    axis = gp_Ax2(gp_Pnt(2000, 2000, -1000), gp_Dir(0, 0, 1))
    drill = BRepPrimAPI_MakeCylinder(axis, 700.0, 4000.0).Shape()
    return [BRepAlgoAPI_Cut(face, drill).Shape(), drill]


def _written(write: Callable[[str], object]) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "x"
        write(str(path))
        return path.read_bytes()
