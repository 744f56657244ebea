"""Every reader on files changed at random: an answer or an error of fabgeo (see mutate.py)."""

from __future__ import annotations

import random
import warnings

import pytest
from mutate import mutated
from readers import READERS

FILES = 25


@pytest.mark.parametrize("name", READERS)
def test_changed_files(name: str) -> None:
    reader, rng = READERS[name], random.Random(8)
    seeds = reader.seeds()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # foreign readers warn of foreign bytes
        for data in seeds:
            reader.read_bytes(data)  # the seeds themselves are sound
        for _ in range(FILES):
            reader(mutated(seeds, rng))
