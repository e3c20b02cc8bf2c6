"""Configuration of sphinx: docstrings make the reference, the registry the operations, the examples the gallery."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import meshcore

project = "meshcore"
author = "The meshcore developers"
version = release = meshcore.__version__
extensions = ["sphinx.ext.autodoc", "sphinx.ext.autosummary", "sphinx.ext.viewcode", "numpydoc"]
exclude_patterns = ["_build"]
html_theme = "alabaster"
html_theme_options = {"description": "Structured, unstructured and adaptive mesh generation", "page_width": "1100px"}
html_static_path = []
autosummary_generate = True
autodoc_typehints = "none"
autodoc_default_options = {"members": True, "show-inheritance": True}
numpydoc_show_class_members = False
add_module_names = False
default_role = None


def setup(app):
    """Write the generated pages before autosummary looks for its own."""
    from generate import write_all

    app.connect("builder-inited", lambda app: write_all(Path(app.srcdir)), priority=100)
