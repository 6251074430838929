"""Base motion of a study: the only module of the stage that reads it."""

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from pidpanel.arrays import Array, Complexes
from pidpanel.base import tables
from pidpanel.base.basis_check import checked_panel
from pidpanel.base.random import Limit, random_cases
from pidpanel.base.sine import (
    SineSweep,
    Transfer,
    damping_errors,
    interface_force,
    sweep,
    sweep_errors,
)
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.panel.files import read_basis
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.files import Files
from pidpanel.provenance.results import read_csv
from pidpanel.response.cases import (
    Loads,
    ResponseScenario,
    attached,
    heaviest_dampers,
    loads_of,
    resolve,
)
from pidpanel.response.exports import write_base_exports
from pidpanel.response.from_study import (
    DamperOf,
    dampers_of_scenarios,
    not_read,
    read_panel_mass,
    scenario_of,
)
from pidpanel.response.model_error import read_errors
from pidpanel.response.panel import ResponsePanel, Settings, WaveShift
from pidpanel.response.psd_files import read_psd
from pidpanel.response.refinement import mesh_shifts
from pidpanel.response.results import write_csv
from pidpanel.solve.base_motion import (
    BaseExcitation,
    Inertia,
    SupportedPanel,
    observed_motions,
    with_translation,
)
from pidpanel.solve.layout import AttachedDamper
from pidpanel.solve.mesh_error import mesh_error
from pidpanel.spectra.acceleration_table import read_base_table
from pidpanel.spectra.break_points import BreakPoints
from pidpanel.structure.from_study import read_moved_panel, studied
from pidpanel.study import Study
from pidpanel.study.base_motion import BaseMotion, SineMotion


@dataclass(frozen=True)
class Shaker:
    """A random motion of the supports of a panel in vacuum."""

    settings: Settings  # of the panel; its frequencies are those of the spectrum
    spectrum: BreakPoints  # [g²/Hz]
    mass_per_area: float  # of the panel, without dampers [kg/m²]
    wave_shift: WaveShift  # see `ResponsePanel`
    point_refinement_error: Array | float  # (n_points,) see `StudiedPanel`

    def panel(self, supported: SupportedPanel) -> ResponsePanel:
        """Return a panel under the motion."""
        inertia = supported.inertia
        level = replace(self.spectrum, psd=STANDARD_GRAVITY**2 * self.spectrum.psd)
        low, high = self.spectrum.frequency[[0, -1]].tolist()
        return ResponsePanel(
            replace(self.settings, frequency_range=(low, high)),
            with_translation(supported.basis, inertia),
            BaseExcitation.of_inertia(level, inertia),
            self.mass_per_area,
            self.wave_shift,
            self.point_refinement_error,
        )

    def panel_with(
        self, supported: SupportedPanel, scenarios: Sequence[ResponseScenario]
    ) -> ResponsePanel:
        """Return the panel with lines for the resonances that the dampers of scenarios make."""
        panel = self.panel(supported)
        return resolve(panel, heaviest_dampers(panel, scenarios))


def base_scenarios(study: Study, damper_of: DamperOf = not_read) -> list[ResponseScenario]:
    """Return the scenarios of a study, once for each layout: they have no sound level."""
    labels = base_labels(study)
    layouts: dict[str, ResponseScenario] = {}
    for scenario in study.all_scenarios():
        label = labels[scenario.label]
        if label not in layouts:
            layouts[label] = scenario_of(study, scenario, label, damper_of)
    return list(layouts.values())


def base_labels(study: Study) -> dict[str, str]:
    """Return the label under base motion of every scenario: that of the first with its layout."""
    labels: dict[tuple[Any, ...], str] = {}
    return {
        scenario.label: labels.setdefault(
            (scenario.steady_acceleration_g, *scenario.fillings.items()), scenario.layout_label
        )
        for scenario in study.all_scenarios()
    }


def limits_of(motion: BaseMotion, points: Sequence[str]) -> list[Limit]:
    """Return the limits of a study in SI, by the places of the points and then the interface."""
    if motion.notching is None:
        return []
    g, force, stated = STANDARD_GRAVITY, motion.notching.force, []
    for name, limit in motion.notching.points.items():
        place = list(points).index(name)
        stated.append((place, f"point {name}", limit.psd_g2_hz, "g²/Hz", g**2))
        stated.append((place, f"point {name}", limit.rms_g, "g rms", g))
    if force is not None:
        stated.append((len(points), "interface", force.psd_n2_hz, "N²/Hz", 1.0))
        stated.append((len(points), "interface", force.rms_n, "N rms", 1.0))
    return [
        Limit(place, f"{name}: {value:g} {unit}", value * factor, is_rms=unit.endswith("rms"))
        for place, name, value, unit, factor in stated
        if value is not None
    ]


def write_base(
    study: Study,
    files: Files,
    damping: Path | None,
    output: Files,
    coupled: Path | None = None,
) -> None:
    """Write responses to the motion of the supports in every scenario.

    Parameters
    ----------
    damping, coupled
        Folders of the surfaces and of the coupled runs on the moving supports; None without any.
    output
        Files by the names of the rule: those of the parts that the study has.

    Raises
    ------
    ValueError
        If the study has no base motion.
    """
    motion = study.base
    if motion is None:
        raise ValueError(f"{study.name}: no section base")
    scenarios = base_scenarios(study, dampers_of_scenarios(study, damping, coupled))
    shakers = shakers_of(study)

    def shaker_panels(supported: SupportedPanel) -> list[ResponsePanel]:
        return [shaker.panel_with(supported, scenarios) for shaker in shakers.values()]

    basis, plate, translation = read_moved_panel(study, files)
    supported, error = checked_panel(
        basis, plate, np.zeros((len(plate.shapes), 0)), study.response.frequency_hz[1],
        read_panel_mass(study, files.section), shaker_panels, scenarios, translation,
    )  # fmt: skip
    panels = dict(zip(shakers, shaker_panels(supported), strict=True))
    attributes = {**stamp(study), "basis_error": error}
    write_csv(output.modes_table, tables.mode_rows(supported.basis, supported.inertia))
    if motion.random is not None:
        panel = panels["random"]
        points, limits = panel.basis.point_names, limits_of(motion, panel.basis.point_names)
        observed = observed_motions(panel.basis, supported.inertia)
        errors = {}
        if coupled is not None:
            errors = read_errors(coupled, panel.frequency, points)
        random = random_cases(panel, observed, scenarios, limits, errors)
        labels = [scenario.label for scenario in scenarios]
        shifts = mesh_shifts(panel, scenarios)
        psds = tables.random_dataset(random, labels, points, shifts)
        write_csv(output.summary, tables.summary_rows(psds))
        write_csv(output.psd_table, tables.psd_rows(psds))
        psds.assign_attrs(attributes).to_netcdf(output.psd, engine="scipy")
        if limits:
            write_csv(output.notched, tables.input_rows(random, limits))
    if motion.sine is not None:
        of_tones = dampers_of_scenarios(study, damping, coupled, is_broadband=False)
        # the motion of coupled runs is no sine
        tones = [case for case in base_scenarios(study, of_tones) if not case.is_coupled]
        curves = _sweeps(panels["sine"], supported.inertia, motion.sine, tones)
        level = motion.sine.acceleration_g
        write_csv(output.sine_table, tables.peak_rows(curves, level))
        curves.assign_attrs(attributes, acceleration_g=level).to_netcdf(output.sine, engine="scipy")


def write_base_export(
    study: Study, modes: Path, psd_nc: Path, summary_csv: Path, folder: Path
) -> None:
    """Write the files for other programs of random motion; see `write_base_exports`."""
    summary = read_csv(summary_csv, dtype={"scenario": str, "doubts": str})
    psd, title = read_psd(psd_nc), f"pidpanel study {study.name}"
    write_base_exports(psd, summary, title, read_basis(modes).point_position, folder)


def shakers_of(study: Study) -> dict[str, Shaker]:
    """Return the motions of the supports: ``random``, and ``sine`` as one of a flat spectrum.

    Both within the frequencies of the response.
    """
    levels, motion = {}, study.base
    if motion is not None and motion.random is not None:
        table = read_base_table(motion.random.spectrum)
        levels["random"] = table.segment(*study.response.frequency_hz)
    if motion is not None and motion.sine is not None:
        levels["sine"] = BreakPoints(np.array(motion.sine.frequency_hz), np.ones(2))
    settings = Settings(
        study.response.frequency_hz,
        study.panel.modal_damping,
        stated_acceleration_g=study.damping.level.acceleration_g,
    )
    panel = studied(study.panel)
    near = panel.point_refinement_error(study.response.frequency_hz[1])
    mesh_terms = panel.section.mass_per_area, panel.wave_shift, near
    return {
        name: Shaker(replace(settings, jumps=level.jumps), level, *mesh_terms)
        for name, level in levels.items()
    }


def _sweeps(
    panel: ResponsePanel,
    inertia: Inertia,
    sine: SineMotion,
    scenarios: Sequence[ResponseScenario],
) -> xr.Dataset:
    """Return every scenario in a sweep up and one down."""
    observed = observed_motions(panel.basis, inertia)
    force = BaseExcitation.of_inertia(panel.excitation.spectrum, inertia).force
    shifts = mesh_shifts(panel, scenarios)
    results = {}
    for scenario in scenarios:
        loads = loads_of(panel, scenario)
        transfer = Transfer.of_panel(
            panel.frequency, panel.modal,
            panel.patches.subset([carrier for carrier, _ in loads]), force,
            observed.reshape(-1, observed.shape[2]),
        )  # fmt: skip
        for direction in tables.DIRECTIONS:
            values = _sweep(
                panel, transfer, observed.shape[:2], loads, sine, down=direction == "down"
            )
            if values is None:
                print(f"{scenario.label}: C_e is negative", file=sys.stderr)
                continue
            square = np.asarray(values["acceleration"]) ** 2
            shift = shifts[scenario.label]
            values["mesh_error"] = mesh_error(
                panel.frequency, square, np.ones(len(square)), shift, over_largest=True
            ).line
            results[scenario.label, direction] = values
    labels = [scenario.label for scenario in scenarios]
    place = {"scenario": labels, "direction": tables.DIRECTIONS}
    return tables.curves_dataset(results, panel.frequency, panel.basis.point_names, **place)


def _sweep(
    panel: ResponsePanel,
    transfer: Transfer,
    shape: tuple[int, ...],
    loads: Loads,
    sine: SineMotion,
    *,
    down: bool,
) -> dict[str, Array | float] | None:
    """Return amplitudes and their errors; None where C_e is negative."""
    f, stated_g = panel.frequency, panel.settings.stated_acceleration_g
    amplitude, omega = sine.acceleration_g * STANDARD_GRAVITY, 2 * np.pi * f[:, None]

    def respond(
        dampers: Sequence[AttachedDamper],
    ) -> tuple[SineSweep, Complexes, dict[str, Array]]:
        run = sweep(transfer, dampers, sine.acceleration_g, stated_g, down=down)
        motion = run.motion.reshape(f.size, *shape)
        reaction = interface_force(f, motion[:, -1], [d.patch for d in dampers], run.stiffness)
        acceleration = amplitude * omega**2 * np.abs(motion[:, :-1, 0])
        force = amplitude * np.abs(reaction)
        return run, motion, {"acceleration": acceleration, "interface_force": force}

    dampers = attached(loads)
    run, motion, values = respond(dampers)
    if np.any(run.stiffness.imag < 0):
        return None
    gammas = run.acceleration_g if stated_g is None else np.full((len(dampers), f.size), stated_g)
    errors = [
        damping_errors(damper, f, gamma) for (_, damper), gamma in zip(loads, gammas, strict=True)
    ]
    names = [damper.name for _, damper in loads]
    log_errors = sweep_errors(dampers, names, errors, lambda changed: respond(changed)[2])
    for name, value in tuple(values.items()):
        values[f"{name}_log_error"] = log_errors.get(name, np.full(value.shape, np.nan))
    return {
        **values,
        "relative_displacement": amplitude * np.abs(motion[:, :-1, 1]),
        "motion_residual": float(run.residual.max()),
    }
