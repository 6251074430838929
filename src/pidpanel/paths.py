"""Paths of the project's own files."""

from pathlib import Path

PACKAGE = Path(__file__).resolve().parent  # folder of this package

# Root of the checkout, or the copy of its Snakefile, workflow and templates in a wheel.
PROJECT = PACKAGE / "project" if (PACKAGE / "project").is_dir() else PACKAGE.parents[1]

SNAKEFILE = PROJECT / "Snakefile"
PROFILE = PROJECT / "profiles" / "default"
TEMPLATES = PROJECT / "templates"
WORKFLOW = PROJECT / "workflow"
STUDIES = WORKFLOW / "studies"
# Tables that come with pidpanel: spectra, core materials, the paper's own numbers.
DATA = WORKFLOW / "data"

PAPER_TABLE = DATA / "paper" / "table_1.csv"  # natural frequencies as the paper printed them

# Simulated beds in dimensionless groups, and the constants of what is fitted to them.
ATLAS_CASES = PACKAGE / "atlas" / "cases.csv"
ATLAS_CONSTANTS = PACKAGE / "atlas" / "processes.json"

COUPON = Path("results") / "coupon"  # LIGGGHTS runs of all studies, below the working folder

SECTION = "coupon"  # name of the damper that the section ``coupon`` of a study is


def study_path(name: str) -> Path:
    """Return the path of a study: as given, or of one that comes with pidpanel.

    Examples
    --------
    >>> study_path("paper.yaml") == STUDIES / "paper.yaml"
    True
    >>> str(study_path("mine.yaml"))
    'mine.yaml'
    """
    path, shipped = Path(name), STUDIES / Path(name).name
    return shipped if path == Path(path.name) and not path.exists() and shipped.is_file() else path


def in_a_path(name: str) -> str:
    """Return a name without braces, which Snakemake takes for wildcards; each has one of its own.

    Examples
    --------
    >>> in_a_path("{0/90}s 50 %"), in_a_path("PID-1_r0.5")
    ('%7B0/90%7Ds 50 %25', 'PID-1_r0.5')
    """
    return name.translate({ord(character): f"%{ord(character):X}" for character in "%{}"})


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
