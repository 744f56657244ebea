"""A fit that Ctrl-C, or a notebook's stop button, ends with the best model so far."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from fabgeo.arrays import shown
from fabgeo.errors import InputError
from fabgeo.fitting.result import Listener, Progress


@contextmanager
def stoppable(listener: Listener | None = None) -> Iterator[Listener]:
    """A listener for `fit`: an interrupt ends the fit after its step, a second one at once.

    Signals reach the main thread alone: use it there.

    Parameters
    ----------
    listener : callable, optional
        Told the progress as well; its answer counts too.

    Raises
    ------
    InputError
        If the listener is no function.

    Examples
    --------
    >>> with stoppable() as listener:  # doctest: +SKIP
    ...     result = fit(surface, start.model, listener=listener)
    """
    if listener is not None and not callable(listener):
        raise InputError("stoppable", f"expected a function as listener, found {shown(listener)}")
    stopped = False

    def stop(number: int, frame: FrameType | None) -> None:
        nonlocal stopped
        if stopped:
            raise KeyboardInterrupt
        stopped = True

    def heard(progress: Progress) -> bool:
        answer = True if listener is None else listener(progress)
        return not stopped and (answer is None or bool(answer))

    before = signal.signal(signal.SIGINT, stop)
    try:
        yield heard
    finally:
        signal.signal(signal.SIGINT, before)
