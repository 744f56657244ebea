"""Initial strip models: what an optimisation starts from (paper, "Initializing optimization").

Every method has its file; `start` calls it, checks the result for folds and says why it was chosen.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from fabgeo.arrays import checked_count, shown
from fabgeo.errors import InputError
from fabgeo.fitting.starts.auto import candidates_of, why
from fabgeo.fitting.starts.candidate import Candidate, reference_of
from fabgeo.fitting.starts.methods import STARTS, called, told
from fabgeo.fitting.starts.quality import check_folds, quality
from fabgeo.strips.model import KINDS, Kind, StripModel
from fabgeo.surfaces.base import DesignSurface, check_surface
from fabgeo.surfaces.trace_extension import Extended

METHODS: tuple[str, ...] = ("auto", *STARTS)
MOST_STRIPS, MOST_SEGMENTS = 1_000_000, 10_000


@dataclass(frozen=True)
class Start:
    """An initial strip model, the method it came by, and why.

    Attributes
    ----------
    model : StripModel
    method : str
        The method used ("auto" is replaced by the chosen one).
    why : str
        The reason in words, with the figures it rests on.
    candidates : list of Candidate
        What was tried, best first (one, unless "auto").
    notes : list of str
        What the method found: umbilics, resampling, parameters made conjugate.
    reference : DesignSurface
        What to fit the model to: the surface itself, or, where the model overhangs its boundary,
        the surface with its smooth continuation (`surfaces.trace_extension.Extended`).
    """

    model: StripModel
    method: str
    why: str
    candidates: list[Candidate]
    notes: list[str]
    reference: DesignSurface

    @property
    def overhangs(self) -> bool:
        """Whether the model reaches beyond the boundary, to be trimmed (`strips.trim`)."""
        return isinstance(self.reference, Extended)


def start(
    surface: DesignSurface,
    method: str = "auto",
    strips: int | None = None,
    segments: int | None = None,
    direction: str | None = None,
    seed: Any = None,
    kind: Kind = "general",
    held: bool = False,
    **options: Any,
) -> Start:
    """An initial strip model for a design surface.

    Parameters
    ----------
    surface : DesignSurface
    method : str
        "auto" measures candidates and chooses; or one of `METHODS`.
    strips, segments : int, optional
        Numbers wanted; by default from a sag target (option `sag`).
    direction : str, optional
        Which family the edges follow, in the method's own words ("u" or "v").
    seed : optional
        What the method starts from: a point, a curve, or a previous model.
    kind : str
        What the model will be fitted to: "auto" begins with principal lines for conical and
        circular models, which have the property already.
    held : bool
        Whether the fit will be asked to hold the model on the boundary: "auto" then leaves no
        border of a general model free, however far that keeps strips off the surface.
    **options
        Further options of the method's own function.

    Raises
    ------
    InputError
        For unknown methods, kinds or options, and strip counts that the surface can't hold.
    GeometryError
        If the start folds, naming strip and u.
    """
    if not isinstance(method, str) or method not in METHODS:
        expected = f"expected one of {', '.join(METHODS)}"
        raise InputError("start method", f"{expected}, found {shown(method)}")
    if not isinstance(kind, str) or kind not in KINDS:
        raise InputError("start kind", f"expected one of {', '.join(KINDS)}, found {shown(kind)}")
    check_surface("start", surface)
    for name, value, most in (
        ("strips", strips, MOST_STRIPS),
        ("segments", segments, MOST_SEGMENTS),
    ):
        if value is not None:  # what a surface can hold is less
            checked_count(name, value, 0, most)
    if method == "auto":
        found = candidates_of(surface, (strips, segments), direction, kind, options, held)
        words = why(found, surface)
    else:
        model, notes = called(method, surface, strips, segments, direction, seed, options)
        check_folds(model, surface, method)
        figures, model = quality(model, surface), told(model, method, direction, notes)
        way = direction if isinstance(direction, str) else ""
        found = [Candidate(method, way, figures, "", model, tuple(notes))]
        words = f"{found[0].name} was asked for: {figures}"
    best = found[0]
    assert best.model is not None  # or it would not hold
    return Start(
        best.model, best.method, words, found, list(best.notes), reference_of(best.model, surface)
    )
