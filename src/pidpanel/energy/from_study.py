"""Statistical energy of a study: the only module of the stage that reads it."""

from collections.abc import Iterator, Mapping
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

COMPARED = 2 * OCTAVE  # third octaves in which both answers are compared, the last of the modal one
LINES_PER_OCTAVE = 24  # beyond the modal answer
JUST = 1e-6  # relative distance of the lines on both sides of a jump

VARIABLES = described_variables(Path(__file__).with_name("variables.csv"))
NAMES = {"scenario": str, "point": str, "patch": str}


class Known(NamedTuple):
    """What a scenario's dampers do to the energy of the panel."""

    load: DamperLoad
    error: Array  # (nf,) standard error of ln of the resistance
    highest: float  # to which their damping is known [Hz]
    refusal: str  # why they are refused; "" where they are not


def energy_panel(study: Study, panel: ResponsePanel) -> EnergyPanel:
    """Return the panel of a study for statistical energy."""
    sound, basis = study.acoustics, panel.basis
    studied = StudiedPanel(study.panel)
    cells = basis.cells
    kind = {4: "quadrilaterals", 3: "triangles"}[cells.shape[1]]
    mesh = PanelMesh(basis.vertex_position, cells, kind, {}, {})
    _, held = held_vertices(mesh, studied.supports)
    pairs = boundary_edges(cells)
    step = basis.vertex_position[pairs[:, 1]] - basis.vertex_position[pairs[:, 0]]
    kinds = (held.get(tuple(sorted(pair)), ("free",))[0] for pair in pairs.tolist())
    edges = Edges(np.hypot(*step.T), np.arctan2(*step.T[::-1]), tuple(kinds))
    sides = WETTED_SIDES.get(study.radiation, 0)
    medium = Medium(sound.speed_m_s, sound.air_density_kg_m3, sides, not sound.is_free)
    area = float(cell_areas(basis.vertex_position, cells).sum())
    waves = PanelWaves(studied.section)
    return EnergyPanel(waves, area, edges, study.panel.modal_damping, medium)


def known_damping(
    scenario: ResponseScenario, gamma: Mapping[str, float], panel: ResponsePanel, lines: Array
) -> Known:
    """Return what the dampers of a scenario do at lines (nf,) [Hz], at their Γ by patch."""
    resistance, mass, error = np.zeros((3, lines.size))
    highest = np.inf
    for patch, damper in scenario.dampers.items():
        area = panel.patch_area[panel.basis.patch_names.index(patch)]
        read_at = damper.stated_acceleration_g or gamma[patch]
        try:
            values = damper.model(lines, damper.fill, read_at)
        except DampingError as reason:
            return Known(DamperLoad(), error, 0.0, f"{patch}: {reason}")
        end = np.inf if values.inside.all() else lines[np.argmin(values.inside)]
        inside = lines < end
        if inside.any():
            parts = (lines, values.equivalent_damping, values.apparent_mass)
            if why := heavy(*(part[inside] for part in parts), panel.mass_per_area):
                return Known(DamperLoad(), error, 0.0, f"damper on {patch} is {why}")
        highest = min(highest, end)
        resistance += area * values.equivalent_damping
        mass += area * values.apparent_mass
        error += area * values.equivalent_damping_error
    relative = np.divide(error, resistance, out=np.zeros_like(error), where=resistance > 0)
    return Known(DamperLoad(resistance, mass), relative, highest, "")


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
    return factors_of(
        np.diagonal(force)[modes], overlap, basis.shape_at_vertices[:, modes], area
    )


class _Energies:
    """The answers of all scenarios of a study."""

    def __init__(self, study: Study, panel: ResponsePanel, psd: xr.Dataset) -> None:
        section = study.energy
        if section is None:
            raise StudyError(f"{study.name}: energy: missing")
        self.panel, self.psd, self.energy = panel, psd, energy_panel(study, panel)
        (low, end), self.highest = study.response.frequency_hz, section.highest_hz
        centre, edge = third_octaves(low, self.highest)
        whole = np.isclose(edge[:, 1] / edge[:, 0], 10**0.1)
        compared = np.flatnonzero(whole & (edge[:, 1] <= end * (1 + 1e-9)))[-COMPARED:]
        first = compared[0] if compared.size else np.flatnonzero(edge[:, 1] > end)[0]
        self.centre, self.edge = centre[first:], edge[first:]
        self.compared = len(compared)
        self.end = end
        last = self.edge[max(self.compared - OCTAVE, 0) : max(self.compared, 1)]
        self.octave = float(last[0, 0]), float(last[-1, 1])
        self.factors = mode_factors(panel, *self.octave)
        lines = psd["frequency"].to_numpy()
        count = int(np.ceil(LINES_PER_OCTAVE * np.log2(self.highest / end))) + 1
        jumps = np.multiply.outer([1 - JUST, 1 + JUST], np.asarray(panel.settings.jumps)).ravel()
        further = np.union1d(np.geomspace(end, self.highest, count), jumps)
        further = further[(further > end) & (further <= self.highest)]
        self.lines = np.concatenate([lines, further])
        self.is_modal = np.arange(self.lines.size) < lines.size

    def weights(self, lines: Array) -> Array:
        """Return weights (n_compared, nf) of lines in the mean acceleration PSD of each band."""
        lower, upper = self.edge[: self.compared].T[..., None]
        weight = trapezoid_weights(lines) * ((lines >= lower) & (lines < upper))
        return weight / weight.sum(axis=1, keepdims=True)

    def modal_means(self, scenarios: list[ResponseScenario]) -> dict[str, Array]:
        """Return the modal area mean of S_a (n_compared,) [(m/s²)²/Hz] by scenario."""
        lines = self.panel.coarse_frequency
        lines = lines[lines >= self.edge[0, 0]]
        weights = self.weights(lines) * (2 * np.pi * lines) ** 4
        found = scenario_covariances(self.panel, scenarios, self.psd, lines, weights)
        overlap = self.panel.basis.face_overlap / self.energy.area
        return {label: np.tensordot(sums, overlap, axes=2) for label, sums in found.items()}

    def answer(
        self, scenario: ResponseScenario, gamma: Mapping[str, float], modal: Array
    ) -> dict[str, Any]:
        """Return bands, lines and status of a scenario."""
        used = self.lines >= self.edge[0, 0]
        f = self.lines[used]
        known = known_damping(scenario, gamma, self.panel, f)
        energy = self.energy.response(f, known.load)
        pressure = scenario.factor * self.panel.excitation.spectrum(f)
        values = np.zeros(self.lines.size)
        values[used] = energy.acceleration * pressure
        highest = min(self.highest, known.highest)
        bands, mean = self._bands(energy, known, f, values[used], modal)
        status = known.refusal or objection(bands)
        if scenario.is_coupled:
            status = "coupled runs end with the modal answer"
        elif not status and highest <= self.end:
            status = f"damping is known to {highest:.4g} Hz only"
        highest = self.end if status else highest
        error = np.interp(np.log(self.lines), np.log(self.centre), bands.point_error)
        return {
            "bands": bands, "energy_mean": mean, "psd": values, "error": error, "status": status,
            "highest": highest, "loss": energy, "lines": f,
        }  # fmt: skip

    def _bands(
        self, energy: EnergyResponse, known: Known, f: Array, psd: Array, modal: Array
    ) -> tuple[Bands, Array]:
        """Return the third octaves, and the mean PSD by energy in each."""

        def at_centre(values: Array) -> Array:
            return np.interp(self.centre, f, values)

        local = EnergyResponse(*(at_centre(np.asarray(v, float)) for v in energy))
        lower, upper = self.edge.T[..., None]
        weight = trapezoid_weights(f) * ((f >= lower) & (f < upper))
        total = weight.sum(axis=1)
        mean = weight @ psd / total
        coincident = (weight @ energy.at_coincidence > 0.5 * total)
        difference = np.full(self.centre.size, np.nan)
        difference[: self.compared] = 10 * np.log10(mean[: self.compared] / modal)
        local = local._replace(at_coincidence=coincident)
        errors = band_errors(self.centre, local, self.factors, at_centre(known.error))
        modes = local.modal_density * self.centre * THIRD
        is_known = weight @ energy.is_known > (1 - 1e-9) * total
        return Bands(self.centre, modes, difference, coincident, is_known, *errors), mean


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
    layouts = read_csv(files.layouts, dtype=NAMES).set_index(["scenario", "patch"])
    summary = read_csv(files.summary, dtype=NAMES).set_index(["scenario", "point"]).sort_index()
    modal = energies.modal_means(scenarios)
    bands, rows, curves = [], [], {}
    for scenario in scenarios:
        gamma = {
            patch: float(layouts.loc[(scenario.label, patch), "damping_read_at_g"])
            for patch in scenario.patches
        }
        answer = energies.answer(scenario, gamma, modal[scenario.label])
        bands.append(_band_table(energies, scenario.label, answer, modal[scenario.label]))
        curves[scenario.label] = _curves(energies, scenario.label, answer)
        case = summary.loc[scenario.label]
        rows += list(_summary_rows(energies, scenario.label, answer, curves[scenario.label], case))
    write_csv(output.bands, pd.concat(bands))
    write_csv(output.summary, pd.DataFrame(rows))
    axes = {
        "frequency": energies.lines, "scenario": list(curves), "point": panel.basis.point_names
    }  # fmt: skip
    dataset = cases_dataset(curves, VARIABLES, axes).assign_attrs(stamp(study))
    dataset.to_netcdf(output.psd, engine="scipy")


def _band_table(
    energies: _Energies, label: str, answer: Mapping[str, Any], modal: Array
) -> pd.DataFrame:
    """Return the rows of ``bands.csv`` of a scenario."""
    bands, energy, g = answer["bands"], answer["loss"], STANDARD_GRAVITY**2
    modal_mean = np.full(bands.centre.size, np.nan)
    modal_mean[: energies.compared] = modal

    def at_centre(values: Array) -> Array:
        return np.interp(bands.centre, answer["lines"], values)

    return pd.DataFrame(
        {
            "scenario": label,
            "center_hz": bands.centre,
            "modes": bands.modes,
            "wavenumber_ratio": at_centre(energy.wavenumber_ratio),
            "radiation_efficiency": at_centre(energy.radiation_efficiency),
            "loss_factor": at_centre(energy.loss_factor),
            "damper_loss_factor": at_centre(energy.damper_loss_factor),
            "resonant_share": at_centre(energy.resonant_share),
            "energy_psd_g2_hz": answer["energy_mean"] / g,
            "modal_psd_g2_hz": modal_mean / g,
            "difference_db": bands.difference_db,
            "mean_error_db": 10 / np.log(10) * bands.mean_error,
            "point_error_db": 10 / np.log(10) * bands.point_error,
            "at_coincidence": bands.at_coincidence.astype(int),
        }
    )[bands.centre <= answer["highest"]]


def _curves(energies: _Energies, label: str, answer: Mapping[str, Any]) -> dict[str, Array]:
    """Return the variables of ``psd.nc`` of a scenario, one PSD of each point (nf, n_points)."""
    lines, is_modal = energies.lines, energies.is_modal
    case = energies.psd.sel(scenario=label)
    modal = np.zeros((lines.size, case.sizes["point"]))
    modal[is_modal] = case["acceleration_psd"].transpose("frequency", "point").to_numpy()
    log_error = np.zeros_like(modal)
    if "acceleration_psd_log_error" in case:
        error = case["acceleration_psd_log_error"].transpose("frequency", "point").to_numpy()
        log_error[is_modal] = np.nan_to_num(error)
    share = np.where(is_modal, 0.0, np.nan)
    if not answer["status"]:
        share = energy_share(lines, *energies.octave)
    share = share[:, None]
    moves = ~fixed_points(energies.panel.basis)
    energy = answer["psd"][:, None] * moves
    psd = (1 - share) * modal + share * energy
    parts = (1 - share) * modal * log_error, share * energy * answer["error"][:, None]
    known = np.hypot(*parts)
    error = np.divide(known, psd, out=np.zeros_like(psd), where=psd > 0)
    beyond = lines > answer["highest"]
    psd[beyond], error[beyond] = np.nan, np.nan
    return {"acceleration_psd": psd, "acceleration_psd_log_error": error, "share": share[:, 0]}


def _summary_rows(
    energies: _Energies,
    label: str,
    answer: Mapping[str, Any],
    curves: Mapping[str, Array],
    summary: pd.DataFrame,
) -> Iterator[dict[str, Any]]:
    """Yield the rows of ``summary.csv`` of a scenario, one for each point."""
    status = answer["status"]
    lines, psd = energies.lines, curves["acceleration_psd"]
    used = np.isfinite(psd).all(axis=1)
    weight = trapezoid_weights(lines[used])[:, None]
    share = np.nan_to_num(curves["share"])[used, None]
    energy = weight * share * answer["psd"][used, None]
    # bands err independently of each other
    band = np.searchsorted(energies.edge[:, 1], lines[used])
    by_band = np.zeros((energies.centre.size + 1, 1))
    np.add.at(by_band, band, energy)
    spread = np.append(answer["bands"].point_error, 0.0)
    scatter = float(np.sum((by_band[:, 0] * spread) ** 2))
    for number, point in enumerate(energies.panel.basis.point_names):
        total = float(np.sum(weight[:, 0] * psd[used, number]))
        row, moves = summary.loc[point], total > 0
        rms = row["acceleration_rms_g"]
        modal = total - float(energy.sum()) * moves
        relative = np.nan_to_num(row["acceleration_rms_error_g"] / rms) if rms > 0 else 0.0
        variance = (2 * relative * modal) ** 2 + scatter * moves
        value = np.sqrt(total) / STANDARD_GRAVITY
        yield {
            "scenario": label,
            "point": point,
            "modal_rms_g": rms,
            "highest_hz": answer["highest"],
            "acceleration_rms_g": value,
            "acceleration_rms_error_g": value * np.sqrt(variance) / (2 * total) if moves else 0.0,
            "transition_low_hz": np.nan if status else energies.octave[0],
            "transition_high_hz": np.nan if status else energies.octave[1],
            "status": status or "ok",
        }
