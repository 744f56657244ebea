"""Length units of files: given, stated in the file, or guessed from the size, with the reason."""

from __future__ import annotations

from dataclasses import dataclass

from fabgeo.errors import InputError

MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "ft": 304.8}
STATED = "stated in the file"
SMALLEST, LARGEST = 200.0, 2e6  # diagonals in mm that a building's surface can have
# A diagonal in this range is taken for metres, for millimetres.
GUESSES = (("m", 0.5, 500.0), ("mm", 500.0, LARGEST))


@dataclass(frozen=True)
class Unit:
    """A file's length unit: its name, millimetres in one, and how it was found."""

    name: str
    scale: float
    reason: str


def unit_of(where: str, size: float, given: str | None) -> Unit:
    """The unit as given, or guessed from the diagonal `size` of what a file holds.

    Raises
    ------
    InputError
        If the given unit is unknown, or none is given and the size suits none.
    """
    if given is not None:
        if not isinstance(given, str) or given not in MILLIMETRES:
            raise InputError(where, f"unknown unit {given!r}", f"use {', '.join(MILLIMETRES)}")
        return Unit(given, MILLIMETRES[given], "given")
    for name, least, most in GUESSES:
        if least <= size < most:
            reason = f"guessed: a diagonal of {size:.4g} {name} suits a building"
            return Unit(name, MILLIMETRES[name], reason)
    raise InputError(
        where,
        f"says no unit, and its diagonal of {size:.4g} suits neither metres nor millimetres",
        f"give the unit: {', '.join(MILLIMETRES)}",
    )


def check_size(where: str, size: float, unit: Unit) -> None:
    """Refuse a given or guessed unit that makes the diagonal `size` (mm) absurd.

    Raises
    ------
    InputError
        Below 0.2 m or above 2 km, unless the file itself states its unit.
    """
    if unit.reason == STATED or SMALLEST <= size <= LARGEST:
        return
    raise InputError(
        where,
        f"read in {unit.name} ({unit.reason}) the surface's diagonal is {size / 1000.0:.4g} m; "
        f"expected {SMALLEST / 1000.0:g} m to {LARGEST / 1000.0:g} m",
        f"give another unit: {', '.join(u for u in MILLIMETRES if u != unit.name)}",
    )
