"""Settings of Sphinx for these pages: `make docs`. The pages are read in the repository as well, as plain Markdown."""

import os
import sys
from importlib.metadata import version as installed_version
from pathlib import Path

DOCS = Path(__file__).parent
ROOT = DOCS.parent
sys.path.insert(0, str(DOCS / "extensions"))

project = "flexsat"
author = "the authors of flexsat"
version = release = installed_version("flexsat")
language = "en"

extensions = [
    "myst_parser",  # pages in Markdown
    "sphinx.ext.autodoc",  # the Python interface, from its docstrings,
    "sphinx.ext.napoleon",  # which have NumPy sections
    "reference_pages",  # commands and ports, from the code that defines them
    "repository_links",  # links of the pages to files beside docs/
]
exclude_patterns = ["build"]
source_suffix = {".md": "markdown"}
myst_heading_anchors = 3  # links to headings, as GitHub spells them
myst_enable_extensions = ["colon_fence"]
suppress_warnings = ["myst.xref_ambiguous"]

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # NumPy sections give types with shapes and units
napoleon_google_docstring = False
napoleon_numpy_docstring = True
napoleon_use_rtype = False

html_theme = "furo"
html_title = f"flexsat {release}"
html_show_sourcelink = False

interface_document = str(Path(os.environ.get("FLEXSAT_FMUS", ROOT / "fmus")) / "ICD.md")  # of the FMUs that were built
