"""Work that worker processes import: on numbers, with faults where asked."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path


def squared(number: int) -> int:
    return number * number


def deadly(number: int) -> int:
    """Die at 13, as a fault of the CAD kernel does."""
    if number == 13:
        os.kill(os.getpid(), signal.SIGSEGV)
    return number * number


def dies_once(job: tuple[int, str]) -> int:
    """Die at 5, but only the first time: a worker that is killed from outside."""
    number, flag = job
    if number == 5 and not Path(flag).exists():
        Path(flag).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number * number


def stopped(number: int) -> int:
    """An error at 7."""
    if number == 7:
        raise OSError(28, "No space left on device")
    return number * number


HELD: list[bytearray] = []


def grows(n: int) -> tuple[int, int]:
    """The square and the process that made it; part 60 leaves 400 MB behind."""
    time.sleep(1.5 if n == 60 else 0.01)
    if n == 60:
        HELD.append(bytearray(b"1") * 400_000_000)
    return n * n, os.getpid()


def flagged(path: str) -> str:
    """Leaves a file behind."""
    Path(path).touch()
    return path
