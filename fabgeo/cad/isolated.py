"""A foreign file read in a process of its own: what would kill or hold up this one is an error.

Native readers die of damaged files (the kernel of every fifth STEP file with a few numbers
changed) or never come to an end. Their process is kept for the next file, unless it failed.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from concurrent.futures import BrokenExecutor
from multiprocessing import current_process
from pathlib import Path
from typing import Any

from joblib.externals.loky import ProcessPoolExecutor

from fabgeo.errors import FabgeoError, InputError

SECONDS = 60.0  # for the smallest file, the start of the process included
SECONDS_PER_MIB = 30.0  # of its size, besides; the kernel takes about one
IDLE = 30  # seconds after which the process ends
CURE = "open it in the program that it came from, repair it there and export it again"

_lock = threading.Lock()
_kept: list[Any] = []  # the process, if one is running
_watched: list[int] = []  # in a worker: the process that it works for


def read_isolated[**P, R](path: Path, read: Callable[P, R], *args: P.args, **named: P.kwargs) -> R:
    """What `read` gives with these arguments, in another process (but in this one in a pool's).

    Parameters
    ----------
    path : Path
        The file that is read: its size limits the time, errors name it.
    read : callable
        Importable; arguments and result are pickled.

    Raises
    ------
    InputError
        If the process dies, or takes longer than any sound file of this size.
    """
    if current_process().daemon:  # a worker of a pool, which may have no processes of its own
        return read(*args, **named)
    seconds = SECONDS + SECONDS_PER_MIB * path.stat().st_size / (1 << 20)
    with _lock:
        if not _kept:
            _kept.append(start())
        try:
            return _kept[0].submit(_silently, read, *args, **named).result(seconds)
        except FabgeoError:
            raise
        except BaseException as error:
            _kept.pop().shutdown(kill_workers=True)
            if isinstance(error, BrokenExecutor):
                raise InputError(path.name, "is damaged: its reader crashed", CURE) from error
            if isinstance(error, TimeoutError):
                problem = f"is damaged: it was not read within {seconds:.0f} s"
                raise InputError(path.name, problem, CURE) from error
            if of_kernel(error) or isinstance(error, MemoryError):
                what = f"{type(error).__name__} {error}"
                raise InputError(path.name, f"is damaged: {what}", CURE) from error
            raise


def start() -> Any:
    """An executor with one process."""
    return ProcessPoolExecutor(1, timeout=IDLE)


def of_kernel(error: BaseException) -> bool:
    """Whether the CAD kernel raised it; its exceptions have no base class in the binding."""
    return type(error).__module__.startswith("OCP.")


def _silently[**P, R](read: Callable[P, R], *args: P.args, **named: P.kwargs) -> R:
    """In the other process: what is wrong is told by an error, and nothing else is printed."""
    end_with_parent()
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    os.close(nowhere)
    return read(*args, **named)


def end_with_parent() -> None:
    """In a worker: end when the process that it works for does, killed perhaps, without a word."""
    if current_process().name == "MainProcess" or _watched:
        return
    _watched.append(os.getppid())
    threading.Thread(target=_watch, daemon=True).start()


def _watch() -> None:
    while os.getppid() == _watched[0]:
        time.sleep(1.0)
    os._exit(1)
