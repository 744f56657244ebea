"""What a script gives to the stages of a build, checked where it enters."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

from fabgeo.arrays import checked_count, shown
from fabgeo.errors import InputError
from fabgeo.panels.flat import FlatPart
from fabgeo.project import Project

MOST_JOBS = 10_000


def checked_jobs(jobs: Any) -> int | None:
    """Return `jobs` as a number of processes, None (what joblib is configured for) as it is.

    Raises
    ------
    InputError
        If it is neither.
    """
    return None if jobs is None else checked_count("jobs", jobs, 1, MOST_JOBS)


def checked_project(project: Any) -> Project:
    """Return `project` if it is one.

    Raises
    ------
    InputError
        If it is not.
    """
    if not isinstance(project, Project):
        problem = f"expected a Project, found {shown(project)}"
        raise InputError("project", problem, "take that of a design, or read_project's")
    return project


def checked_parts[P](name: str, parts: Any, kinds: type[P] | tuple[type[P], ...]) -> list[P]:
    """Return `parts` as a list of parts of these kinds, each mark there once.

    Raises
    ------
    InputError
        Naming what else is among them, or the mark.
    """
    if not isinstance(parts, Iterable) or isinstance(parts, str | bytes | Mapping):
        raise InputError(name, f"expected parts of a design, found {shown(parts)}")
    own = list(parts)
    for part in own:
        if not isinstance(part, kinds):
            raise InputError(name, f"expected parts of a design, found {shown(part)}")
    for mark, count in Counter(part.mark for part in own).items():
        if count > 1:
            raise InputError(f"{name}: {mark}", f"is there {count} times", "give each part once")
    return own


def checked_flats(flats: Any) -> dict[str, FlatPart]:
    """Return `flats` if they are flat parts by their marks.

    Raises
    ------
    InputError
        If they are not.
    """
    if not isinstance(flats, Mapping):
        raise InputError("flats", f"expected flat parts by marks, found {shown(flats)}")
    for mark, part in flats.items():
        if not isinstance(part, FlatPart):
            problem = f"expected a flat part, found {shown(part)}"
            raise InputError(f"flats: {shown(mark)}", problem, "make them by flats_of")
    return dict(flats)
