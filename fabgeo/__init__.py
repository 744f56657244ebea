"""fabgeo: from a freeform architectural surface to the files a workshop cuts from.

The names below load their room on first use; `import fabgeo` itself loads no CAD kernel.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from fabgeo import spline as spline
    from fabgeo.build import Design as Design
    from fabgeo.build import Package as Package
    from fabgeo.build import build_package as build_package
    from fabgeo.build import design as design
    from fabgeo.cad.given import as_surface as as_surface
    from fabgeo.cad.read_surface import read_surface as read_surface
    from fabgeo.errors import FabgeoError as FabgeoError
    from fabgeo.errors import GeometryError as GeometryError
    from fabgeo.errors import InputError as InputError
    from fabgeo.fitting.fit import FitResult as FitResult
    from fabgeo.fitting.fit import fit as fit
    from fabgeo.fitting.options import FitOptions as FitOptions
    from fabgeo.fitting.starts import Start as Start
    from fabgeo.fitting.starts import start as start
    from fabgeo.fitting.stoppable import stoppable as stoppable
    from fabgeo.fitting.store import load_model as load_model
    from fabgeo.fitting.store import save_model as save_model
    from fabgeo.project import Project as Project
    from fabgeo.project import read_project as read_project
    from fabgeo.strips.draw import draw as draw
    from fabgeo.strips.measures import Measures as Measures
    from fabgeo.strips.measures import measure as measure
    from fabgeo.strips.model import Patch as Patch
    from fabgeo.strips.model import StripModel as StripModel
    from fabgeo.strips.offset import offset as offset
    from fabgeo.strips.ruled import RuledPatch as RuledPatch
    from fabgeo.surfaces.formula import FormulaSurface as FormulaSurface

_WHERE = {
    "Design": "build",
    "Package": "build",
    "build_package": "build",
    "design": "build",
    "FabgeoError": "errors",
    "GeometryError": "errors",
    "InputError": "errors",
    "FitResult": "fitting.fit",
    "fit": "fitting.fit",
    "FitOptions": "fitting.options",
    "Start": "fitting.starts",
    "start": "fitting.starts",
    "load_model": "fitting.store",
    "save_model": "fitting.store",
    "stoppable": "fitting.stoppable",
    "Project": "project",
    "read_project": "project",
    "draw": "strips.draw",
    "Measures": "strips.measures",
    "measure": "strips.measures",
    "Patch": "strips.model",
    "StripModel": "strips.model",
    "offset": "strips.offset",
    "RuledPatch": "strips.ruled",
    "FormulaSurface": "surfaces.formula",
    "read_surface": "cad.read_surface",
    "as_surface": "cad.given",
    "spline": "",
}


if not TYPE_CHECKING:  # checkers read the names above: one that is none is an error to them, too
    __all__ = sorted([*_WHERE, "__version__"])

    def __dir__() -> list[str]:
        return list(__all__)

    def __getattr__(name: str) -> Any:
        if name not in _WHERE:
            raise AttributeError(f"module 'fabgeo' has no attribute {name!r}")
        room = _WHERE[name]
        if not room:
            return importlib.import_module(f"fabgeo.{name}")
        value = getattr(importlib.import_module(f"fabgeo.{room}"), name)
        globals()[name] = value
        return value
