"""What an output folder may hold where a build reads, writes or removes: files and folders alone.

A folder is data, too, perhaps somebody else's: a link in it would lead writing and removing
outside, a pipe would hold a build up for ever.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path, PurePosixPath

from fabgeo.errors import InputError

CURE = "move it away: a package holds ordinary files and folders only"


def refuse_strange(folder: Path, names: Iterable[str]) -> None:
    """Refuse anything but a file where a name (relative, with /) leads, and but folders above it.

    Raises
    ------
    InputError
        That names what stands there. What is not there yet is no hindrance.
    """
    for name in names:
        path = folder
        parts = PurePosixPath(name).parts
        for k, part in enumerate(parts, 1):
            path = path / part
            last = k == len(parts)
            if path.is_symlink():
                raise InputError(str(path), "is a link", CURE)
            if path.exists() and not (path.is_file() if last else path.is_dir()):
                raise InputError(str(path), f"is no {'file' if last else 'folder'}", CURE)


def refuse_strange_below(folder: Path) -> None:
    """Refuse anything but folders of files in a folder, if it is there.

    Raises
    ------
    InputError
        That names what stands there.
    """
    if not folder.is_dir():
        return
    for inner in _listed(folder):
        if not inner.is_dir(follow_symlinks=False):
            raise InputError(inner.path, "is no folder", CURE)
        for entry in _listed(inner.path):
            if not entry.is_file(follow_symlinks=False):
                raise InputError(entry.path, "is no file", CURE)


def _listed(folder: Path | str) -> list[os.DirEntry[str]]:
    """Entries that know their kind: a cache holds tens of thousands."""
    with os.scandir(folder) as entries:
        return list(entries)


def remove(folder: Path, name: str) -> None:
    """Remove a file and the folders that this leaves empty; nothing else, and nothing outside."""
    pure = PurePosixPath(name)
    if pure.is_absolute() or not pure.parts or ".." in pure.parts:
        return
    try:
        refuse_strange(folder, [name])
        path = folder / name
        path.unlink(missing_ok=True)
        for parent in pure.parents:
            if parent.parts and (folder / parent).is_dir() and not any((folder / parent).iterdir()):
                (folder / parent).rmdir()
    except (OSError, ValueError, InputError):  # a name that no build gave: what it means stays
        return
