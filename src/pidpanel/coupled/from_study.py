"""The coupled runs of a study: the only module of the stage that knows it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array, variable
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupled.beds import cpu_per_interval
from pidpanel.coupled.estimate import ScenarioEstimate
from pidpanel.coupled.excited_panel import ExcitedPanel
from pidpanel.coupled.kurtosis import EXPONENTS
from pidpanel.coupled.scenario import CoupledScenario, RunSettings, SimulatedPatch
from pidpanel.coupled.scenario_runs import INTERVALS_PER_PERIOD, STEP_RAYLEIGH, ScenarioRuns
from pidpanel.coupled.segments import SettledRecord
from pidpanel.coupled.softening import usual_modulus
from pidpanel.coupon.estimate import spheres_in
from pidpanel.coupon.from_study import bed_of
from pidpanel.damping.from_study import damper_model, with_mass_of
from pidpanel.damping.models import FilledDamper
from pidpanel.panel.files import read_basis, read_plate
from pidpanel.provenance import durable
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.files import Files
from pidpanel.provenance.results import damage_named, read_netcdf
from pidpanel.solve.bands import band_rms, whole_third_octaves
from pidpanel.solve.base_motion import BaseExcitation, supported_panel, with_translation
from pidpanel.sound.field_files import MODAL_FORCE, read_table
from pidpanel.sound.from_study import excitation_of, read_air, spectrum_of
from pidpanel.spectra.acceleration_table import read_base_table
from pidpanel.spectra.break_points import BreakPoints
from pidpanel.structure.from_study import read_moved_panel, studied
from pidpanel.study import Scenario, Study, StudyError
from pidpanel.study.dampers import COUPLED, BedDamper


def coupled_scenarios(study: Study) -> dict[str, CoupledScenario]:
    """Return the scenarios of a study that are run, by their labels."""
    keys = study.damping.coupled
    return {
        scenario.label: CoupledScenario(
            scenario.label,
            1.0
            if scenario.oaspl_db is None
            else spectrum_of(study.acoustics).pressure_factor(scenario.oaspl_db),
            tuple(
                SimulatedPatch(
                    patch,
                    coupon.particles.youngs_modulus,
                    tuple(
                        bed_of(coupon, fill, cells=keys.cells, seed=run + 1)
                        for run in range(keys.runs)
                    ),
                )
                for patch, coupon, fill in _beds_of(study, scenario)
            ),
            _given_dampers(study, scenario),
        )
        for scenario in study.coupled_scenarios()
    }


def _beds_of(
    study: Study, scenario: Scenario, model: str = COUPLED
) -> Iterator[tuple[str, BedDamper, float]]:
    """Yield the patches of a scenario with a damping model, with their beds and fills."""
    for patch, filling in scenario.fillings.items():
        damper, fill = study.damper_in(scenario, patch), filling.fill_fraction
        if isinstance(damper, BedDamper) and damper.model == model and fill is not None:
            yield patch, damper, fill


def _given_dampers(study: Study, scenario: Scenario) -> dict[str, FilledDamper]:
    """Return the dampers of the other patches."""
    integrated = [patch for patch, *_ in _beds_of(study, scenario)]
    dampers = {}
    for patch, filling in scenario.fillings.items():
        if patch not in integrated:
            model = with_mass_of(study, damper_model(study.damper_in(scenario, patch)))
            dampers[patch] = FilledDamper(str(filling.damper), model, filling.fill_fraction)
    return dampers


def depends_on(study: Study, label: str) -> dict[str, Any]:
    """Return the values of a study on which the runs of a scenario depend."""
    (scenario,) = (s for s in study.coupled_scenarios() if s.label == label)
    dampers = {str(filling.damper) for filling in scenario.fillings.values()}
    unused = {"sweep", "accuracy", "prior", "like"}
    response = {"frequency_hz", "damper_mass", "radiation", "air_mass"}
    values = {
        "scenario": scenario.model_dump(),
        "coupled": study.damping.coupled.model_dump(),
        "dampers": [study.dampers[name].model_dump(exclude=unused) for name in sorted(dampers)],
        "damping_ratio": study.panel.damping_ratio,
        **_excitation_values(study),
        "response": study.response.model_dump(include=response),
    }
    return dict(_without_errors(values))


def _without_errors(values: Any) -> Any:
    """Return values without the standard errors of inputs, on which no run depends."""
    if isinstance(values, Mapping) and values.get("law") == "constant" and "value" in values:
        return float(values["value"])  # of a restitution
    if isinstance(values, Mapping):
        return {key: _without_errors(item) for key, item in values.items() if key != "error"}
    if isinstance(values, list | tuple):
        return [_without_errors(item) for item in values]
    return float(values) if isinstance(values, float) else values


def _excitation_values(study: Study) -> dict[str, Any]:
    if study.sound is not None:
        return {"sound": study.sound.model_dump()}
    return {"base": study.base and study.base.model_dump(include={"random"})}


def _random_motion(study: Study) -> BreakPoints:
    """Return the acceleration PSD of the supports within the response [(m/s²)²/Hz]."""
    if study.base is None or study.base.random is None:
        raise StudyError(f"{study.name}: base.random: missing; coupled runs need it without sound")
    table = read_base_table(study.base.random.spectrum).segment(*study.response.frequency_hz)
    return replace(table, psd=STANDARD_GRAVITY**2 * table.psd)


def read_excited_panel(study: Study, files: Files) -> ExcitedPanel:
    """Read the files of the stages upstream."""
    keys, motion = study.damping.coupled, None if study.sound else _random_motion(study)
    span = study.response.frequency_hz
    low, high = span if motion is None else motion.frequency[[0, -1]].tolist()
    settings = RunSettings(
        frequency_range=(low, high),
        damping_ratio=study.panel.modal_damping,
        wave_speed=study.wave_speed,
        duration=keys.duration_s,
        settling=keys.settle_s,
        stations=keys.stations,
        cells=keys.cells,
        youngs_modulus=None if keys.youngs_modulus_mpa is None else 1e6 * keys.youngs_modulus_mpa,
        attributes=stamp(study),
    )
    if motion is not None:
        basis, plate, translation = read_moved_panel(study, files)
        mass = studied(study.panel).section.mass_per_area * basis.quadrature_weight.sum()
        none = np.zeros((len(plate.shapes), 0))
        supported = supported_panel(basis, plate, none, span[1], float(mass), translation)
        moving = with_translation(supported.basis, supported.inertia)
        excitation = BaseExcitation.of_inertia(motion, supported.inertia)
        further = excitation, None, translation
        return ExcitedPanel(settings, moving, plate, supported.vectors, *further)
    basis, plate = read_basis(files.modes), read_plate(files.plate)
    table = read_table(files.modal_force, MODAL_FORCE)
    shapes, sound = plate.shapes.astype(np.float64), excitation_of(study.acoustics, table)
    air = read_air(study, table, files.get("air"))
    return ExcitedPanel(settings, basis, plate, shapes, sound, air)


def write_scenario(
    study: Study, files: Files, label: str, store: Path, folder: Path, output: Path
) -> None:
    """Integrate runs of a scenario until its rms accelerations are known, and write the estimate.

    For the folders ``store`` and ``folder`` see `ScenarioRuns`; a `SolverFailure` is that of
    `ScenarioRuns.record`.
    """
    scenario, keys = coupled_scenarios(study)[label], study.damping.coupled
    basis = read_basis(files.modes)
    check_modes(study, float(basis.natural_frequency[~basis.is_residual].min(initial=np.inf)))
    runs = ScenarioRuns(read_excited_panel(study, files), scenario, store, folder)
    folder.mkdir(parents=True, exist_ok=True)
    records: list[SettledRecord] = []
    for number in range(1, keys.runs + 1):
        records.append(runs.record(number))
        estimate = runs.estimate(records)
        if estimate.reducible_error.max() <= keys.relative_error:
            break
    masses = np.mean([runs.masses(number + 1) for number in range(len(records))], axis=0)
    beds = [
        SimulatedBed(patch.name, patch.beds[0].packing.cell_area, float(mass), float(soft.modulus))
        for patch, mass, soft in zip(scenario.patches, masses, runs.softened, strict=True)
    ]
    points = runs.excited.basis.point_names
    write_estimate(output, estimate, beds, points, len(records), stamp(study))


def check_modes(study: Study, first: float) -> None:
    """Refuse a panel whose first mode [Hz] is above the response: its runs do not close in energy.

    Raises
    ------
    StudyError
    """
    high = study.response.frequency_hz[1]
    if first > high:
        message = f"coupled runs need a mode of the panel below {high:g} Hz, the "
        message += f"highest of response.frequency_hz; the first is at {first:.4g} Hz"
        raise StudyError(f"{study.name}: dampers: {message}")


def estimated_cpu_seconds(study: Study, scenarios: Sequence[Scenario] | None = None) -> float:
    """Return about the CPU time of the coupled runs of a study [s].

    With one run of each scenario and the modulus of a usual motion. ``scenarios`` are others whose
    beds, now of the atlas, would be coupled.
    """
    keys, seconds = study.damping.coupled, 0.0
    interval = 1 / (INTERVALS_PER_PERIOD * study.response.frequency_hz[1])
    model = COUPLED if scenarios is None else "atlas"
    for scenario in study.coupled_scenarios() if scenarios is None else scenarios:
        spheres, steps = [], []
        for _, damper, fill in _beds_of(study, scenario, model):
            packing = bed_of(damper, fill, cells=keys.cells, seed=1).packing
            modulus = 1e6 * (keys.youngs_modulus_mpa or 0.0)
            modulus = modulus or usual_modulus(damper.particles.youngs_modulus, packing.density)
            steps.append(STEP_RAYLEIGH * packing.smallest(modulus).rayleigh_time)
            spheres.append(round(spheres_in(packing, fill)))
        if steps:
            substeps = max(1, int(interval / min(steps)))
            cost = sum(cpu_per_interval(count, substeps) for count in spheres)
            length = min(interval, substeps * min(steps))
            seconds += (keys.settle_s + keys.duration_s) / length * cost
    return seconds


def write_coupled(study: Study, estimates: Sequence[Path], outputs: Files) -> None:
    """Write the tables of all scenarios, from the estimates of `coupled_scenarios` in order."""
    frames = []
    for scenario, path in zip(study.coupled_scenarios(), estimates, strict=True):
        with damage_named(path):  # such as by an older version
            frames.append(estimate_tables(scenario.label, read_netcdf(path)))
    for name in frames[0]:
        table = pd.concat([tables[name] for tables in frames])
        table.to_csv(outputs.all[name][0], index=False, float_format="%.6g")


DECIBEL = 10 / np.log(10)  # dB of ln of a mean square


class SimulatedBed(NamedTuple):
    """The simulated bed of a patch."""

    patch: str
    cell_area: float  # of a cell [m²]
    mass_per_area: float  # of the particles [kg/m²]
    modulus: float  # Young's modulus of the contacts [Pa]


def write_estimate(
    path: Path,
    estimate: ScenarioEstimate,
    beds: Sequence[SimulatedBed],
    points: Sequence[str],
    runs: int,
    attributes: Mapping[str, str],
) -> None:
    """Write the estimate of a scenario from its runs to a ``.nc`` file."""
    dataset = xr.Dataset(
        {**_patch_variables(estimate, beds), **_point_variables(estimate)},
        coords={
            "band": variable("band", estimate.centre, "Hz"),
            "frequency": variable("frequency", estimate.frequency, "Hz"),
            "patch": ("patch", [bed.patch for bed in beds]),
            "point": ("point", list(points)),
        },
        attrs={**attributes, "runs": runs},
    )
    with durable.replacing(path) as draft:
        dataset.to_netcdf(draft, engine="scipy")


def _patch_variables(estimate: ScenarioEstimate, beds: Sequence[SimulatedBed]) -> dict[str, Any]:
    """Return values by patch, and by patch and band."""
    rows = [
        {
            "impedance_frequency": (patch.impedance.frequency, "Hz"),
            "equivalent_damping": (patch.impedance.value.real, "N s m-3"),
            "equivalent_damping_error": (patch.equivalent_damping_error, "N s m-3"),
            "apparent_mass": (patch.impedance.apparent_mass, "kg m-2"),
            "apparent_mass_error": (patch.apparent_mass_error, "kg m-2"),
            "own_force_psd": (patch.own_force.psd, "Pa2 Hz-1"),
            "own_force_coherence": (patch.own_force.coherence, "1"),
            "own_force_error": (patch.own_force_error, "1"),
            "own_force_length": (patch.own_force.length, "m Hz"),
            "cell_area": (bed.cell_area, "m2"),
            "common_error": (patch.common_error, "1"),
            "mass_per_area": (bed.mass_per_area, "kg m-2"),
            "youngs_modulus": (bed.modulus, "Pa"),
        }
        for patch, bed in zip(estimate.patches, beds, strict=True)
    ]
    variables = {}
    for name, (_, units) in rows[0].items():
        values = np.array([row[name][0] for row in rows], dtype=np.float64)
        variables[name] = variable("patch band" if values.ndim == 2 else "patch", values, units)
    return variables


def _point_variables(estimate: ScenarioEstimate) -> dict[str, Any]:
    """Return values by point, and by point and line or band."""
    lines, bands = "frequency point", "band point"
    return {
        "displacement_psd": variable(lines, estimate.psd, "m2 Hz-1"),
        "linear_displacement_psd": variable(lines, estimate.linear_psd, "m2 Hz-1"),
        "displacement_psd_log_error": variable(lines, estimate.log_psd_error, "1"),
        "band_log_error": variable(bands, estimate.log_band_error, "1"),
        "band_residual": variable(bands, estimate.band_residual, "1"),
        "log_error": variable("point", estimate.log_error, "1"),
        "residual": variable("point", estimate.residual, "1"),
        "recorded": variable("point", estimate.recorded, "m2 s-4"),
        "excess_kurtosis": variable("point", estimate.bursts.kurtosis, "1"),
        "excess_kurtosis_error": variable("point", estimate.bursts.kurtosis_error, "1"),
        "log_damage": variable("exponent point", estimate.bursts.damage, "1"),
        "log_damage_error": variable("exponent point", estimate.bursts.damage_error, "1"),
    }


def estimate_tables(scenario: str, stored: xr.Dataset) -> dict[str, pd.DataFrame]:
    """Return the tables of a scenario by name; units as in the names of the columns."""
    frequency = stored["frequency"].to_numpy()
    scale = ((2 * np.pi * frequency) ** 4 / STANDARD_GRAVITY**2)[:, None]
    names = ("displacement_psd", "linear_displacement_psd")
    psd, linear = (scale * stored[name].to_numpy() for name in names)
    centre, edge = whole_third_octaves(frequency[0], frequency[-1])
    squares, linear_squares = (np.trapezoid(v, frequency, axis=0) for v in (psd, linear))
    points = [str(name) for name in stored["point"].to_numpy()]
    g_rms = np.sqrt(squares)
    recorded = np.sqrt(stored["recorded"].to_numpy()) / STANDARD_GRAVITY
    summary = pd.DataFrame(
        {
            "scenario": scenario,
            "point": points,
            "g_rms": g_rms,
            "g_rms_error": g_rms * stored["log_error"].to_numpy() / 2,
            "linear_g_rms": np.sqrt(linear_squares),
            "recorded_g_rms": recorded,
            "residual_db": DECIBEL * stored["residual"].to_numpy(),
            "excess_kurtosis": stored["excess_kurtosis"].to_numpy(),
            "excess_kurtosis_error": stored["excess_kurtosis_error"].to_numpy(),
            **{f"{name}_{b}": stored[name].to_numpy()[row] for row, b in enumerate(EXPONENTS)
               for name in ("log_damage", "log_damage_error")},
            "runs": int(stored.attrs["runs"]),
        }
    )  # fmt: skip

    def long_table(axis: Array, columns: Mapping[str, Array]) -> pd.DataFrame:
        names = ["scenario", "point", "frequency_hz"]
        index = pd.MultiIndex.from_product([[scenario], points, axis], names=names)
        values = {name: array.T.ravel() for name, array in columns.items()}
        return pd.DataFrame(values, index).reset_index()

    third_octaves = {
        "g_rms": band_rms(frequency, psd, edge),
        "error_db": DECIBEL * stored["band_log_error"].to_numpy(),
        "residual_db": DECIBEL * stored["band_residual"].to_numpy(),
    }
    lines = {
        "acceleration_psd_g2_hz": psd,
        "error_db": DECIBEL * stored["displacement_psd_log_error"].to_numpy(),
        "linear_acceleration_psd_g2_hz": linear,
    }
    return {
        "summary": summary,
        "third_octaves": long_table(centre, third_octaves),
        "psd": long_table(frequency, lines),
        "impedance": _impedance(scenario, stored),
    }


# Columns of the table whose names do not follow from those in the file of an estimate.
RENAMED = {
    "impedance_frequency": "frequency_hz",
    "mass_per_area": "particle_mass_per_area_kg_m2",
    "youngs_modulus": "youngs_modulus_mpa",
}


def _impedance(scenario: str, stored: xr.Dataset) -> pd.DataFrame:
    """Return what is known of patches by band; names of the columns end with the unit."""
    values = stored[[name for name in stored.data_vars if stored[name].dims[0] == "patch"]]
    rows = values.to_dataframe(["patch", "band"]).reset_index()
    names = {
        str(name): f"{name}_{_suffix(variable.attrs['units'])}"
        for name, variable in values.variables.items()
        if variable.attrs.get("units", "1") != "1"
    }
    rows = rows.rename(columns=names | RENAMED)
    rows["youngs_modulus_mpa"] /= 1e6
    rows.insert(0, "scenario", scenario)
    return rows


def _suffix(unit: str) -> str:
    """Return ``n_s_m3`` of ``N s m-3``, and ``pa2_hz`` of ``Pa2 Hz-1``."""
    return unit.lower().replace("-1", "").replace("-", "").replace(" ", "_")
