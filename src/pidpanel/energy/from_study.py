"""Statistical energy of a study: the only module of the stage that reads it."""

from collections.abc import Hashable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array, described_variables
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping.models import DampingError
from pidpanel.energy.response import DamperLoad, Edges, EnergyPanel, EnergyResponse, Medium
from pidpanel.energy.transition import (
    OCTAVE,
    THIRD,
    Bands,
    Factors,
    band_errors,
    energy_share,
    factors_of,
    heavy,
    objection,
)
from pidpanel.energy.waves import PanelWaves
from pidpanel.geometry.plane_mesh import boundary_edges, cell_areas
from pidpanel.panel.from_study import StudiedPanel
from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.supports import held_vertices
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.files import Files
from pidpanel.provenance.results import read_csv
from pidpanel.response.cases import ResponseScenario
from pidpanel.response.from_study import dampers_of_scenarios, read_wide_panel, scenarios_of
from pidpanel.response.mapping import scenario_covariances
from pidpanel.response.panel import ResponsePanel
from pidpanel.response.psd_files import is_steady, read_psd
from pidpanel.response.results import write_csv
from pidpanel.response.tables import cases_dataset
from pidpanel.solve.bands import third_octaves
from pidpanel.solve.lines import trapezoid_weights
from pidpanel.solve.panel import fixed_points
from pidpanel.sound.field import lumped_area
from pidpanel.sound.from_study import WETTED_SIDES
from pidpanel.study import Study, StudyError
from pidpanel.study.structure import Structure

COMPARED = 2 * OCTAVE  # third octaves in which both answers are compared, the last of the modal one
LINES_PER_OCTAVE = 24  # beyond the modal answer
JUST = 1e-6  # relative distance of the lines on both sides of a jump

VARIABLES = described_variables(Path(__file__).with_name("variables.csv"))
NAMES = {"scenario": str, "point": str, "patch": str}


class DamperEnergy(NamedTuple):
    """What a scenario's dampers do to the energy of the panel."""

    load: DamperLoad
    error: Array  # (nf,) standard error of ln of the resistance
    highest: float  # to which their damping is known [Hz]
    refusal: str  # why they are refused; "" where they are not


def energy_panel(study: Study, panel: ResponsePanel) -> EnergyPanel:
    """Return the panel of a study for statistical energy."""
    sound, basis = study.acoustics, panel.basis
    if isinstance(study.panel, Structure):
        raise StudyError(f"{study.name}: energy: only allowed with a panel")
    studied = StudiedPanel(study.panel)
    cells = basis.cells
    kind = {4: "quadrilaterals", 3: "triangles"}[cells.shape[1]]
    mesh = PanelMesh(basis.vertex_position, cells, kind, {}, {})
    _, supported = held_vertices(mesh, studied.supports)
    pairs = boundary_edges(cells)
    step = basis.vertex_position[pairs[:, 1]] - basis.vertex_position[pairs[:, 0]]
    kinds = (supported.get(tuple(sorted(pair)), ("free",))[0] for pair in pairs.tolist())
    edges = Edges(np.hypot(*step.T), np.arctan2(*step.T[::-1]), tuple(kinds))
    sides = WETTED_SIDES.get(study.radiation, 0)
    medium = Medium(sound.speed_m_s, sound.air_density_kg_m3, sides, not sound.is_free)
    area = float(cell_areas(basis.vertex_position, cells).sum())
    waves = PanelWaves(studied.section)
    return EnergyPanel(waves, area, edges, study.panel.modal_damping, medium)


def damper_energy(
    scenario: ResponseScenario, gamma: Mapping[str, float], panel: ResponsePanel, lines: Array
) -> DamperEnergy:
    """Return what the dampers of a scenario do at lines (nf,) [Hz], at their Γ by patch."""
    resistance, mass, error = np.zeros((3, lines.size))
    highest, refusal = np.inf, ""
    for patch, damper in scenario.dampers.items():
        area = panel.patch_area[panel.basis.patch_names.index(patch)]
        read_at = damper.stated_acceleration_g or gamma[patch]
        try:
            values = damper.model(lines, damper.fill, read_at)
        except DampingError as reason:
            return DamperEnergy(DamperLoad(), error, 0.0, f"{patch}: {reason}")
        end = np.inf if values.inside.all() else lines[np.argmin(values.inside)]
        inside = lines < end
        C_e, m_a = values.equivalent_damping, values.apparent_mass
        if why := heavy(lines[inside], C_e[inside], m_a[inside], panel.mass_per_area):
            refusal = refusal or f"damper on {patch} is {why}"
        highest = min(highest, end)
        resistance += area * C_e
        mass += area * m_a
        error += area * values.equivalent_damping_error
    relative = np.divide(error, resistance, out=np.zeros_like(error), where=resistance > 0)
    return DamperEnergy(DamperLoad(resistance, mass), relative, highest, refusal)


def mode_factors(panel: ResponsePanel, low: float, high: float) -> Factors:
    """Return the factors of the modes between two frequencies [Hz]; of those alike for none."""
    basis = panel.basis
    f = basis.natural_frequency
    modes = np.flatnonzero(~basis.is_residual & (f >= low) & (f < high))
    if not modes.size:
        return Factors(1.0, 3.0)
    force = np.asarray(panel.excitation(np.array([np.sqrt(low * high)]))[0]).real
    overlap = np.diagonal(basis.face_overlap)[modes]
    area = lumped_area(basis.vertex_position, basis.cells)
    return factors_of(np.diagonal(force)[modes], overlap, basis.shape_at_vertices[:, modes], area)


class Answer(NamedTuple):
    """Statistical energy of a scenario."""

    bands: Bands
    at_centres: EnergyResponse
    # (n_bands,) and (n_compared,) area mean of S_a in the bands [(m/s²)²/Hz]
    energy_mean: Array
    modal_mean: Array
    psd: Array  # (nf,) S_a by energy at the lines, 0 below the bands [(m/s²)²/Hz]
    highest: float  # end of the PSD [Hz]
    status: str  # why there is no transition; "" where there is one


class _Energies:
    """Bands and lines of a study, and the answers of its scenarios."""

    def __init__(self, study: Study, panel: ResponsePanel, psd: xr.Dataset) -> None:
        if study.energy is None:
            raise StudyError(f"{study.name}: energy: missing")
        self.panel, self.psd, self.energy = panel, psd, energy_panel(study, panel)
        (low, self.end), self.highest = study.response.frequency_hz, study.energy.highest_hz
        centre, edge = third_octaves(low, self.highest)
        is_modal = np.isclose(edge[:, 1] / edge[:, 0], 10**0.1) & (
            edge[:, 1] < self.end * (1 + JUST)
        )
        compared = np.flatnonzero(is_modal)[-COMPARED:]
        self.compared = len(compared)
        used = (np.arange(len(centre)) >= compared.min(initial=len(centre))) | (
            edge[:, 1] > self.end
        )
        self.centre, self.edge = centre[used], edge[used]
        last = self.edge[max(self.compared - OCTAVE, 0) : max(self.compared, 1)]
        self.octave = float(last[0, 0]), float(last[-1, 1])
        self.factors = mode_factors(panel, *self.octave)
        modal = psd["frequency"].to_numpy()
        count = int(np.ceil(LINES_PER_OCTAVE * np.log2(self.highest / self.end))) + 1
        jumps = np.multiply.outer([1 - JUST, 1 + JUST], np.asarray(panel.settings.jumps)).ravel()
        further = np.union1d(np.geomspace(self.end, self.highest, count), jumps)
        further = further[(further > self.end) & (further <= self.highest)]
        self.lines = np.concatenate([modal, further])
        self.is_modal = np.arange(self.lines.size) < modal.size

    def band_weights(self, lines: Array) -> Array:
        """Return weights (n_bands, nf) of lines in the mean over each band."""
        lower, upper = self.edge.T[..., None]
        weight = trapezoid_weights(lines) * ((lines >= lower) & (lines < upper))
        return np.asarray(weight / weight.sum(axis=1, keepdims=True))

    def modal_means(self, scenarios: Sequence[ResponseScenario]) -> dict[str, Array]:
        """Return the modal area mean of S_a (n_compared,) [(m/s²)²/Hz] by scenario."""
        lines = self.panel.coarse_frequency
        lines = lines[lines >= self.edge[0, 0]]
        with np.errstate(invalid="ignore"):  # bands beyond the modal answer have no lines
            weights = self.band_weights(lines)[: self.compared] * (2 * np.pi * lines) ** 4
        covariances = scenario_covariances(self.panel, scenarios, self.psd, lines, weights)
        overlap = self.panel.basis.face_overlap / self.energy.area
        return {label: np.tensordot(sums, overlap, axes=2) for label, sums in covariances.items()}

    def answer(
        self, scenario: ResponseScenario, gamma: Mapping[str, float], modal: Array
    ) -> Answer:
        """Return the answer of a scenario at the Γ of its patches."""
        used = self.lines >= self.edge[0, 0]
        f = self.lines[used]
        dampers = damper_energy(scenario, gamma, self.panel, f)
        load, centre = dampers.load, self.centre
        response = self.energy.response(f, load)
        psd = np.zeros(self.lines.size)
        spectrum = self.panel.excitation.spectrum(f)
        psd[used] = scenario.factor * response.acceleration * spectrum
        local_load = DamperLoad(
            *(np.interp(centre, f, np.broadcast_to(part, f.shape)) for part in load)
        )
        local = self.energy.response(centre, local_load)
        weights = self.band_weights(f)
        mean = weights @ psd[used]
        local = local._replace(
            at_coincidence=weights @ response.at_coincidence > 0.5,
            is_known=weights @ response.is_known > 1 - JUST,
        )
        difference = np.full(centre.size, np.nan)
        difference[: self.compared] = 10 * np.log10(mean[: self.compared] / modal)
        errors = band_errors(centre, local, self.factors, np.interp(centre, f, dampers.error))
        modes = local.modal_density * centre * THIRD
        bands = Bands(centre, modes, difference, local.at_coincidence, local.is_known, *errors)
        highest = min(self.highest, dampers.highest)
        status = dampers.refusal or objection(bands)
        if scenario.is_coupled:
            status = "coupled runs end with the modal answer"
        elif not status and highest <= self.end:
            status = f"damping is known to {highest:.4g} Hz only"
        return Answer(bands, local, mean, modal, psd, self.end if status else highest, status)


def write_energy(
    study: Study, files: Files, output: Files, damping: Path | None, coupled: Path | None
) -> None:
    """Write third octaves of both answers, one PSD of each point with its error, and rms values.

    Parameters
    ----------
    files
        Files of the panel and the sound, and psd, summary, layouts and left_out of the response.
    output
        bands, psd, summary.
    damping, coupled
        Same as in `write_response`.
    """
    psd = read_psd(files.psd)
    panel = read_wide_panel(study, files, psd)
    scenarios = [
        scenario
        for scenario in scenarios_of(study, dampers_of_scenarios(study, damping, coupled))
        if is_steady(psd, scenario.label)
    ]
    energies = _Energies(study, panel, psd)
    layouts, summary = (read_csv(path, dtype=NAMES) for path in (files.layouts, files.summary))
    modal = energies.modal_means(scenarios)
    bands, rows, curves = [], [], {}
    for scenario in scenarios:
        label = scenario.label
        cases = layouts[layouts["scenario"] == label]
        gamma = dict(zip(cases["patch"], cases["damping_read_at_g"], strict=True))
        answer = energies.answer(scenario, gamma, modal[label])
        bands.append(_band_table(label, answer))
        curves[label] = _curves(energies, label, answer)
        points = summary[summary["scenario"] == label].to_dict("records")
        by_point = {str(row["point"]): row for row in points}
        rows += list(_summary_rows(energies, answer, curves[label], by_point))
    write_csv(output.bands, pd.concat(bands))
    write_csv(output.summary, pd.DataFrame(rows))
    axes = {
        "frequency": energies.lines,
        "scenario": list(curves),
        "point": panel.basis.point_names,
    }
    dataset = cases_dataset(curves, VARIABLES, axes).assign_attrs(stamp(study))
    dataset.to_netcdf(output.psd, engine="scipy")


def _band_table(label: str, answer: Answer) -> pd.DataFrame:
    """Return the rows of ``bands.csv`` of a scenario."""
    bands, energy, g = answer.bands, answer.at_centres, STANDARD_GRAVITY**2
    modal = np.full(bands.centre.size, np.nan)
    modal[: answer.modal_mean.size] = answer.modal_mean
    columns = {
        "scenario": label,
        "center_hz": bands.centre,
        "modes": bands.modes,
        "wavenumber_ratio": energy.wavenumber_ratio,
        "radiation_efficiency": energy.radiation_efficiency,
        "loss_factor": energy.loss_factor,
        "damper_loss_factor": energy.damper_loss_factor,
        "resonant_share": energy.resonant_share,
        "energy_psd_g2_hz": answer.energy_mean / g,
        "modal_psd_g2_hz": modal / g,
        "difference_db": bands.difference_db,
        "mean_error_db": 10 / np.log(10) * bands.mean_error,
        "point_error_db": 10 / np.log(10) * bands.point_error,
        "at_coincidence": bands.at_coincidence.astype(int),
    }
    return pd.DataFrame(columns)[bands.centre <= answer.highest]


def _curves(energies: _Energies, label: str, answer: Answer) -> dict[str, Array]:
    """Return the variables of ``psd.nc`` of a scenario, one PSD of each point (nf, n_points)."""
    lines, is_modal = energies.lines, energies.is_modal
    case = energies.psd.sel(scenario=label)
    modal, modal_error = np.zeros((2, lines.size, case.sizes["point"]))
    modal[is_modal] = case["acceleration_psd"].transpose("frequency", "point").to_numpy()
    if (name := "acceleration_psd_log_error") in case:
        error = case[name].transpose("frequency", "point").to_numpy()
        modal_error[is_modal] = np.nan_to_num(error)
    share = np.where(is_modal, 0.0, np.nan)
    if not answer.status:
        share = energy_share(lines, *energies.octave)
    energy = (share * answer.psd)[:, None] * ~fixed_points(energies.panel.basis)
    modal *= 1 - share[:, None]
    bands = answer.bands
    energy_error = np.interp(np.log(lines), np.log(bands.centre), bands.point_error)[:, None]
    psd = modal + energy
    spread = np.hypot(modal * modal_error, energy * energy_error)
    error = np.divide(spread, psd, out=np.zeros_like(psd), where=psd > 0)
    psd[lines > answer.highest], error[lines > answer.highest] = np.nan, np.nan
    return {"acceleration_psd": psd, "acceleration_psd_log_error": error, "share": share}


def _summary_rows(
    energies: _Energies,
    answer: Answer,
    curves: Mapping[str, Array],
    summary: Mapping[str, Mapping[Hashable, Any]],
) -> Iterator[dict[str, Any]]:
    """Yield the rows of ``summary.csv`` of a scenario by point; ``summary`` is of its response."""
    used = energies.lines <= answer.highest
    lines, psd = energies.lines[used], curves["acceleration_psd"][used]
    weight = trapezoid_weights(lines)
    energy = weight * np.nan_to_num(curves["share"][used]) * answer.psd[used]
    # bands err independently of each other
    band = np.searchsorted(energies.edge[:, 1], lines)
    in_band = np.bincount(band, energy, energies.centre.size + 1)[:-1]
    scatter = float(np.sum((in_band * answer.bands.point_error) ** 2))
    transition = (np.nan, np.nan) if answer.status else energies.octave
    for point, total in zip(energies.panel.basis.point_names, weight @ psd, strict=True):
        rms, error = (summary[point][f"acceleration_rms{end}_g"] for end in ("", "_error"))
        relative = np.nan_to_num(error / rms) if rms > 0 else 0.0
        variance = (2 * relative * (total - energy.sum())) ** 2 + scatter
        value = np.sqrt(total) / STANDARD_GRAVITY
        yield {
            "scenario": summary[point]["scenario"],
            "point": point,
            "modal_rms_g": rms,
            "highest_hz": answer.highest,
            "acceleration_rms_g": value,
            "acceleration_rms_error_g": value * np.sqrt(variance) / (2 * total) if total else 0.0,
            "transition_low_hz": transition[0],
            "transition_high_hz": transition[1],
            "status": answer.status or "ok",
        }
