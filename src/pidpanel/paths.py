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

SECTION = "coupon"
"""Name of the damper that the section ``coupon`` of a study is."""


def of_damper(stage: Path, damper: str, name: str) -> Path:
    """Return a file of one coupon in the folder of a stage, ``results/<study>/<stage>``.

    Examples
    --------
    >>> str(of_damper(Path("damping"), "steel", "surface.nc"))
    'damping/steel/surface.nc'
    >>> str(of_damper(Path("damping"), SECTION, "surface.nc"))
    'damping/surface.nc'
    """
    return stage / name if damper == SECTION else stage / damper / name
