"""A small project, built once for all journeys: its geometry is simple, its way is whole."""

from __future__ import annotations

from pathlib import Path

import pytest
from journey_helpers import DOME, fabgeo


@pytest.fixture(scope="session")
def dome(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The package of the small dome, written by the command."""
    folder = tmp_path_factory.mktemp("dome")
    project = folder / "project.toml"
    project.write_text(DOME)
    done = fabgeo("build", project, "--out", folder / "out", "--jobs", "1")
    assert done.code == 0, done.out + done.err
    return folder / "out"
