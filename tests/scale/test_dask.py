"""A Dask cluster gives the package of one process, also where a worker is killed in between."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from builds import ROOF, build, files

pytest.importorskip("distributed", reason="needs the extra cluster")
SCRIPT = Path(__file__).parent / "dask_build.py"


@pytest.mark.slow
def test_a_killed_worker_changes_no_byte(tmp_path: Path) -> None:
    build(tmp_path, ROOF, "--jobs", "1")
    done = subprocess.run(
        [sys.executable, SCRIPT, tmp_path / "project.toml", tmp_path / "cluster"],
        capture_output=True,
        text=True,
        timeout=800,
        env={**os.environ, "SOURCE_DATE_EPOCH": "1700000000"},
    )
    assert done.returncode == 0, done.stderr[-3000:]
    assert done.stdout.split() == ["2", "1", "False"]
    one, two = files(tmp_path / "out"), files(tmp_path / "cluster")
    assert [name for name in {*one, *two} if one.get(name) != two.get(name)] == []
