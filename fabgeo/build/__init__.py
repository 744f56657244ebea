"""The whole way from a project to a hand-over package: the only place where rooms are wired.

The names below load their module on first use: a process that only unrolls or cuts parts loads
no more than that needs.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fabgeo.build.geometry import Design as Design
    from fabgeo.build.package import Package as Package
    from fabgeo.build.way import build_package as build_package
    from fabgeo.build.way import design as design

_WHERE = {"Design": "geometry", "Package": "package", "build_package": "way", "design": "way"}

__all__ = ["Design", "Package", "build_package", "design"]


def __getattr__(name: str) -> Any:
    if name not in _WHERE:
        raise AttributeError(f"module 'fabgeo.build' has no attribute {name!r}")
    return getattr(importlib.import_module(f"fabgeo.build.{_WHERE[name]}"), name)
