"""Base motion of a study: the only module of the stage that reads it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array
from pidpanel.base import tables
from pidpanel.base.notching import Limit
from pidpanel.base.random import random_cases
from pidpanel.base.sine import interface_force, sweep
from pidpanel.base.spectrum import BaseSpectrum
from pidpanel.base.supports import (
    BaseExcitation,
    Inertia,
    inertia_of,
    observed_motions,
    with_translation,
)
from pidpanel.base.table import read_base_table
from pidpanel.base.transfer import Transfer
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.basis_files import read_basis
from pidpanel.panel.eigen import factors
from pidpanel.panel.modes import SHIFT
from pidpanel.panel.plate_files import StoredPlate, read_plate
from pidpanel.provenance.digests import stamp
from pidpanel.response.cases import (
    ResponseScenario,
    heaviest_dampers,
    plan_cases,
    resolving,
)
from pidpanel.response.dampers import DampingModels, PatchFilling
from pidpanel.response.from_study import damping_models, read_panel_mass
from pidpanel.response.panel import ResponsePanel, Settings
from pidpanel.response.refinement import read_further_shapes
from pidpanel.response.results import write_csv
from pidpanel.solve.basis_error import MovedFace, basis_shapes, refined
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.moved import Matrices
from pidpanel.sound.radiation import Air
from pidpanel.study import Study
from pidpanel.study.base_motion import BaseMotion
from pidpanel.study.scenarios import level_suffix


class BaseInputs(NamedTuple):
    """Files of the stages upstream."""

    modes: Path
    plate: Path
    section: Path
    further_shapes: Path  # ``response/left_out.nc``


class BaseFiles(NamedTuple):
    """The files of the stage; those of a motion that the study does not have are None."""

    modes_csv: Path
    psd_nc: Path | None
    summary_csv: Path | None
    notched_csv: Path | None
    notches_csv: Path | None
    sine_nc: Path | None
    sine_csv: Path | None


@dataclass(frozen=True)
class SupportedPanel:
    """The panel on its supports, in a basis with the static response to their acceleration."""

    basis: PanelBasis  # without the translation
    inertia: Inertia


@dataclass(frozen=True)
class Shaker:
    """The source of base motion; see `response.panel.ExcitationSource`. Its basis is final."""

    excitation: BaseExcitation

    def on_basis(self, basis: PanelBasis, air: Air | None) -> tuple[BaseExcitation, Air | None]:
        """Return the excitation, which holds for its own basis."""
        return self.excitation, air

    def force_at(self, frequency: float, face: MovedFace) -> Matrices:
        """Refuse: the force of base motion is one of the mass, not of a pressure on the face."""
        raise NotImplementedError("base motion has no pressure on the face")


def supported_panel(
    basis: PanelBasis, plate: StoredPlate, further_shapes: Array, highest: float, mass: float
) -> SupportedPanel:
    """Return the panel in the basis of its responses, with K⁻¹ M 1 beside it.

    Parameters
    ----------
    further_shapes
        (n_free, k) what the response stage added to the basis.
    highest
        Highest frequency [Hz].
    mass
        Of the panel with attached masses [kg].
    """
    shift = (2 * np.pi * SHIFT * highest) ** 2  # a panel on hinges in a line has a singular K
    static = factors(plate.stiffness + shift * plate.mass).solve(plate.inertia)
    shapes = basis_shapes(basis, plate, np.column_stack([further_shapes, static]))
    wider = refined(basis, plate, shapes)
    return SupportedPanel(wider, inertia_of(wider, plate, shapes.vectors, mass))


def base_scenarios(study: Study) -> list[ResponseScenario]:
    """Return the scenarios of a study, once for each layout: they have no sound level."""
    layouts: dict[tuple[PatchFilling, ...], ResponseScenario] = {}
    for scenario in study.all_scenarios():
        fillings = tuple(
            PatchFilling(filling.patch, filling.damper, filling.fill_fraction)
            for filling in scenario.fillings
        )
        label = scenario.label.removesuffix(level_suffix(scenario.oaspl_db))
        layouts.setdefault(
            fillings,
            ResponseScenario(
                label, "bare", np.nan, 1.0, fillings, scenario.patch, scenario.fill_fraction
            ),
        )
    return list(layouts.values())


def limits_of(motion: BaseMotion, points: Sequence[str]) -> list[Limit]:
    """Return the limits of a study in SI, by the places of the points and then the interface."""
    if motion.limits is None:
        return []
    g, limits = STANDARD_GRAVITY, []
    for name, limit in motion.limits.points.items():
        place = list(points).index(name)
        if limit.psd_g2_hz is not None:
            says = f"point {name}: {limit.psd_g2_hz:g} g²/Hz"
            limits.append(Limit(place, says, limit.psd_g2_hz * g**2))
        if limit.rms_g is not None:
            says = f"point {name}: {limit.rms_g:g} g rms"
            limits.append(Limit(place, says, limit.rms_g * g, is_rms=True))
    force = motion.limits.force
    if force is not None and force.psd_n2_hz is not None:
        says = f"interface: {force.psd_n2_hz:g} N²/Hz"
        limits.append(Limit(len(points), says, force.psd_n2_hz))
    if force is not None and force.rms_n is not None:
        says = f"interface: {force.rms_n:g} N rms"
        limits.append(Limit(len(points), says, force.rms_n, is_rms=True))
    return limits


def response_panel(
    study: Study,
    supported: SupportedPanel,
    spectrum: BaseSpectrum,
) -> ResponsePanel:
    """Return the panel under a random motion of its supports [g²/Hz], in vacuum."""
    inertia = supported.inertia
    level = replace(spectrum, psd=STANDARD_GRAVITY**2 * spectrum.psd)
    excitation = BaseExcitation.of_inertia(level, inertia)
    settings = Settings(
        (float(spectrum.frequency[0]), float(spectrum.frequency[-1])),
        study.panel.modal_damping,
        stated_acceleration_g=study.damping.level.acceleration_g,
    )
    basis = with_translation(supported.basis, inertia)
    return ResponsePanel(settings, basis, excitation, Shaker(excitation))


def write_base(study: Study, files: BaseInputs, damping: Path | None, output: BaseFiles) -> None:
    """Write responses to the motion of the supports in every scenario with every damping model.

    Parameters
    ----------
    damping
        Folder of the surfaces, ``results/<study>/damping``; None for a study without any.

    Raises
    ------
    ValueError
        If the study has no base motion.
    """
    motion = study.base
    if motion is None:
        raise ValueError(f"{study.name}: no section base")
    plate = read_plate(files.plate)
    supported = supported_panel(
        read_basis(files.modes), plate, read_further_shapes(files.further_shapes),
        study.response.frequency_hz[1], read_panel_mass(study, files.section),
    )  # fmt: skip
    write_csv(output.modes_csv, tables.mode_rows(supported.basis, supported.inertia))
    models, scenarios = damping_models(study, damping), base_scenarios(study)
    if motion.random is not None:
        _write_random(study, motion, supported, scenarios, models, output)
    if motion.sine is not None and output.sine_nc and output.sine_csv:
        cases = _sine_cases(study, supported, scenarios, models)
        labels = [scenario.label for scenario in scenarios]
        points = supported.basis.point_names
        rows = tables.sine_rows(cases, points, motion.sine.acceleration_g)
        write_csv(output.sine_csv, rows)
        curves = tables.sine_dataset(cases, models.names, labels, points)
        attributes = {**stamp(study), "acceleration_g": motion.sine.acceleration_g}
        curves.assign_attrs(attributes).to_netcdf(output.sine_nc, engine="scipy")


def _write_random(
    study: Study,
    motion: BaseMotion,
    supported: SupportedPanel,
    scenarios: Sequence[ResponseScenario],
    models: DampingModels,
    output: BaseFiles,
) -> None:
    if motion.random is None or output.psd_nc is None or output.summary_csv is None:
        raise ValueError(f"{study.name}: no files for base.random")
    spectrum = read_base_table(motion.random.spectrum).between(*study.response.frequency_hz)
    panel = response_panel(study, supported, spectrum)
    plan = plan_cases(panel, scenarios, models, dead_weight=False)
    panel = resolving(panel, heaviest_dampers(panel, plan))
    points = list(supported.basis.point_names)
    limits = limits_of(motion, points)
    observed = observed_motions(panel.basis, supported.inertia)
    cases = random_cases(panel, observed, scenarios, models, limits)
    write_csv(output.summary_csv, tables.summary_rows(cases, points))
    labels = [scenario.label for scenario in scenarios]
    curves = tables.random_dataset(cases, models.names, labels, points)
    curves.assign_attrs(stamp(study)).to_netcdf(output.psd_nc, engine="scipy")
    if limits and output.notched_csv and output.notches_csv:
        write_csv(output.notched_csv, tables.input_rows(cases, limits))
        write_csv(output.notches_csv, tables.notch_rows(cases, limits))


def _sine_cases(
    study: Study,
    supported: SupportedPanel,
    scenarios: Sequence[ResponseScenario],
    models: DampingModels,
) -> list[tables.SineCase]:
    """Return every scenario with every damping model in a sweep up and one down."""
    sine = study.base.sine if study.base else None
    if sine is None:
        return []
    low, high = sine.frequency_hz
    flat = BaseSpectrum(np.array([low, high]), np.ones(2))
    panel = response_panel(study, supported, flat)
    plan = plan_cases(panel, scenarios, models, dead_weight=False)
    panel = resolving(panel, heaviest_dampers(panel, plan))
    observed = observed_motions(panel.basis, supported.inertia)
    force = BaseExcitation.of_inertia(flat, supported.inertia).force
    modes = panel.basis.natural_frequency[~panel.basis.is_residual]
    f = frequency_grid(low, high, panel.resolved_ratio, modes)
    amplitude = sine.acceleration_g * STANDARD_GRAVITY
    cases = []
    for scenario, model, dampers in plan.rows:
        loads = [damper.load for damper in dampers]
        patches = [damper.carrier for damper in dampers]
        transfer = Transfer.of_panel(
            f, panel.modal, panel.patches.subset(patches), force,
            observed.reshape(-1, observed.shape[2]),
        )  # fmt: skip
        sweeps = [
            sweep(
                transfer, loads, sine.acceleration_g, study.damping.level.acceleration_g, down=down
            )
            for down in (False, True)
        ]
        motion = np.array([each.motion.reshape(f.size, *observed.shape[:2]) for each in sweeps])
        pull = [
            interface_force(f, part[:, -1], patches, each.stiffness)
            for part, each in zip(motion, sweeps, strict=True)
        ]
        omega = 2 * np.pi * f[:, None]
        cases.append(
            tables.SineCase(
                scenario.label, model, f,
                amplitude * omega**2 * np.abs(motion[:, :, :-1, 0]),
                amplitude * np.abs(motion[:, :, :-1, 1]),
                amplitude * np.abs(np.array(pull)),
                                max(float(each.residual.max()) for each in sweeps),
            )
        )  # fmt: skip
    return cases
