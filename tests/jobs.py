"""Jobs of the workflow, called as the rules call them."""

import runpy
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

from pidpanel.paths import WORKFLOW
from pidpanel.provenance.files import Files
from pidpanel.study import load_any_study

SCRIPTS = WORKFLOW / "scripts"

PANEL = {
    "modes": "modes.nc",
    "table": "modes.csv",
    "shapes": "modes.vtu",
    "mesh": "mesh.msh",
    "section": "section.csv",
    "plate": "plate.nc",
}
SOUND = {"spectrum": "spectrum.csv", "modal_force": "modal_force.nc"}
RESPONSE = {
    "psd": "psd.nc",
    "summary": "summary.csv",
    "layouts": "layouts.csv",
    "stress": "stress.nc",
    "stress_table": "stress.csv",
    "left_out": "left_out.nc",
}


def files(paths):
    """Named files from a path or a list of paths by each name; None is left out."""
    return Files({name: path for name, path in paths.items() if path})


class Named(dict):
    """Named values, as Snakemake hands them to a script."""

    __getattr__ = dict.__getitem__


def call(name, study, input, output, *, params=None):
    """Run a script of the workflow, with its study, files and parameters."""
    given = SimpleNamespace(
        input=Named({key: _texts(value) for key, value in input.items()}),
        output=Named({key: str(value) for key, value in output.items()}),
        params=Named({"damping": None, "coupled": None, **(params or {})}),
        wildcards=Named(params or {}),
        config={"file": study},
    )
    read = load_any_study(study) if study else None
    begun = read, Files(given.input), Files(given.output)
    with mock.patch("pidpanel.job.started", lambda _: nullcontext(begun)):
        runpy.run_path(str(SCRIPTS / f"{name}.py"), {"snakemake": given})


def _texts(value):
    return [str(item) for item in value] if isinstance(value, list) else str(value)


def within(folder, names):
    """Named files in a folder."""
    return {key: Path(folder) / name for key, name in names.items()}


def make_panel(study, folder):
    """Call the script of the panel; all files go to one folder."""
    call("panel", study, {}, within(folder, PANEL))


def make_sound(study, folder, *, modes=None, air=False):
    """Call the script of the sound."""
    names = SOUND | ({"air": "air.nc"} if air else {})
    call("sound", study, {"modes": modes or Path(folder) / "modes.nc"}, within(folder, names))
