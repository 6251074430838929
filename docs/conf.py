"""The documents as pages: `make docs`. Nothing is fetched, neither here nor by the pages."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))

project = "pidpanel"
copyright = "pidpanel developers"
extensions = ["myst_parser", "mathml"]
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
pygments_style = "default"
