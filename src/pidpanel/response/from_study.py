"""The response of a study: the only module of the stage that reads it.

Behind it are functions of data: `cases` solves, `results`, `mapping` and `exports` write.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.damping.coupled import read_coupled
from pidpanel.damping.from_study import dampers_of, tolerances_of, with_mass_of
from pidpanel.damping.laws import ConstantDamper
from pidpanel.damping.models import Damper, FilledDamper
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.files import read_basis, read_plate
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.files import Files
from pidpanel.provenance.results import read_csv
from pidpanel.response.cases import ResponseScenario
from pidpanel.response.exports import write_exports
from pidpanel.response.mapping import write_rms_maps
from pidpanel.response.model_error import read_errors
from pidpanel.response.panel import ResponsePanel, Settings, widen
from pidpanel.response.psd_files import is_steady, read_psd
from pidpanel.response.refinement import checked_responses, read_further_shapes
from pidpanel.response.results import Tabulation, write_tables
from pidpanel.response.trust import BASIS_ERROR, MODES_ERROR
from pidpanel.solve.excitation import Matrices
from pidpanel.sound.field import SoundExcitation, wavenumber
from pidpanel.sound.field_files import MODAL_FORCE, read_load_error, read_table
from pidpanel.sound.from_study import (
    air_of,
    excitation_of,
    modal_force_at,
    read_air,
    sound_tables,
    spectrum_of,
)
from pidpanel.sound.radiation import Air
from pidpanel.structure.from_study import studied
from pidpanel.study import Scenario, Study
from pidpanel.study.dampers import TONES, BedDamper


@dataclass(frozen=True)
class StudySound:
    """The sound of a study on any shapes of its panel; see `panel.ExcitationSource`."""

    study: Study

    def on_basis(self, basis: PanelBasis, air: Air | None) -> tuple[SoundExcitation, Air | None]:
        """Return the excitation of a basis, and the air on it where there is some."""
        tables = sound_tables(self.study, basis, air=air is not None)
        excitation = excitation_of(self.study.acoustics, tables[MODAL_FORCE])
        return excitation, None if air is None else air_of(self.study, tables)

    def force_at(self, frequency: float, basis: PanelBasis) -> Matrices:
        """Return G (n, n) [m⁴] of a basis at a frequency [Hz]."""
        return modal_force_at(self.study, frequency, basis)


def read_response_panel(study: Study, files: Files) -> ResponsePanel:
    """Read the files of the panel and sound stages.

    Raises
    ------
    ValueError
        If the file of the air is missing but needed.
    """
    level, table = study.damping.level, read_table(files.modal_force, MODAL_FORCE)
    basis, panel = read_basis(files.modes), studied(study.panel)
    excitation = excitation_of(study.acoustics, table)
    return ResponsePanel(
        Settings(
            study.response.frequency_hz,
            study.panel.modal_damping,
            study.response.modal_damping == "diagonal",
            level.by == "element",
            level.acceleration_g,
            excitation.pressure.jumps,
        ),
        basis,
        excitation,
        panel.section.mass_per_area,
        panel.wave_shift,
        panel.point_refinement_error(study.response.frequency_hz[1]),
        read_air(study, table, files.get("air")),
        load_error=_load_error(study, basis, files.modal_force),
        has_independent_loads=study.acoustics.field_name == "measured",
    )


def _load_error(study: Study, basis: PanelBasis, path: Path) -> Array | None:
    """Return the error of the load of each mode at its resonance (n_modes,); None of a panel."""
    if (stored := read_load_error(path)) is None:
        return None
    modes = np.flatnonzero(~basis.is_residual)
    k = wavenumber(basis.natural_frequency[modes], study.acoustics.speed_m_s)
    pairs = zip(k.tolist(), stored[1].T[modes], strict=True)
    return np.array([np.interp(k, stored[0], error) for k, error in pairs])


DamperOf = Callable[[str, str, str], tuple[str, Damper]]


def dampers_of_scenarios(
    study: Study, damping: Path | None, coupled: Path | None, *, is_broadband: bool = True
) -> DamperOf:
    """Return the damper of a scenario, patch and name, with the name that its errors go by.

    Parameters
    ----------
    damping, coupled
        Folders of the surfaces and of the coupled runs; None for a study without any.
    is_broadband
        Whether the motion has all frequencies at once, not single tones.
    """
    models = dampers_of(study, damping, is_broadband=is_broadband)
    beds = {} if coupled is None else read_coupled(coupled / "impedance.csv")

    def damper_of(label: str, patch: str, name: str) -> tuple[str, Damper]:
        bed = beds.get((label, patch))
        if bed is None:
            return name, models[name]
        # each patch has its own motion, and its own errors
        return f"{name} on {patch}", with_mass_of(study, bed)

    return damper_of


def not_read(_label: str, _patch: str, name: str) -> tuple[str, Damper]:
    """Return no damping, for what needs the scenarios alone."""
    return name, ConstantDamper()


def scenarios_of(study: Study, damper_of: DamperOf = not_read) -> list[ResponseScenario]:
    """Return the scenarios of a study, with the dampers that a function returns."""
    bands = spectrum_of(study.acoustics)
    return [
        replace(
            scenario_of(study, scenario, scenario.label, damper_of),
            bare_label=scenario.bare.label,
            oaspl_db=scenario.oaspl_db or bands.oaspl,
            factor=1.0 if scenario.oaspl_db is None else bands.pressure_factor(scenario.oaspl_db),
        )
        for scenario in study.all_scenarios()
    ]


def scenario_of(
    study: Study, scenario: Scenario, label: str, damper_of: DamperOf
) -> ResponseScenario:
    """Return a scenario by a label, at the level of the study."""
    sections = [study.damper_of(filling) for filling in scenario.fillings.values()]
    beds = [section for section in sections if isinstance(section, BedDamper)]
    texts = study.model_texts(scenario)
    return ResponseScenario(
        label,
        "bare",
        math.nan,
        1.0,
        {
            patch: FilledDamper(
                *damper_of(label, patch, study.damper_name(scenario, patch)),
                filling.fill_fraction,
                tolerances=tolerances_of(study, scenario, patch),
            )
            for patch, filling in scenario.fillings.items()
        },
        " and ".join(text.source for text in texts) or "none",
        is_coupled=study.is_coupled_scenario(scenario),
        is_coarse=any(
            bed.model == TONES and bed.prior == "closed_form" and bed.sweep.is_coarse
            for bed in beds
        ),
        is_of_atlas=any(bed.model == "atlas" for bed in beds),
    )


def write_response(
    study: Study,
    files: Files,
    output: Files,
    damping: Path | None,
    coupled: Path | None,
    lines: Array | None = None,
) -> None:
    """Write PSDs, rms values, strain and stress of every scenario.

    Parameters
    ----------
    files
        Files of the panel and the sound: modes, plate, section, modal_force and air.
    output
        psd, summary, layouts, stress, stress_table and left_out.
    damping
        Folder of the surfaces, ``results/<study>/damping``; None for a study without any.
    coupled
        Folder of the coupled runs; None for a study without any.
    lines
        (nf,) frequencies of the PSDs [Hz]; None for those that resolve the panel's resonances.

    Raises
    ------
    OutsideSimulatedRange
        If the study refuses an extrapolated C_e.
    ValueError
        If a stage upstream raises it.
    """
    scenarios = scenarios_of(study, dampers_of_scenarios(study, damping, coupled))
    start = read_response_panel(study, files)
    start = replace(start, settings=replace(start.settings, lines=lines))
    plate = read_plate(files.plate)
    checked = checked_responses(start, plate, scenarios, StudySound(study))
    errors = None
    if coupled is not None:
        errors = read_errors(coupled, checked.panel.frequency, checked.panel.basis.point_names)
    tabulation = Tabulation(
        attributes=stamp(study),
        scenarios=scenarios,
        panel_mass=read_panel_mass(study, files.section),
        thickness=study.panel.section.thickness,
        level=study.damping.level.kind,
        refuses_outside=study.damping.level.outside == "refuse",
        coupled_errors=errors,
        coupled_accuracy=study.damping.coupled.relative_error,
        stretching=plate.stretching,
        basis_error=MODES_ERROR if plate.is_of_modes else BASIS_ERROR,
    )
    write_tables(checked, tabulation, output)


def read_panel_mass(study: Study, section: Path) -> float:
    """Return the mass of the panel with attached masses [kg]."""
    table = read_csv(section).set_index("quantity")["value"]
    return float(table["mass"]) + sum(mass.mass_kg for mass in study.panel.masses.values())


def write_maps(study: Study, files: Files, output: Files) -> None:
    """Write rms values over the whole panel for the scenarios of ``response.maps``.

    Parameters
    ----------
    files
        Files of `write_response`, its psd and left_out, and coupled: ``coupled/impedance.csv`` with
        the own force of the particles, if there is any.
    output
        maps, a NetCDF file, and folder for ParaView.
    """
    psd, coupled = read_psd(files.psd), files.get("coupled")
    panel = read_wide_panel(study, files, psd)
    labels = {scenario.label for scenario in study.mapped_scenarios()}
    if not study.response.maps:
        labels.add(quietest(study, psd))
    beds = {} if coupled is None else read_coupled(coupled)

    def damper_of(label: str, patch: str, name: str) -> tuple[str, Damper]:
        return name, beds.get((label, patch), ConstantDamper())

    mapped = [case for case in scenarios_of(study, damper_of) if case.label in labels]
    write_rms_maps(panel, mapped, psd, stamp(study), output)


def read_wide_panel(study: Study, files: Files, psd: xr.Dataset) -> ResponsePanel:
    """Read the panel with the basis and the lines that its responses ``psd`` had.

    ``files`` are modes, plate, modal_force, air and left_out.
    """
    panel = read_response_panel(study, files)
    shapes = read_further_shapes(files.left_out)
    panel = widen(panel, read_plate(files.plate), shapes, StudySound(study))
    return replace(panel, least_damping_ratio=float(psd.attrs["resolved_damping_ratio"]))


def quietest(study: Study, psd: xr.Dataset) -> str:
    """Return the scenario with the least motion at the point where its bare panel moves most.

    It is one at the level of the first bare panel, or that panel where nothing else is steady.
    """
    bare = study.all_scenarios()[0]
    main = [s for s in study.all_scenarios() if s.bare.label == bare.label and study.is_main(s)]
    steady = [bare.label, *(s.label for s in main if is_steady(psd, s.label))]
    power = psd["acceleration_psd"].sel(scenario=steady).integrate("frequency")
    worst = int(power.isel(scenario=0).to_numpy().argmax())
    return steady[int(power.isel(point=worst).to_numpy().argmin())]


def write_export(study: Study, modes: Path, psd_nc: Path, summary_csv: Path, folder: Path) -> None:
    """Write files for other programs: CSV, third octaves, Nastran TABRND1 and TABDMP1, UFF 58.

    Parameters
    ----------
    modes
        ``panel/modes.nc``.
    psd_nc, summary_csv
        ``response/psd.nc`` and ``response/summary.csv``.
    folder
        Made where it is not there.
    """
    summary = read_csv(summary_csv, dtype={"scenario": str, "point": str, "doubts": str})
    psd, title = read_psd(psd_nc), f"pidpanel study {study.name}"
    scenarios, ratio = scenarios_of(study), study.panel.modal_damping
    write_exports(read_basis(modes), ratio, scenarios, psd, summary, title, folder)


def partly_known(study: Study) -> list[str]:
    """Return the scenarios some of whose dampers state no error, by label.

    What is found for them has the errors of the others alone.
    """
    return [
        scenario.label
        for scenario in study.all_scenarios()
        if not all(study.damper_of(f).states_error for f in scenario.fillings.values())
    ]
