"""Work of the check that is independent per part: through joblib, each part with its own notes.

A part is measured into a `Measured` and `Findings` of its own, in this process or another, and
the notes are taken over in the parts' order: the report is the same for any number of processes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from fabgeo.cad.isolated import end_with_parent
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured

BATCH = 8
FEW = 100  # fewer are measured sooner than processes for them are started


def each[P](
    measure: Callable[[P, Measured, Findings], None],
    parts: Iterable[P],
    jobs: int | None,
    measured: Measured,
    findings: Findings,
    few: int = FEW,
    batch: int = BATCH,
) -> None:
    """Measure every part; many by `jobs` processes, None: as joblib's `parallel_config` says.

    Parameters
    ----------
    measure : callable
        Measures one part into what it is handed; importable, as it runs in other processes.
    parts : iterable
        What it measures.
    jobs : int, optional
    measured, findings
        Take in what was noted, in the order of the parts.
    few : int
        Fewer parts are measured by this process alone; 0: parts are large, and made as needed.
    batch : int
        Parts that are sent to a process together.
    """
    from joblib import Parallel, delayed

    every = list(parts) if few else parts
    size: Any = batch  # joblib tells its type by its default
    enough = not isinstance(every, list) or len(every) >= few
    parallel = Parallel(n_jobs=jobs if enough else 1, return_as="generator", batch_size=size)
    found: Any = parallel(delayed(partial(noted, measure))(part) for part in every)
    for own, notes in found:
        measured.take(own)
        findings.items += notes.items


def noted[P](
    measure: Callable[[P, Measured, Findings], None], part: P
) -> tuple[Measured, Findings]:
    """What is measured of one part, and what is found."""
    end_with_parent()
    measured, findings = Measured(), Findings()
    measure(part, measured, findings)
    return measured, findings
