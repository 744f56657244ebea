"""The output folder: one build at a time, files written beside and moved into place, a manifest.

Glossary
--------
manifest
    manifest.json, written last: a folder without it holds no finished package.
ledger
    What each file was made from: a file that would be made again alike, and that nobody changed
    since, is taken over from the package that is there.
"""

from __future__ import annotations

import errno
import fcntl
import json
import os
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import Any

from fabgeo.build.plainfiles import refuse_strange, refuse_strange_below, remove
from fabgeo.errors import FabgeoError, GeometryError, InputError
from fabgeo.review.manifest import sha256_of

MANIFEST = "manifest.json"
LEDGER = "files.json"
WORK = ".fabgeo"  # the lock and what a later build can use again
OWN = ("lock", LEDGER, f".{LEDGER}.part")
LATEST = 253_402_300_799
LONG = 60.0  # seconds of this process from which a failed build's work is kept
FULL = {
    errno.ENOSPC: "the disk is full",
    errno.EDQUOT: "the disk quota is used up",
    errno.EFBIG: "a file grew beyond the limit set for it",
    errno.EROFS: "the disk can only be read",
}


class Folder:
    """Where a package is written; use `open_folder`.

    Attributes
    ----------
    path : Path
        The output folder.
    work : Path
        Its hidden folder of the lock, the cache and files not yet in place.
    cache : Path
        What a later build can use again (`fabgeo.build.cache`).
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.work = path / WORK
        self.cache = self.work / "cache"
        self._staged = self.work / "staged"
        self._made: dict[str, str] = {}
        self._taken: dict[str, str] = {}
        self._ledger = _ledger_of(self.work / LEDGER)

    def place(self, name: str) -> Path:
        """Where to write the file that will be `name` (relative, with /) once all is well.

        Raises
        ------
        InputError
            If the name would leave the folder.
        """
        pure = PurePosixPath(name)
        if pure.is_absolute() or ".." in pure.parts or "\\" in name or name.startswith("."):
            raise InputError(name, "is no name of a file inside the output folder")
        self._taken.pop(name, None)
        path = self._staged.joinpath(*pure.parts)
        path.parent.mkdir(parents=True, exist_ok=True)
        if (
            path.is_file()
        ):  # perhaps the package's own, taken over by a link: not to be written into
            path.unlink()
        return path

    def text(self, name: str, content: str) -> None:
        """Write a text file."""
        self.place(name).write_text(content, encoding="utf-8", newline="\n")

    def json(self, name: str, content: Any) -> None:
        """Write plain data as JSON."""
        self.text(name, json.dumps(content, indent=1, allow_nan=False) + "\n")

    def write(self, name: str, writer: Callable[[Path], Any]) -> Any:
        """Let `writer` write one file, or fill one folder."""
        return writer(self.place(name))

    def again(self, name: str, key: str) -> bool:
        """Take over the file of that name if it was made from the same; else say it will be.

        Parameters
        ----------
        key : str
            Digest of everything that the file depends on.
        """
        key += os.environ.get("SOURCE_DATE_EPOCH", "")  # files tell the moment
        self._made[name] = key
        old, path = self._ledger.get(name), self.path / name
        if old is None or old[0] != key or path.is_symlink() or not path.is_file():
            return False
        if sha256_of(path) != old[1]:
            return False
        place = self.place(name)
        try:
            os.link(path, place)
        except OSError:
            shutil.copy2(path, place)
        self._taken[name] = old[1]
        return True

    @property
    def taken(self) -> dict[str, str]:
        """sha256 of the files that were taken over and have not been placed anew since."""
        return dict(self._taken)

    def forget(self) -> None:
        """Take nothing over."""
        self._ledger = {}

    @property
    def staged(self) -> Path:
        """The folder that holds the files until they are moved into place."""
        self._staged.mkdir(parents=True, exist_ok=True)
        return self._staged

    def finish(self) -> None:
        """Move the staged files into place, the manifest last; remove those of the package before.

        Raises
        ------
        InputError
            If a link stands where a file or folder of the package belongs, or one for the other.
        """
        names = sorted(p.relative_to(self.staged).as_posix() for p in _files_in(self.staged))
        refuse_strange(self.path, [*names, MANIFEST])
        old = _files_of(self.path / MANIFEST)
        self._write_ledger()
        (self.path / MANIFEST).unlink(missing_ok=True)
        for name in [n for n in names if n != MANIFEST]:
            target = self.path / name
            target.parent.mkdir(parents=True, exist_ok=True)
            os.replace(self.staged / name, target)
        for name in sorted(set(old) - set(names)):
            remove(self.path, name)
        os.replace(self.staged / MANIFEST, self.path / MANIFEST)

    def _write_ledger(self) -> None:
        """Before files move: a file that is not yet in place has another sha256, no harm done."""
        sums = _sums_of(self.staged / MANIFEST)
        ledger = {name: [key, sums[name]] for name, key in self._made.items() if name in sums}
        beside = self.work / f".{LEDGER}.part"
        beside.write_text(json.dumps(ledger), encoding="utf-8")
        os.replace(beside, self.work / LEDGER)


@contextmanager
def open_folder(path: Path | str) -> Iterator[Folder]:
    """Open an output folder for one build.

    Raises
    ------
    InputError
        If the path is a file, cannot be written to, or another build is at work in it.
    FabgeoError
        If the disk is full. What was finished is kept, as it is after an interrupt.

    Notes
    -----
    Where the input is bad, a folder that was not there before is not there afterwards, unless
    work that took long would be lost: then its hidden folder stays for the next build.
    """
    path, begin = Path(path), time.process_time()
    _refuse_epoch(os.environ.get("SOURCE_DATE_EPOCH", ""))
    try:
        made = not path.exists()
        path.mkdir(parents=True, exist_ok=True)
        refuse_strange(path, [MANIFEST, *(f"{WORK}/{own}" for own in OWN)])
        for own in ("", "cache", "staged"):
            refuse_strange(path, [f"{WORK}/{own}/any"])
        refuse_strange_below(path / WORK / "cache")
        (path / WORK).mkdir(exist_ok=True)
        lock = open(path / WORK / "lock", "a")  # noqa: SIM115 (held open for the whole build)
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or str(error)
        raise InputError(
            str(path), f"cannot be used as output folder: {why}", "choose another --out"
        ) from None
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise InputError(
                str(path), "another build is at work in this folder", "wait, or choose another"
            ) from None
        folder = Folder(path)
        shutil.rmtree(folder._staged, ignore_errors=True)
        try:
            yield folder
        except (InputError, GeometryError):
            bare = {p.name for p in path.iterdir()} == {WORK}
            if made and bare and time.process_time() - begin < LONG:
                shutil.rmtree(path)
            raise
        except OSError as error:
            if error.errno not in FULL:
                raise
            problem = f"nothing could be written: {FULL[error.errno]}"
            cure = "make room and build again: it goes on where it stopped"
            raise FabgeoError(str(path), problem, cure) from error
        finally:
            shutil.rmtree(folder._staged, ignore_errors=True)


def _refuse_epoch(stated: str) -> None:
    """Before hours of work: files tell this moment instead of their own."""
    if stated and not (stated.isascii() and stated.isdecimal() and int(stated) <= LATEST):
        found = f"expected whole seconds from 1970 to the year 9999, found {stated[:40]!r}"
        raise InputError("SOURCE_DATE_EPOCH", found, "set such a number, or unset it")


def _files_in(folder: Path) -> Iterator[Path]:
    return (path for path in folder.rglob("*") if path.is_file())


def _files_of(manifest: Path) -> list[str]:
    return list(_sums_of(manifest))


def _sums_of(manifest: Path) -> dict[str, str]:
    """Names of a manifest's files and their sha256."""
    try:
        files = json.loads(manifest.read_text(encoding="utf-8"))["files"]
    except (OSError, ValueError, KeyError, TypeError):
        return {}
    if isinstance(files, dict):
        return {str(name): str(value) for name, value in files.items()}
    return {str(name): "" for name in files} if isinstance(files, list) else {}


def _ledger_of(path: Path) -> dict[str, tuple[str, str]]:
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        return {str(name): (str(key), str(value)) for name, (key, value) in found.items()}
    except (OSError, ValueError, TypeError, AttributeError):
        return {}
