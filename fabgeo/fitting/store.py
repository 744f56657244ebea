"""``strips.json``: a fitted model as plain data; a build reloads it, a fit resumes from it.

Glossary
--------
format
    ``fabgeo-strips``; `version` grows when a reader of the older form would misread the newer.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from fabgeo.arrays import checked, checked_number, checked_path, read_text, shown
from fabgeo.errors import InputError
from fabgeo.strips.model import KINDS, StripModel, check_model
from fabgeo.surfaces.units import MILLIMETRES

FORMAT, VERSION = "fabgeo-strips", 1
REQUIRED = {"format", "version", "unit", "kind", "closed_u", "closed_i", "control"}
OPTIONAL = {"info", "history"}
LARGEST_FILE = 1 << 30


def save_model(
    path: str | Path,
    model: StripModel,
    *,
    unit: str = "mm",
    history: Iterable[Mapping[str, Any]] = (),
) -> None:
    """Write a model as ``strips.json``; beside first, then moved into place.

    Parameters
    ----------
    path : str or Path
    model : StripModel
        Written to the last digit.
    unit : str
        Unit of the control points.
    history : iterable of mappings
        The fit's history, plain data.

    Raises
    ------
    InputError
        If `info` or `history` hold something that JSON cannot, the unit is unknown, or nothing can
        be written there.
    """
    path = checked_path("save_model", path)
    check_model("save_model", model)
    history = list(history) if isinstance(history, Iterable) else history
    _check_unit("save_model: unit", unit)
    _check_history("save_model: history", history)
    data = {
        "format": FORMAT,
        "version": VERSION,
        "unit": unit,
        "kind": model.kind,
        "closed_u": model.closed_u,
        "closed_i": model.closed_i,
        "control": model.control.tolist(),
        "info": dict(model.info),
        "history": [dict(record) for record in history],
    }
    try:
        text = json.dumps(data, allow_nan=False, indent=None, separators=(",", ":"))
    except (TypeError, ValueError) as error:
        raise InputError(str(path), f"info and history must be plain data: {error}") from error
    if not path.name or os.path.isdir(path):  # False for what can be no path
        raise InputError(str(path), "is a folder", 'name a file in it, such as "strips.json"')
    beside = path.with_name(path.name + ".part")
    try:
        beside.write_text(text + "\n", encoding="utf-8")
        os.replace(beside, path)
    except (OSError, UnicodeEncodeError) as error:
        problem = error.strerror if isinstance(error, OSError) else error.reason
        raise InputError(
            ascii(str(path))[1:201], f"cannot be written: {problem}", "choose another path"
        ) from error


def load_model(path: str | Path) -> StripModel:
    """Read a model that `save_model` wrote.

    Returns
    -------
    StripModel
        Its `info` holds, besides what was saved, `unit` and `history`.

    Raises
    ------
    InputError
        If the file is missing, is no JSON or does not hold a strip model; names the entry.
    """
    path = checked_path("load_model", path)
    data, where = _read(path), str(path)
    if data.get("format") != FORMAT:
        raise InputError(where, f"expected format {FORMAT!r}, found {shown(data.get('format'))}")
    if type(data.get("version")) is not int or data["version"] != VERSION:
        raise InputError(
            where,
            f"expected version {VERSION}, found {shown(data.get('version'))}",
            "write it again with this version of fabgeo",
        )
    missing, unknown = REQUIRED - set(data), set(data) - REQUIRED - OPTIONAL
    if missing or unknown:
        words = [f"lacks {sorted(missing)}"] if missing else []
        words += [f"holds unknown entries {sorted(unknown)}"] if unknown else []
        raise InputError(where, " and ".join(words))
    if data["kind"] not in KINDS:
        raise InputError(f"{where}: kind", f"expected one of {KINDS}, found {shown(data['kind'])}")
    for name in ("closed_u", "closed_i"):
        if not isinstance(data[name], bool):
            raise InputError(
                f"{where}: {name}", f"expected true or false, found {shown(data[name])}"
            )
    _check_unit(f"{where}: unit", data["unit"])
    _check_history(f"{where}: history", data.get("history", []))
    info = data.get("info", {})
    if not isinstance(info, dict):
        raise InputError(f"{where}: info", f"expected an object, found {shown(info)}")
    check_info(f"{where}: info", info)
    control = checked(f"{where}: control", data["control"], ("edges", "points", 3))
    if any(isinstance(value, bool) for row in data["control"] for value in chain(*row)):
        raise InputError(f"{where}: control", "expected numbers, found truth values")
    info = {**info, "unit": data["unit"], "history": data.get("history", [])}
    return StripModel(control, data["closed_u"], data["closed_i"], data["kind"], info)


def check_info(where: str, info: Mapping[str, Any]) -> None:
    """Raise InputError where what a start or a fit left in a model's `info` is something else."""
    for name in ("start", "fit"):
        if not isinstance(info.get(name, {}), Mapping):
            problem = f"expected names and values, found {shown(info[name])}"
            raise InputError(f"{where}.{name}", problem, "remove it")
    left = info.get("fit", {})
    for name in ("cost", "developability", "anchor") if "cost" in left else ():
        checked_number(f"{where}.fit.{name}", left.get(name), least=0.0)


def _check_unit(where: str, unit: Any) -> None:
    if not isinstance(unit, str) or unit not in MILLIMETRES:
        raise InputError(where, f"expected one of {', '.join(MILLIMETRES)}, found {shown(unit)}")


def _check_history(where: str, history: Any) -> None:
    records = isinstance(history, Sequence) and all(isinstance(row, Mapping) for row in history)
    if not records:
        raise InputError(where, "expected a list of records", "leave it out")


def _read(path: Path) -> dict[str, Any]:
    text = read_text(path, "check the path to strips.json", LARGEST_FILE)
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(str(path), f"is no JSON: {error}") from error
    if not isinstance(data, dict):
        raise InputError(str(path), "expected one JSON object with the model's entries")
    return data
