"""How much is tried to choose panels together: counts of work, never the clock."""

from __future__ import annotations

from dataclasses import dataclass

MANY = 1000  # panels beyond which one round of anything is all unless asked for
SOME = 450  # panels up to which neighbouring strips are placed at once unless asked for
FEW = 200  # panels up to which that is done again and again


@dataclass(frozen=True)
class Effort:
    """What the search for the least cost does, one after the other.

    Attributes
    ----------
    candidates : int
        Most rounds of new candidates against the neighbours as chosen.
    strips : int
        Most rounds of programmes of whole strips.
    windows : tuple of int
        How many neighbouring strips are then placed at once.
    again : int
        Most rounds of each of those.
    bounded : bool
        Whether programmes of strips also bound the cost.
    """

    candidates: int
    strips: int
    windows: tuple[int, ...]
    again: int
    bounded: bool

    @classmethod
    def of(cls, panels: int, rounds: int, thorough: bool) -> Effort:
        """What is worth while for so many panels, at most so many `rounds` of anything."""
        many = panels > MANY
        return cls(
            candidates=min(rounds, 1) if many else rounds,
            strips=min(rounds, 1) if many and not thorough else rounds,
            windows=(2, 3) if thorough or panels <= SOME else (),
            again=rounds if thorough or panels <= FEW else min(rounds, 1),
            bounded=rounds > 0 and not many,
        )
