"""References of a STEP text numbered afresh, all at once: millions of them in every file.

Glossary
--------
reference
    ``#`` and the number of an entity, where it is defined or referred to; ``#`` stands for
    nothing else in fabgeo's files (`fabgeo.cad.step.step_text`).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

type Bytes = npt.NDArray[np.uint8]

_DIGITS = 12  # of a number at most
_TENS = 10 ** np.arange(_DIGITS, dtype=np.int64)
_HASH, _ZERO = ord("#"), ord("0")


def renumbered(text: bytes, offset: int, known: Mapping[int, int]) -> bytes:
    """The text with `offset` added to every number, but those of `known` replaced by its values."""
    old = np.frombuffer(text, dtype=np.uint8)
    begin = np.flatnonzero(old == _HASH) + 1
    if not len(begin):
        return text
    number, width = numbers_at(old, begin)
    new = number + offset
    for one, other in known.items():
        new[number == one] = other
    wide = np.searchsorted(_TENS, new, side="right")
    grown = np.cumsum(wide - width)
    to = begin + np.append(0, grown[:-1])
    out = np.empty(len(old) + int(grown[-1]), dtype=np.uint8)
    out[_others(len(out), to, wide)] = old[_others(len(old), begin, width)]
    for k in range(int(wide.max())):
        some = wide > k
        digit = new[some] // _TENS[wide[some] - 1 - k] % 10
        out[to[some] + k] = digit + _ZERO
    return out.tobytes()


def numbers_at(
    text: Bytes, begin: npt.NDArray[np.intp]
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.intp]]:
    """Numbers that begin at places, and how many digits each has."""
    padded = np.append(text, np.zeros(_DIGITS, dtype=np.uint8))
    number = np.zeros(len(begin), dtype=np.int64)
    width = np.zeros(len(begin), dtype=np.intp)
    within = np.arange(len(begin))  # those that have not ended yet
    for k in range(_DIGITS):
        digit = padded[begin[within] + k] - np.uint8(_ZERO)  # what is below 0 wraps round
        within, digit = within[digit < 10], digit[digit < 10]
        if not len(within):
            break
        number[within] = 10 * number[within] + digit
        width[within] += 1
    return number, width


def _others(
    length: int, begin: npt.NDArray[np.intp], width: npt.NDArray[np.intp]
) -> npt.NDArray[np.bool_]:
    """Where a text of a length holds no digit of these numbers."""
    out = np.ones(length, dtype=bool)
    for k in range(int(width.max())):
        out[begin[width > k] + k] = False
    return out
