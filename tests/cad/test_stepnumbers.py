"""References numbered afresh at once: what a replacement one by one gives."""

from __future__ import annotations

import re

import numpy as np
import pytest

from fabgeo.cad.stepnumbers import renumbered


@pytest.mark.parametrize("offset", [0, 1, 85, 99_999, 123_456_789])
def test_all_at_once_is_one_by_one(offset: int) -> None:
    numbers = np.random.default_rng(offset).integers(1, 10 ** np.arange(1, 9)).tolist()
    text = b"".join(b"#%d = LINE('x 12',#%d,(1.5,#%d));\n" % (n, 2 * n, n // 2) for n in numbers)
    text = b"head 7\n" + text + b"#3"
    known = {numbers[3]: 5, 3: 1_000_000}

    def one(found: re.Match[bytes]) -> bytes:
        number = int(found[1])
        return b"#%d" % (known.get(number) or number + offset)

    assert renumbered(text, offset, known) == re.sub(rb"#(\d+)", one, text)


def test_a_text_without_references_stays_as_it_is() -> None:
    assert renumbered(b"ENDSEC; 12\n", 5, {}) == b"ENDSEC; 12\n"
