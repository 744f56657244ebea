"""Work that is independent per part: through joblib, found in the cache, crashes isolated.

The user picks the backend: ``jobs`` processes on this machine, or joblib's own `parallel_config`
(``loky``, ``dask``) around the call.

Glossary
--------
crash
    The death of a worker process, by the kernel's fault on one part or from outside.
crossing
    Parts and results go to other processes and come back as bytes that were pickled once: joblib
    would look at every array by itself, which takes longer than many a part's work. A result
    comes with its bytes for the cache, which take long to make, too.
"""

from __future__ import annotations

import pickle
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor
from dataclasses import dataclass
from typing import Any

from joblib import Parallel, delayed

from fabgeo.build.cache import Cache
from fabgeo.build.plain import pack
from fabgeo.cad.isolated import end_with_parent

BATCH = 8  # parts that are sent to a worker together
AHEAD = 3  # batches a worker that wait or are worked on: none stands still while this one reads
FEW = 8  # parts of light work that this process does itself
ATTEMPTS = 2  # of one part alone, before it is the part's own fault
CRASHED = "the process that worked on it died, again when it was alone"

# joblib lets a worker go whose memory grew, between two parts: nothing is lost by it
warnings.filterwarnings("ignore", message="A worker stopped while some jobs were given")
# and tells of work left undone where an error, which says what to do, ends the build
warnings.filterwarnings("ignore", message=r"\d+ tasks (have been successfully|which were still)")


@dataclass(frozen=True)
class Work[P, R]:
    """One kind of work on parts.

    Attributes
    ----------
    kind : str
        Name of its entries in the cache.
    function : callable
        From a part to its result, in another process; its errors end the build.
    depends : callable
        The plain data of a part that its result depends on.
    crashed : callable
        Part and reason to the result of a part that kills its process.
    light : bool
        No part can kill its process: for a few of them no other processes are started.
    """

    kind: str
    function: Callable[[P], R]
    depends: Callable[[P], Any]
    crashed: Callable[[P, str], R]
    light: bool = False


def results[P, R](
    work: Work[P, R], parts: Sequence[P], jobs: int | None = None, cache: Cache | None = None
) -> Iterator[R]:
    """Results of all parts, in their order; each is kept in the cache when it is taken.

    Other processes begin at once: this one can do something else before it takes the results.
    """
    store = cache or Cache()
    keys = [store.key(work.kind, work.depends(part)) for part in parts]
    found = [store.get(work.kind, key) for key in keys]
    missing = [part for part, value in zip(parts, found, strict=True) if value is None]
    kept = store.folder is not None
    if work.light and len(missing) <= FEW:
        jobs = 1
    made = _survived(work, missing, jobs, kept, _run(work.function, missing, jobs, kept))
    return _in_order(store, work.kind, keys, found, made)


def _in_order[R](
    store: Cache,
    kind: str,
    keys: Sequence[str],
    found: Sequence[R | None],
    made: Iterator[tuple[R, bytes | None]],
) -> Iterator[R]:
    """What was found and what is made, each in its place."""
    for value, key in zip(found, keys, strict=True):
        if value is not None:
            yield value
            continue
        result, packed = next(made)
        if packed is not None:
            store.put_packed(kind, key, packed)
        yield result
    next(made, None)  # to its very end: joblib stops its processes where it is left before


def keep[P, R](work: Work[P, R], parts: Sequence[P], cache: Cache) -> None:
    """Spare the results of parts for the next build: this one took over what is made of them."""
    for part in parts:
        cache.keep(work.kind, cache.key(work.kind, work.depends(part)))


def _survived[P, R](
    work: Work[P, R],
    parts: Sequence[P],
    jobs: int | None,
    kept: bool,
    running: Iterator[tuple[bytes, bytes]],
    attempt: int = 1,
) -> Iterator[tuple[R, bytes | None]]:
    """Results in order with their bytes for the cache, None for those of a crash.

    Parts are halved around a crash.
    """
    done = 0
    try:
        for result, packed in running:
            done += 1
            yield pickle.loads(result), packed
    except Exception as error:
        if not is_crash(error):
            raise
    else:
        return
    rest = parts[done:]
    if len(rest) == 1 and attempt == ATTEMPTS:
        yield work.crashed(rest[0], CRASHED), None
        return
    half, attempt = (len(rest) // 2, 1) if len(rest) > 1 else (0, attempt + 1)
    for some in filter(None, (rest[:half], rest[half:])):
        running = _run(work.function, some, jobs, kept)
        yield from _survived(work, some, jobs, kept, running, attempt)


def _run[P, R](
    function: Callable[[P], R], parts: Sequence[P], jobs: int | None, kept: bool
) -> Iterator[tuple[bytes, bytes]]:
    """Bytes of results and what the cache keeps of them; other processes begin at once."""
    batch: Any = max(1, min(BATCH, len(parts) // 4))  # joblib tells its type by its default
    parallel = Parallel(
        n_jobs=jobs,
        return_as="generator",
        batch_size=batch,
        pre_dispatch=f"{AHEAD * batch} * n_jobs",  # it counts parts
    )
    work = (delayed(_done)(function, pickle.dumps(part), kept) for part in parts)
    return (result for result in parallel(work) if result is not None)


def _done[P, R](function: Callable[[P], R], part: bytes, kept: bool) -> tuple[bytes, bytes]:
    """Bytes of a part's result, and what the cache keeps of it."""
    end_with_parent()
    result = function(pickle.loads(part))
    return pickle.dumps(result), pack(result) if kept else b""


def is_crash(error: Exception) -> bool:
    """Whether an error means that a worker died (of loky or of dask)."""
    return isinstance(error, BrokenExecutor) or type(error).__name__ == "KilledWorker"
