"""``strips.json``: a fitted model as plain data; a build reloads it, a fit resumes from it.

Glossary
--------
format
    ``fabgeo-strips``; `version` grows when a reader of the older form would misread the newer.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from fabgeo.arrays import checked
from fabgeo.errors import InputError
from fabgeo.strips.model import KINDS, StripModel

FORMAT, VERSION = "fabgeo-strips", 1
REQUIRED = {"format", "version", "unit", "kind", "closed_u", "closed_i", "control"}
OPTIONAL = {"info", "history"}


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
        If `info` or `history` hold something that JSON cannot.
    """
    path = Path(path)
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
    beside = path.with_name(path.name + ".part")
    beside.write_text(text + "\n", encoding="utf-8")
    os.replace(beside, path)


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
    data = _read(Path(path))
    where = str(path)
    if data.get("format") != FORMAT:
        raise InputError(where, f"expected format {FORMAT!r}, found {data.get('format')!r}")
    if data.get("version") != VERSION:
        raise InputError(
            where,
            f"expected version {VERSION}, found {data.get('version')!r}",
            "write it again with this version of fabgeo",
        )
    missing, unknown = REQUIRED - set(data), set(data) - REQUIRED - OPTIONAL
    if missing or unknown:
        words = [f"lacks {sorted(missing)}"] if missing else []
        words += [f"holds unknown entries {sorted(unknown)}"] if unknown else []
        raise InputError(where, " and ".join(words))
    if data["kind"] not in KINDS:
        raise InputError(f"{where}: kind", f"expected one of {KINDS}, found {data['kind']!r}")
    for name in ("closed_u", "closed_i"):
        if not isinstance(data[name], bool):
            raise InputError(f"{where}: {name}", f"expected true or false, found {data[name]!r}")
    for name, kind in (("unit", str), ("info", dict), ("history", list)):
        if name in data and not isinstance(data[name], kind):
            raise InputError(f"{where}: {name}", f"expected a {kind.__name__}")
    control = checked(f"{where}: control", data["control"], ("edges", "points", 3))
    info = {**data.get("info", {}), "unit": data["unit"], "history": data.get("history", [])}
    return StripModel(control, data["closed_u"], data["closed_i"], data["kind"], info)


def _read(path: Path) -> dict[str, Any]:
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(str(path), f"cannot be read: {error.strerror}") from error
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise InputError(str(path), f"is no JSON: {error}") from error
    if not isinstance(data, dict):
        raise InputError(str(path), "expected one JSON object with the model's entries")
    return data
