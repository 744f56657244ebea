"""What a reader's process does to itself is an error here, and the next file is read."""

from __future__ import annotations

import multiprocessing
import os
import time
from pathlib import Path

import pytest

from fabgeo.cad import isolated
from fabgeo.cad.isolated import read_isolated
from fabgeo.errors import InputError


def refuse(path: Path) -> None:
    raise InputError(path.name, "is refused")


def test_death_hang_and_errors(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.step"
    path.write_text("x")
    own = read_isolated(path, os.getpid)
    assert own != os.getpid()
    with pytest.raises(InputError, match=r"^a\.step: is refused$"):
        read_isolated(path, refuse, path)
    assert read_isolated(path, os.getpid) == own  # kept
    with pytest.raises(InputError, match=r"a\.step: is damaged: its reader crashed; open it"):
        read_isolated(path, os.abort)
    assert read_isolated(path, os.getpid) not in (own, os.getpid())
    monkeypatch.setattr(isolated, "SECONDS", 1.0)
    with pytest.raises(InputError, match=r"a\.step: .* not read within 1 s"):
        read_isolated(path, time.sleep, 60.0)
    monkeypatch.undo()
    assert read_isolated(path, str.upper, "sound") == "SOUND"


def own_process(path: Path) -> bool:
    return read_isolated(path, os.getpid) == os.getpid()


def test_a_worker_of_a_pool_reads_by_itself(tmp_path: Path) -> None:
    """It may start no process; its death is its master's affair."""
    path = tmp_path / "a.step"
    path.write_text("x")
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert pool.apply(own_process, (path,))
