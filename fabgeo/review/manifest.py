"""manifest.json: what was built from what, and the sha256 of every file of the package."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

NAME = "manifest.json"


def sha256_of(path: Path) -> str:
    """Hexadecimal sha256 of a file's bytes."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def package_files(folder: Path) -> dict[str, Path]:
    """Every file of a package but the manifest itself, by its name relative to the folder.

    Folders and files whose name begins with a dot (a build's lock) are no part of a package.
    """
    found = (p for p in folder.rglob("*") if p.is_file())
    named = {p.relative_to(folder).as_posix(): p for p in found}
    named = {n: p for n, p in named.items() if not any(w.startswith(".") for w in n.split("/"))}
    named.pop(NAME, None)
    return dict(sorted(named.items()))


def write_manifest(
    folder: Path,
    *,
    name: str,
    project: Mapping[str, Any],
    versions: Mapping[str, str],
    seconds: Mapping[str, float],
    not_asked: Sequence[str] = (),
    units: str = "mm",
    settings: Mapping[str, Any] | None = None,
    known: Mapping[str, str] | None = None,
) -> dict[str, Any]:
    """Write manifest.json over all files now in the folder; the last thing a build does.

    Parameters
    ----------
    project : mapping
        The project file as read: plain data.
    settings : mapping, optional
        What a reader of the files needs to measure them: see `fabgeo.review.check`.
    known : mapping, optional
        sha256 of files that was just taken.
    """
    sums, files = known or {}, package_files(folder)
    manifest = {
        "name": name,
        "units": units,
        "versions": dict(versions),
        "project": dict(project),
        "settings": dict(settings or {}),
        "seconds": {stage: round(float(value), 3) for stage, value in seconds.items()},
        "not_asked": list(not_asked),
        "files": {key: sums.get(key) or sha256_of(path) for key, path in files.items()},
    }
    text = json.dumps(manifest, indent=1, ensure_ascii=False, default=str)
    (folder / NAME).write_text(text + "\n", encoding="utf-8")
    return manifest
