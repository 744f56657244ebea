"""The manual as HTML: `make docs`, warnings are errors. The reference comes from docstrings."""

import importlib.metadata

project = "fabgeo"
author = "The fabgeo authors"
copyright = author
version = release = importlib.metadata.version("fabgeo")
extensions = ["sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax", "myst_parser"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["_build"]
html_theme = "alabaster"
html_theme_options = {"description": "From a freeform surface to the files a workshop cuts from"}
myst_heading_anchors = 3
autodoc_typehints = "none"  # shapes and units stand in the docstrings
autodoc_class_signature = "separated"
napoleon_numpy_docstring = True
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
