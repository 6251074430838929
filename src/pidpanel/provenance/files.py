"""Named files of a stage, as its rule names them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pidpanel.study import Study


class Files:
    """Named files: ``files.modes`` is a path, ``files.get("air")`` may be None."""

    def __init__(self, named: Any) -> None:
        """Take ``snakemake.input`` or ``snakemake.output``, or a mapping."""
        several = {name: [f] if isinstance(f, str | Path) else f for name, f in named.items()}
        self.all = {name: list(map(Path, files)) for name, files in several.items()}

    def __getattr__(self, name: str) -> Path:
        """Return the only file of a name."""
        path = self.get(name)
        if path is None:
            raise AttributeError(f"no file of the name {name}")
        return path

    def get(self, name: str) -> Path | None:
        """Return the only file of a name; None if there is none."""
        paths = self.all.get(name, ())
        if len(paths) > 1:
            raise ValueError(f"{name}: {len(paths)} files in place of one")
        return paths[0] if paths else None

    def several(self, name: str) -> list[Path]:
        """Return all files of a name."""
        return list(self.all.get(name, ()))


PANEL = {
    "modes": "modes.nc", "table": "modes.csv", "shapes": "modes.vtu", "mesh": "mesh.msh",
    "section": "section.csv", "plate": "plate.nc",
}  # fmt: skip
RESPONSE = {
    "psd": "psd.nc", "summary": "summary.csv", "layouts": "layouts.csv", "stress": "stress.nc",
    "stress_table": "stress.csv", "left_out": "left_out.nc",
}  # fmt: skip
ENERGY = {"bands": "bands.csv", "psd": "psd.nc", "summary": "summary.csv"}
SEVERITY = ("oscillators", "peaks", "fatigue", "strength")
MARGIN, UPDATE = ("ranges", "shares", "next_test"), ("inputs", "tests")
PROPOSAL = ("layouts", "front", "summary", "search", "psd")


def stage_files(study: Study, results: Path) -> dict[str, Files]:
    """Return the files of the stages of a study without LIGGGHTS, by the names of their rules."""
    names: dict[str, dict[str, str]] = {"panel": {k: f"panel/{v}" for k, v in PANEL.items()}}
    if study.sound is not None:
        sound = {"spectrum": "sound/spectrum.csv", "modal_force": "sound/modal_force.nc"}
        air = {"air": "sound/air.nc"} if study.radiation != "none" else {}
        names["sound"] = sound | air
        names["response"] = {key: f"response/{name}" for key, name in RESPONSE.items()}
        names["maps"] = {"maps": "response/maps.nc", "folder": "response/maps"}
        if study.energy is not None:
            names["energy"] = {key: f"energy/{name}" for key, name in ENERGY.items()}
        names["export"] = {"folder": "response/export"}
    if study.severity is not None:
        names["severity"] = {name: f"severity/{name}.csv" for name in SEVERITY}
        if study.severity.strength is not None:
            names["severity"]["maps"] = "severity/maps.nc"
    if study.limits:
        names["margins"] = {"margins": "severity/margins.csv"}
    if study.base is not None:
        parts = study.base.parts
        names["base"] = {"modes_table": "base/modes.csv"}
        if parts["random"]:
            names["base"] |= {"psd": "base/psd.nc", "psd_table": "base/psd.csv"}
            names["base"] |= {"summary": "base/summary.csv"}
            names["base_export"] = {"folder": "base/export"}
        if parts["notching"]:
            names["base"]["notched"] = "base/notched.csv"
        if parts["sine"]:
            names["base"] |= {"sine": "base/sine.nc", "sine_table": "base/sine.csv"}
    if study.optimise is not None:
        names["optimise"] = {name: f"optimise/{name}.csv" for name in PROPOSAL}
    if study.uncertain:
        names["margin"] = {name: f"margin/{name}.csv" for name in MARGIN}
        names["margin"]["runs"] = "margin/runs.nc"
        if study.update is not None:
            names["margin"] |= {name: f"margin/{name}.csv" for name in UPDATE}
    if study.measurements:
        measured = ("measured", "differences")
        names["measurement"] = {name: f"measurement/{name}.csv" for name in measured}
        if any(measurement.drive for measurement in study.measurements.values()):
            names["measurement"]["hammer"] = "measurement/hammer.nc"
    names["report"] = {"page": "report.html", "figures": "report"}
    return {
        stage: Files({key: results / name for key, name in files.items()})
        for stage, files in names.items()
    }
