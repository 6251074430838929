"""pidpanel for notebooks: a study in; damping, modes and responses out, as xarray with units.

``import pidpanel`` gives what `__all__` names here; nothing of it is imported before it is used.
"""

from __future__ import annotations

import html
import subprocess
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike

from pidpanel.arrays import variable
from pidpanel.check import checked_study
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping.from_study import damper_model, read_cases, surface_of
from pidpanel.damping.models import Damper
from pidpanel.paths import SECTION, of_damper, study_path
from pidpanel.provenance import durable
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.links import check_working_folder
from pidpanel.provenance.results import read_csv, read_netcdf
from pidpanel.response.from_study import partly_known
from pidpanel.severity.from_study import rms_margins
from pidpanel.severity.margins import JUDGED
from pidpanel.severity.tables import PLACE
from pidpanel.sound.from_study import bands_on_face
from pidpanel.study import CouponStudy, Study, StudyError
from pidpanel.study.dampers import COUPLED
from pidpanel.study.document import Document
from pidpanel.study.values import plain
from pidpanel.study.writing import text_of, values_of, with_changes
from pidpanel.workflow.stage_results import ResultsError, StageResults, result_at

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Model", "ResultsError", "StudyError"]

# Where `Model.damping` reads by default: r, Γ, and how many frequencies of the response.
FILLS, ACCELERATIONS = (0.1, 0.3, 0.5, 0.7, 0.9), (3.0, 10.0, 30.0, 100.0, 300.0)
FREQUENCIES = 30

Source = str | Path | Mapping[str, Any]


class Model:
    """A study, and what can be computed from it.

    Without LIGGGHTS, everything is computed here when it is first needed. What depends on
    simulated particles is read from ``results/<study>`` once `run` has computed it.

    Parameters
    ----------
    study
        YAML file, name of a study that comes with pidpanel, or the same keys as a mapping.
    folder
        Folder with the folder ``results``, and to which paths in a mapping are relative;
        the working folder by default.

    Raises
    ------
    StudyError
        One line for each mistake.

    Examples
    --------
    >>> model = Model("l_panel.yaml")
    >>> values = model.damping(fill_fraction=0.5, frequency_hz=[100, 200], acceleration_g=10)
    >>> values["equivalent_damping"].dims, values["equivalent_damping"].attrs["units"]
    (('fill_fraction', 'frequency', 'acceleration'), 'N s m-3')
    """

    def __init__(self, study: Source, folder: str | Path | None = None) -> None:
        self.folder = Path(folder or ".").absolute()
        self._values: dict[str, Any] = {}
        self._file: Path | None = None
        self.study: Study | CouponStudy
        if isinstance(study, Mapping):
            self._values = dict(study)
            self.study = _of_mapping(self._values, self.folder)
        else:
            self._file = study_path(str(study)).absolute()
            self.study = checked_study(self._file)

    def changed(self, values: Mapping[str, Any]) -> Model:
        """Return the model of the same study with other values.

        Parameters
        ----------
        values
            New values by keys joined with dots. Runs with LIGGGHTS need another ``name``.

        Examples
        --------
        >>> model = Model("l_panel.yaml").changed({"panel.damping_ratio": 0.02})
        >>> model.modes().sizes["point"]
        3
        """
        full = plain(self._values) if self._file is None else values_of(self._file)
        return Model(with_changes({"name": self.study.name, **full}, values), self.folder)

    def __repr__(self) -> str:
        return f"<pidpanel model {self.study.name!r} in {str(self.folder)!r}>"

    def _repr_html_(self) -> str:
        """Return name and title, and the summary of the responses once they are computed."""
        head = f"<p><b>{html.escape(self.study.name)}</b>: {html.escape(self.study.title)}</p>"
        is_computed = isinstance(self.study, Study) and self._stages.has_response
        return head + (self.summary().to_html(index=False) if is_computed else "")

    @property
    def results(self) -> Path:
        """Folder of the results that `run` leaves."""
        return self.folder / "results" / self.study.name

    def run(self, *targets: str, jobs: int = 2) -> Model:
        """Run the study with Snakemake, LIGGGHTS included; what is up to date is kept.

        Parameters
        ----------
        targets
            Files in `results`, such as ``coupon/cases.csv``; all by default.
        jobs
            Number of parallel jobs.

        Raises
        ------
        ResultsError
            If the run fails, with the message of Snakemake.
        """
        check_working_folder(self.folder)
        file = self._file
        if file is None:
            file = self.results / "study.yaml"
            file.parent.mkdir(parents=True, exist_ok=True)
            durable.write_text(file, text_of({"name": self.study.name, **self._values}))
        names = [f"results/{self.study.name}/{name}" for name in targets]
        self.folder.mkdir(parents=True, exist_ok=True)
        from pidpanel.cli.snakemake import command, release

        release(self.folder)
        call = command(file, self.folder, [*names, f"-j{jobs}"])
        done = subprocess.run(call, capture_output=True, text=True, check=False)
        if done.returncode:
            raise ResultsError(f"{self.study.name}: the run failed\n{done.stdout}{done.stderr}")
        return self

    def damping(
        self,
        source: str | None = None,
        *,
        fill_fraction: float | Sequence[float] = FILLS,
        frequency_hz: float | Sequence[float] | None = None,
        acceleration_g: float | Sequence[float] = ACCELERATIONS,
    ) -> xr.Dataset:
        """Return C_e(r, f, Γ) and m_a(r, f, Γ) of a damper.

        Parameters
        ----------
        source
            Name of a damper of the study; its only one by default.
        fill_fraction, frequency_hz, acceleration_g
            Values of r, f [Hz] and Γ.

        Returns
        -------
        xarray.Dataset
            ``equivalent_damping`` with its standard error, ``apparent_mass``, and ``inside``: 0
            where they are extrapolated.

        Raises
        ------
        ResultsError
            If it depends on LIGGGHTS and the study was not run.
        DampingError
            If the damper has no damping there.
        """
        fills, gammas = np.atleast_1d(fill_fraction), np.atleast_1d(acceleration_g)
        if frequency_hz is None:
            frequency_hz = np.geomspace(*self._frequency_range, FREQUENCIES).tolist()
        frequency = np.atleast_1d(np.asarray(frequency_hz, np.float64))
        axes = {"fill_fraction": fills, "frequency_hz": frequency, "acceleration_g": gammas}
        for key, coordinate in axes.items():
            limit, top = (" and at most 1", 1.0) if key == "fill_fraction" else ("", 1e300)
            if refused := [x for x in coordinate.tolist() if not 0 < x <= top]:
                raise StudyError(f"{key} = {refused[0]:g}: must be above 0{limit}")
        damper = self._damper(source)
        values = [[damper(frequency, r, g) for g in gammas.tolist()] for r in fills.tolist()]
        dims = "fill_fraction frequency acceleration"
        variables = {}
        for name, (units, meaning) in DAMPING.items():
            array = np.array([[getattr(entry, name) for entry in row] for row in values])
            variables[name] = variable(dims, array.swapaxes(1, 2).astype(float), units, meaning)
        coordinates = {
            "fill_fraction": variable("fill_fraction", fills, "1"),
            "frequency": variable("frequency", frequency, "Hz"),
            "acceleration": variable("acceleration", gammas, "g", "Γ"),
        }
        return xr.Dataset(variables, coordinates, stamp(self.study))

    def cases(self, damper: str | None = None) -> pd.DataFrame:
        """Return the simulated cases of a damper, by default of the only coupon: ``cases.csv``."""
        coupons = list(self.study.coupons)
        if damper is None and len(coupons) == 1:
            (damper,) = coupons
        if damper not in coupons:
            named = f"must be one of {', '.join(coupons)}" if coupons else "no tones are simulated"
            raise StudyError(f"damper = {damper}: {named}")
        return read_cases(result_at(of_damper(self.results / "coupon", damper, "cases.csv")))

    def modes(self) -> xr.Dataset:
        """Return the modes of the panel: frequencies, masses, shapes at the points and the mesh."""
        basis = read_netcdf(self._stages.files("panel").modes)
        modes = basis.isel(shape=np.flatnonzero(basis["is_residual"].to_numpy() == 0))
        modes = modes.sortby("natural_frequency").rename({"shape": "mode"})
        names = [str(name) for name in basis["point_names"].to_numpy()]
        fields = ["natural_frequency", "modal_mass", "shape_at_points", "shape_at_vertices"]
        number = np.arange(1, modes.sizes["mode"] + 1)
        return modes[[*fields, "vertex_position", "cells"]].assign_coords(point=names, mode=number)

    def sound(self) -> xr.Dataset:
        """Return the bands of the sound: levels, and the PSD of the pressure on the panel."""
        bands = bands_on_face(self._with_panel().acoustics)
        pressure = bands["surface_pressure_psd_pa2_hz"]
        return xr.Dataset(
            {
                "lower": variable("frequency", bands["lower_hz"], "Hz"),
                "upper": variable("frequency", bands["upper_hz"], "Hz"),
                "band_spl": variable("frequency", bands["band_spl_db"], "dB"),
                "pressure_psd": variable("frequency", pressure, "Pa2 Hz-1"),
            },
            {"frequency": variable("frequency", bands["center_hz"], "Hz")},
        )

    def response(self, lines: ArrayLike | None = None) -> xr.Dataset:
        """Return PSDs and rms values of every scenario at every point.

        Parameters
        ----------
        lines
            Frequencies of the PSDs [Hz], such as those of another model, with which `xarray.concat`
            then joins them; by default those that resolve the resonances of this panel.

        Raises
        ------
        ResultsError
            If it depends on LIGGGHTS and the study was not run, or has changed since.
        GridError
            If the lines are too far apart for the resonances.
        """
        # matplotlib is slow to import
        from pidpanel.report.inputs import without_errors

        frequency = None if lines is None else np.array(lines, np.float64)
        files = self._stages.files("response", frequency)
        table = read_csv(files.summary, dtype={"point": str})
        labels = partly_known(self._with_panel())
        summary, psd = without_errors(labels, table, read_netcdf(files.psd))
        index = summary.set_index(["scenario", "point"])
        template = psd["acceleration_psd"].isel(frequency=0, drop=True)
        for column, (name, units, factor) in RMS.items():
            if column in index:
                rows = index[column].to_xarray().reindex_like(template).transpose(*template.dims)
                psd[name] = (rows * factor).assign_attrs(units=units)
        return psd

    def summary(self) -> pd.DataFrame:
        """Return ``response/summary.csv``, with ``rms_verdict`` where a point has a rms limit.

        It and the margins are those of ``severity/margins.csv`` under sound, without PSD limits.
        """
        table = read_csv(self._stages.files("response").summary, dtype={"point": str})
        rows = rms_margins(self._with_panel(), table)
        columns = {"limit": "limit_rms_g", **{name: f"rms_{name}" for name in JUDGED}}
        judged = rows[[*PLACE, *columns]].rename(columns=columns)
        return table.merge(judged, "left", list(PLACE)) if len(judged) else table

    def stress(self) -> xr.Dataset:
        """Return PSDs and rms values of strains and stresses at every point, by layer."""
        psd = read_netcdf(self._stages.files("response").stress)
        for name, values in tuple(psd.items()):
            rms = str(name).replace("_psd", "_rms")
            psd[rms] = np.sqrt(values.astype(float).integrate("frequency"))
            psd[rms].attrs["units"] = "1" if rms.startswith("strain") else "Pa"
        return psd

    def energy(self) -> xr.Dataset:
        """Return one PSD of each point, modal below and statistical energy above, with rms values.

        ``acceleration_rms`` is to ``highest``; ``status`` is ok, or why there is no energy.
        """
        files = self._stages.files("energy")
        rows = read_csv(files.summary, dtype={"point": str}).set_index(["scenario", "point"])
        psd, table = read_netcdf(files.psd), rows.to_xarray()
        for column in ("acceleration_rms_g", "acceleration_rms_error_g"):
            name, units, factor = RMS[column]
            psd[name] = (table[column] * factor).assign_attrs(units=units)
        return psd.assign(highest=table["highest_hz"], status=table["status"])

    def base(self, motion: str = "random") -> xr.Dataset:
        """Return PSDs under ``random`` base motion, or amplitudes in a ``sine`` sweep."""
        files = {"random": "psd", "sine": "sine"}
        path = self._stages.files("base").get(files.get(motion, ""))
        if path is None:
            raise StudyError(f"motion = {motion}: must be a part of base: {', '.join(files)}")
        return read_netcdf(path)

    def optimise(self) -> pd.DataFrame:
        """Return the proposed layouts, ``optimise/front.csv``: mass, rms values, reduction."""
        return read_csv(self._stages.files("optimise").front)

    def plot(self, point: str | None = None) -> Figure:
        """Return a figure of the PSDs at a point, the first by default, for all scenarios."""
        from matplotlib.figure import Figure

        response, g = self.response(), STANDARD_GRAVITY
        points = [str(name) for name in response["point"].to_numpy()]
        if (point := point or points[0]) not in points:
            raise StudyError(f"point = {point}: must be one of {', '.join(points)}")
        axes = (figure := Figure(layout="constrained")).subplots()
        for name, case in response.sel(point=point).groupby("scenario", squeeze=False):
            rms = float(case["acceleration_rms"].item()) / g
            curve = case["acceleration_psd"].squeeze("scenario") / g**2
            axes.loglog(curve["frequency"], curve, label=f"{name}: {rms:.3g} g rms")
        axes.set(xlabel="Frequency [Hz]", ylabel="Acceleration PSD [g²/Hz]")
        axes.set_title(f"{self.study.name}, point {point}")
        axes.legend()
        return figure

    # ------------------------------------------------------------------ how it is computed

    def _with_panel(self) -> Study:
        if not isinstance(self.study, Study):
            raise StudyError(f"{self.study.name}: panel: missing; a study of the coupon alone")
        return self.study

    @property
    def _frequency_range(self) -> tuple[float, float]:
        """Frequency range of the response, or of the sweep of a coupon alone [Hz]."""
        if isinstance(self.study, Study):
            return self.study.response.frequency_hz
        frequencies = [f for c in self.study.coupons.values() for f in c.sweep.frequencies]
        return min(frequencies), max(frequencies)

    @cached_property
    def _stages(self) -> StageResults:
        return StageResults(self._with_panel(), self.results)

    def _damper(self, source: str | None) -> Damper:
        study = self.study
        if not isinstance(study, Study):
            return surface_of(study.coupons[SECTION], self.cases())
        # that of coupled runs is of their scenarios, and no function of r, f and Γ
        sources = [name for name in study.dampers if name not in study.beds(COUPLED)]
        if source is None and len(sources) == 1:
            (source,) = sources
        if source is None or source not in sources:
            table = f"results/{study.name}/coupled/impedance.csv"
            hint = f"; results of coupled runs are in {table}" if study.is_coupled else ""
            allowed = f"must be one of {', '.join(sources)}" if sources else "has no damping here"
            raise StudyError(f"source = {source}: {allowed}{hint}")
        surface = self._surface(source) if source in study.coupons else None
        return damper_model(study.dampers[source], surface, is_broadband=False)

    def _surface(self, damper: str) -> Path:
        return result_at(of_damper(self.results / "damping", damper, "surface.nc"))


# Of C_e and m_a: unit and meaning.
DAMPING = {
    "equivalent_damping": ("N s m-3", "C_e"),
    "equivalent_damping_error": ("N s m-3", "standard error of C_e"),
    "apparent_mass": ("kg m-2", "m_a"),
    "inside": ("1", "1 where the value is not extrapolated"),
}

# Columns of ``summary.csv``: name in a dataset, unit, factor.
RMS = {
    "acceleration_rms_g": ("acceleration_rms", "m s-2", STANDARD_GRAVITY),
    "acceleration_rms_error_g": ("acceleration_rms_error", "m s-2", STANDARD_GRAVITY),
    "velocity_rms_m_s": ("velocity_rms", "m s-1", 1.0),
    "displacement_rms_mm": ("displacement_rms", "m", 1e-3),
    "reduction_db": ("reduction", "dB", 1.0),
    "reduction_error_db": ("reduction_error", "dB", 1.0),
    "added_mass_kg": ("added_mass", "kg", 1.0),
    "margin_db": ("margin", "dB", 1.0),
}


def _of_mapping(values: Mapping[str, Any], folder: Path) -> Study | CouponStudy:
    """Return the study that a mapping is, checked like that of a file."""
    return checked_study(Document(folder / "notebook.yaml", "", {"name": "notebook", **values}))
