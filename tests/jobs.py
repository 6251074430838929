"""Jobs of the workflow, called as the rules call them."""

from importlib import import_module
from pathlib import Path

from pidpanel.provenance.files import Files, Job

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
    several = {name: p if isinstance(p, list) else [p] for name, p in paths.items() if p}
    return Files({name: [Path(path) for path in many] for name, many in several.items()})


def call(name, study, input, output, *, params=None, **more):
    """Call a script of the workflow."""
    job = Job(files(input), files(output), params or {}, Path(study), **more)
    import_module(f"scripts.{name}").main(job)


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
