"""The manual as HTML: `make docs`, warnings are errors. The reference comes from docstrings."""

import importlib.metadata
import os
import re
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent

project = "fabgeo"
author = "The fabgeo authors"
copyright = author
version = release = importlib.metadata.version("fabgeo")
extensions = ["sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax", "myst_parser"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["_build", "made/roof"]
html_theme = "alabaster"
html_theme_options = {"description": "From a freeform surface to the files a workshop cuts from"}
myst_heading_anchors = 3
autodoc_typehints = "none"  # shapes and units stand in the docstrings
autodoc_class_signature = "separated"
napoleon_numpy_docstring = True
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False


def run_tutorial(_app: object) -> None:
    """The tutorial's pictures are those that its own blocks make, in docs/made."""
    blocks = re.findall(r"```python\n(.*?)```", (HERE / "tutorial.md").read_text(), re.DOTALL)
    made = HERE / "made"
    made.mkdir(exist_ok=True)
    done = subprocess.run(
        [sys.executable, "-c", "\n".join(blocks)],
        cwd=made,
        env={**os.environ, "MPLBACKEND": "Agg"},
        capture_output=True,
        text=True,
    )
    if done.returncode:
        raise RuntimeError(f"the tutorial fails: {done.stderr[-2000:]}")


def setup(app: object) -> None:
    """Make the pictures before pages are read."""
    app.connect("builder-inited", run_tutorial)  # pyright: ignore[reportAttributeAccessIssue]
