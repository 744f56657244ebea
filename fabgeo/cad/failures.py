"""What the kernel could not read of a file: it goes on without, and says so only when asked.

A coordinate that is no number becomes 0, a face whose surface is broken is left out, a trim whose
curve is broken is dropped. The kernel notes it all as failures, of entities while it loads the
file and of shapes while it makes them.
"""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from fabgeo.cad.isolated import CURE
from fabgeo.errors import InputError

GEOMETRY = ("StepGeom_", "StepShape_", "IGESGeom_", "IGESSolid_")
"""Types of entities that shapes are made of; of others, a failure changes no shape."""


def refuse_failures(name: str, kind: str, session: Any) -> None:
    """Refuse a file of whose geometry the kernel could not read all.

    Parameters
    ----------
    name, kind : str
        The file, and what it should be: STEP or IGES.
    session : XSControl_WorkSession
        After the transfer.

    Raises
    ------
    InputError
        Names the first entity that failed, and how many did.
    """
    lists = session.ModelCheckList(), session.TransferReader().TransientProcess().CheckList(False)
    found = [line for checks in lists for line in _failures(session.Model(), checks)]
    if found:
        more = f", and {len(found) - 1} more" if len(found) > 1 else ""
        raise InputError(name, f"holds damaged {kind} geometry: {found[0]}{more}", CURE)


def _failures(model: Any, checks: Any) -> Iterator[str]:
    """``Plane, entity 12: what failed`` of every geometrical entity in a list of checks."""
    checks.Start()
    while checks.More():
        check, number = checks.Value(), checks.Number()
        if check.NbFails() and number:
            type_name = model.Value(number).DynamicType().Name()
            if type_name.startswith(GEOMETRY):
                yield f"{type_name.partition('_')[2]}, entity {number}: {check.CFail(1)}"
        checks.Next()
