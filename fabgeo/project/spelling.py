"""What a misspelt word was meant to be."""

from __future__ import annotations

import difflib


def mean(word: str, known: list[str]) -> str:
    """The end of a message on an unknown word: the nearest known one, or all of them."""
    close = difflib.get_close_matches(word, known, 1, 0.6)
    return f", did you mean {close[0]!r}?" if close else f", expected one of {', '.join(known)}"
