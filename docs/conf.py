"""Sphinx configuration; tables of parts, figures and examples are generated from the code at every build."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from comparison import write_comparison
from example_runs import write_examples
from figures import write_flows, write_ten_minutes
from many_links import write_many_links
from tables import write_schema, write_tables

import selfmotion

project = "selfmotion"
author = "The selfmotion developers"
release = version = selfmotion.__version__
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx-mathjax-offline",
]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build", "_generated"]
html_theme = "furo"
html_title = f"selfmotion {release}"
html_static_path = ["_static"]
html_css_files = ["output.css"]
html_extra_path = ["_generated/problem.schema.json"]
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
autodoc_default_options = {"members": True, "inherited-members": True, "show-inheritance": True}
autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True
# "array, shape (n_u,)" is prose, but Sphinx looks up each word of a type and finds several n_u.
suppress_warnings = ["ref.python"]

write_tables(Path(__file__).parent / "_generated")
write_comparison(Path(__file__).parent / "_generated")
write_schema(Path(__file__).parent / "_generated")
write_flows(Path(__file__).parent / "_generated")
write_ten_minutes(Path(__file__).parent / "_generated")
write_many_links(Path(__file__).parent / "_generated")
write_examples(Path(__file__).parent / "_generated")
