"""The coupled runs of a study: the only module of the stage that knows it."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupled import estimate_files
from pidpanel.coupled.beds import cpu_per_interval
from pidpanel.coupled.excited_panel import ExcitedPanel
from pidpanel.coupled.scenario import CoupledScenario, GivenDamper, RunSettings, SimulatedPatch
from pidpanel.coupled.scenario_runs import INTERVALS_PER_PERIOD, STEP_RAYLEIGH, ScenarioRuns
from pidpanel.coupled.segments import SettledRecord
from pidpanel.coupled.softening import usual_modulus
from pidpanel.coupon.estimate import spheres_in
from pidpanel.coupon.from_study import bed_of
from pidpanel.damping.from_study import reading_of_damper
from pidpanel.panel.files import read_basis, read_plate
from pidpanel.panel.from_study import StudiedPanel
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.job import Files
from pidpanel.solve.supports import BaseExcitation, supported_panel, with_translation
from pidpanel.sound.field_files import MODAL_FORCE, read_table
from pidpanel.sound.from_study import excitation_of, read_air, spectrum_of
from pidpanel.spectra.acceleration_table import read_base_table
from pidpanel.spectra.break_points import BreakPoints
from pidpanel.study import Filling, Study, StudyError


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
                    filling.patch,
                    coupon.particles.youngs_modulus,
                    tuple(
                        bed_of(coupon, fill, cells=keys.cells, seed=run + 1)
                        for run in range(keys.runs)
                    ),
                )
                for filling, coupon, fill in study.beds_of(scenario)
            ),
            tuple(
                _given_damper(study, filling)
                for filling in scenario.fillings
                if study.all_dampers[str(filling.damper)].coupon is None
            ),
        )
        for scenario in study.coupled_scenarios()
    }


def _given_damper(study: Study, filling: Filling) -> GivenDamper:
    model = reading_of_damper(study.all_dampers[str(filling.damper)], None)
    if not study.response.damper_mass:
        model = model.without_mass()
    return GivenDamper(filling.patch, model, filling.fill_fraction or 1.0)


def depends_on(study: Study, label: str) -> dict[str, Any]:
    """Return the values of a study on which the runs of a scenario depend."""
    (scenario,) = (s for s in study.coupled_scenarios() if s.label == label)
    dampers = {str(filling.damper) for filling in scenario.fillings}
    unused = {"coupon": {"sweep", "accuracy"}}
    response = {"frequency_hz", "damper_mass", "radiation", "air_mass"}
    return {
        "scenario": scenario.model_dump(),
        "coupled": study.damping.coupled.model_dump(),
        "dampers": [study.all_dampers[name].model_dump(exclude=unused) for name in sorted(dampers)],
        "damping_ratio": study.panel.damping_ratio,
        **_excitation_values(study),
        "response": study.response.model_dump(include=response),
    }


def _excitation_values(study: Study) -> dict[str, Any]:
    if study.sound is not None:
        return {"sound": study.sound.model_dump()}
    return {"base": study.base and study.base.model_dump(include={"random"})}


def _random_motion(study: Study) -> BreakPoints:
    """Return the acceleration PSD of the supports within the response [(m/s²)²/Hz]."""
    if study.base is None or study.base.random is None:
        raise StudyError(f"{study.name}: base.random: missing; coupled runs need it without sound")
    table = read_base_table(study.base.random.spectrum).between(*study.response.frequency_hz)
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
    basis, plate = read_basis(files.modes), read_plate(files.plate)
    if motion is not None:
        mass = StudiedPanel(study.panel).section.mass_per_area * basis.quadrature_weight.sum()
        none = np.zeros((len(plate.shapes), 0))
        supported = supported_panel(basis, plate, none, span[1], float(mass))
        moving = with_translation(supported.basis, supported.inertia)
        excitation = BaseExcitation.of_inertia(motion, supported.inertia)
        return ExcitedPanel(settings, moving, plate, supported.vectors, excitation, None)
    table = read_table(files.modal_force, MODAL_FORCE)
    shapes, sound = plate.shapes.astype(np.float64), excitation_of(study.acoustics, table)
    air = read_air(study, study.response.radiation, table, files.get("air"))
    return ExcitedPanel(settings, basis, plate, shapes, sound, air)


def write_scenario(
    study: Study, files: Files, label: str, store: Path, folder: Path, output: Path
) -> None:
    """Integrate runs of a scenario until its rms accelerations are known, and write the estimate.

    For the folders ``store`` and ``folder`` see `ScenarioRuns`; a `SolverFailure` is that of
    `ScenarioRuns.record`.
    """
    scenario, keys = coupled_scenarios(study)[label], study.damping.coupled
    runs = ScenarioRuns(read_excited_panel(study, files), scenario, store, folder)
    folder.mkdir(parents=True, exist_ok=True)
    records: list[SettledRecord] = []
    for number in range(1, keys.runs + 1):
        records.append(runs.record(number))
        estimate = runs.estimate(records)
        # further runs do not reduce the bias
        error = np.sqrt(np.maximum((estimate.log_error / 2) ** 2 - runs.bias**2, 0))
        if error.max() <= keys.relative_error:
            break
    masses = np.mean([runs.masses(number + 1) for number in range(len(records))], axis=0)
    beds = [
        estimate_files.SimulatedBed(
            patch.name, patch.beds[0].packing.cell_area, float(mass), float(soft.modulus)
        )
        for patch, mass, soft in zip(scenario.patches, masses, runs.softened, strict=True)
    ]
    points = runs.excited.basis.point_names
    estimate_files.write_estimate(output, estimate, beds, points, len(records), stamp(study))


def estimated_cpu_seconds(study: Study) -> float:
    """Return about the CPU time of the coupled runs of a study [s].

    With one run of each scenario and the modulus of a usual motion.
    """
    keys, seconds = study.damping.coupled, 0.0
    interval = 1 / (INTERVALS_PER_PERIOD * study.response.frequency_hz[1])
    for scenario in coupled_scenarios(study).values():
        spheres, steps = [], []
        for patch in scenario.patches:
            packing = patch.beds[0].packing
            modulus = usual_modulus(patch.youngs_modulus, packing.density)
            if keys.youngs_modulus_mpa is not None:
                modulus = 1e6 * keys.youngs_modulus_mpa
            steps.append(STEP_RAYLEIGH * packing.smallest(modulus).rayleigh_time)
            spheres.append(round(spheres_in(packing, patch.beds[0].fill_fraction)))
        substeps = max(1, int(interval / min(steps)))
        cost = sum(cpu_per_interval(count, substeps) for count in spheres)
        seconds += keys.run_s / (substeps * min(steps)) * cost
    return seconds


def write_coupled(study: Study, estimates: Sequence[Path], outputs: Files) -> None:
    """Write the tables of all scenarios, from the estimates of `coupled_scenarios` in order."""
    frames = [
        estimate_files.frames(scenario.label, xr.load_dataset(path, engine="scipy"))
        for scenario, path in zip(study.coupled_scenarios(), estimates, strict=True)
    ]
    for name in frames[0]:
        table = pd.concat([tables[name] for tables in frames])
        table.to_csv(outputs.all[name][0], index=False, float_format="%.6g")
