"""The documents as pages: `make docs`. Nothing is fetched, neither here nor by the pages."""

import re
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))

project = "pidpanel"
copyright = "pidpanel developers"
extensions = ["myst_parser", "mathml", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
html_theme = "furo"
html_title = "pidpanel"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_copy_source = False
html_show_sourcelink = False
exclude_patterns = ["_ext", "_static"]
nitpicky = True
nitpick_ignore_regex = [("py:.*", ".*")]  # types of other packages, whose pages are not at hand
autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
pygments_style = "default"


def setup(app):
    """Make notes outside of this folder files to open: MyST takes a Markdown file for a page."""
    notes = re.compile(r"\]\(((?:\.\./)+benchmarks/\w+\.md)(?:#[^)]*)?\)")

    def link(_app, _name, source):
        source[0] = notes.sub(r"](path:\1)", source[0])

    app.connect("source-read", link)
