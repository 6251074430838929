"""Where the project keeps its own files."""

from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
"""Root of the checkout."""

SNAKEFILE = PROJECT / "Snakefile"
TEMPLATES = PROJECT / "templates"
WORKFLOW = PROJECT / "workflow"
DATA = WORKFLOW / "data"
"""Tables that come with pidpanel: spectra, core materials, the paper's own numbers."""

PAPER_TABLE = DATA / "paper" / "table_1.csv"
"""Natural frequencies as the paper printed them."""
