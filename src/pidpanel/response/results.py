"""PSDs and tables of every scenario."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.panel.matrices import Stretching
from pidpanel.provenance.files import Files
from pidpanel.response import tables
from pidpanel.response.cases import ResponseScenario, SolvedCase, balance_of
from pidpanel.response.extrapolation import between_regimes, extrapolation_of
from pidpanel.response.model_error import (
    broadband_error_of,
    load_error_of,
    model_error_of,
    undamped_response,
    with_model_error,
)
from pidpanel.response.refinement import CheckedResponses, write_further_shapes
from pidpanel.response.stretching import StretchedCases
from pidpanel.response.tables import PATCH_COLUMNS, damping_on_patches, only_motion, patch_rows
from pidpanel.response.trust import judged
from pidpanel.solve import stress, uncertainty
from pidpanel.solve.layout import LayoutResponse
from pidpanel.solve.mesh_error import MeshError
from pidpanel.solve.model import PanelResponse, ResponseError, UnstableDamping
from pidpanel.solve.panel import fixed_points
from pidpanel.solve.solvers import Request

FREQUENCY = "frequency_hz"
STRESS_PLACE = ["scenario", "layer", "quantity", "point"]  # of ``stress.csv``
CORE = "core"  # name of the core among the layers of ``stress.csv``


class OutsideSimulatedRange(ResponseError):
    """C_e is read where no coupon was simulated, and the study refuses that."""


@dataclass(frozen=True)
class Tabulation:
    """Values of a study that its tables need in addition to the responses."""

    attributes: Mapping[str, str]
    scenarios: Sequence[ResponseScenario]
    # Mass and thickness of the panel [kg], [m]
    panel_mass: float
    thickness: float
    level: str
    refuses_outside: bool  # whether extrapolated damping is an error
    # Standard errors of coupled runs by scenario; None for a study without any
    coupled_errors: Mapping[str, uncertainty.StandardErrors] | None
    coupled_accuracy: float  # required relative standard error of coupled runs [1]
    stretching: Stretching | None  # of the lowest modes; None where it is not known
    basis_error: float  # largest error of a PSD that the shapes may leave [1]


def write_tables(checked: CheckedResponses, tabulation: Tabulation, output: Files) -> None:
    """Write all files of the stage."""
    panel, basis = checked.panel, checked.panel.basis
    rows = _Rows(checked, tabulation)
    for case, basis_error, mesh in zip(
        checked.cases, checked.basis_error.tolist(), checked.mesh_error, strict=True
    ):
        rows.add(case, basis_error, mesh)
    labels = [scenario.label for scenario in tabulation.scenarios]
    axes = {"frequency": panel.frequency, "scenario": labels, "point": basis.point_names}
    summary = pd.concat(rows.summary, ignore_index=True)
    limits = tabulation.coupled_accuracy, tabulation.basis_error
    summary = judged(tabulation.scenarios, summary, *limits)
    write_csv(output.summary, summary)
    write_csv(output.layouts, pd.DataFrame(rows.layouts, columns=list(PATCH_COLUMNS)))
    psds = {**axes, "patch": basis.patch_names}
    tables.cases_dataset(rows.psds, tables.PSD_VARIABLES, psds).assign_attrs(
        tabulation.attributes, level=tabulation.level, resolved_damping_ratio=panel.resolved_ratio
    ).to_netcdf(output.psd, engine="scipy")
    stress_table = pd.DataFrame(rows.stress, columns=None if rows.stress else STRESS_PLACE)
    write_csv(output.stress_table, stress_table)
    strains = xr.Dataset()
    if rows.layers.names:  # of modes from a file there are none
        variables = tables.stress_variables(stress.QUANTITIES)
        places = {**axes, "layer": rows.layers.names}
        strains = tables.cases_dataset(rows.strains, variables, places, np.float32)
    strains.assign_attrs(tabulation.attributes).to_netcdf(output.stress, engine="scipy")
    write_further_shapes(output.left_out, checked.further_shapes, dict(tabulation.attributes))


def error_parts(
    case: SolvedCase, response: LayoutResponse, further: uncertainty.FurtherPsd | None = None
) -> tuple[uncertainty.StandardErrors | None, uncertainty.StandardErrors | None]:
    """Return the standard errors by the damping, and by its inputs; further PSDs last.

    Dampers of one source have its errors in common; those of different ones are independent. None
    where there are none.
    """
    all_nodes = [damper.model.nodes for damper in case.dampers if damper.model.nodes is not None]
    if not all_nodes:
        return None, None
    nodes = np.unique(np.concatenate(all_nodes))
    points = [
        (damper.fill, float(gamma))
        for damper, gamma in zip(case.dampers, response.acceleration_g, strict=True)
    ]
    zero = np.zeros((2 * len(nodes), 2 * len(nodes)))

    def covariance_of(row: int, column: int) -> Array:
        damper = case.dampers[row]
        if damper.name != case.dampers[column].name or damper.model.nodes is None:
            return zero
        return damper.model.cross_covariance(nodes, points[row], points[column])

    numbers = range(len(points))
    covariance = np.block([[covariance_of(i, j) for j in numbers] for i in numbers])
    sensitivity = uncertainty.sensitivity(case.solver, case.layout, response, nodes, further)
    changes: dict[str, Array] = {}
    for load, (damper, (_, gamma)) in enumerate(zip(case.dampers, points, strict=True)):
        for tolerance in damper.tolerances:
            change = changes.setdefault(tolerance.source, np.zeros((len(points), len(zero))))
            change[load] = tolerance.change(nodes, damper.stated_acceleration_g or gamma)
    inputs = np.array([change.ravel() for change in changes.values()])
    input_errors = sensitivity.standard_errors(inputs.T @ inputs) if changes else None
    return sensitivity.standard_errors(covariance), input_errors


class _Rows:
    """Rows and PSDs of all cases."""

    def __init__(self, checked: CheckedResponses, tabulation: Tabulation) -> None:
        self._panel = panel = checked.panel
        self._tabulation = tabulation
        self._balance_error = balance_of(panel)
        self._full = _full_responses(checked)
        self._stretched = StretchedCases(
            checked.solver, tabulation.stretching, checked.cases, tabulation.thickness
        )
        basis = panel.basis
        self.layers = stress.distinct_layers(
            basis.layer_names, basis.layer_strain, basis.layer_stress
        )
        self.summary: list[pd.DataFrame] = []
        self.layouts: list[dict[str, Any]] = []
        self.stress: list[dict[str, Any]] = []
        self.psds: dict[str, dict[str, Array]] = {}
        self.strains: dict[str, dict[str, Array]] = {}

    def add(self, case: SolvedCase, basis_error: float, mesh: MeshError | None) -> None:
        """Add a case."""
        panel, response, label = self._panel, case.response, case.scenario.label
        if isinstance(response, UnstableDamping) or mesh is None:
            print(f"{label}: {response}", file=sys.stderr)
            self._add_summary(case, "unstable", {})
            return
        if self._tabulation.refuses_outside:
            _refuse_outside(panel.frequency, case, response)
        model_error = model_error_of(case, response)
        damping_error, input_error = error_parts(case, response)
        # those of coupled runs have more than the errors of C_e and m_a
        damping_error = (self._tabulation.coupled_errors or {}).get(label, damping_error)
        damping_error = with_model_error(damping_error, input_error)
        error = with_model_error(damping_error, model_error)
        load_error = load_error_of(panel, response.response)
        parts = [0.0 if part is None else part.log_rms for part in (model_error, input_error)]
        part_db = [20 / np.log(10) * part for part in parts]
        beyond = extrapolation_of(case.dampers, response, panel.frequency)
        between = between_regimes(case.dampers, response, panel.frequency)
        bare, damped = (answer.response.acceleration_psd for answer in (case.bare, response))
        columns = {
            **self._summary_columns(case, response, error, load_error),
            "basis_error": basis_error,
            "mesh_error": mesh.line,
            "mesh_error_rms": mesh.rms,
            "point_error_rms": mesh.point_rms,
            "model_error_db": part_db[0],
            "tolerance_error_db": part_db[1],
            "extrapolated_share": beyond.share_of_change(bare, damped, panel.frequency),
            "data_missing": beyond.missing,
            "between_share": between.share_of_change(bare, damped, panel.frequency),
        }
        self._add_summary(case, np.where(fixed_points(panel.basis), "held", "ok"), columns)
        self.layouts += [{"scenario": label, **row} for row in patch_rows(panel, case, response)]
        self.psds[label] = {
            "acceleration_psd": damped,
            "velocity_psd": response.response.velocity_psd,
            "displacement_psd": response.response.displacement_psd,
            **damping_on_patches(panel, case, response),
        }
        if case.dead_weight is not None:
            dead_weight = case.dead_weight.response.acceleration_psd
            self.psds[label]["dead_weight_acceleration_psd"] = dead_weight
        if (total := with_model_error(error, load_error)) is not None:
            self.psds[label]["acceleration_psd_log_error"] = total.log_psd
        self.strains[label], rows = self._strains(case, response.response, damping_error)
        self.stress += [{"scenario": label, **row} for row in rows]

    def _add_summary(self, case: SolvedCase, status: Any, columns: Mapping[str, Any]) -> None:
        """Add the rows of a case to ``summary.csv``, a point each."""
        scenario = case.scenario
        first = {
            "scenario": scenario.label,
            "patch": "+".join(scenario.patches) or "none",
            "fill_fraction": scenario.fill_fraction,
            "oaspl_db": scenario.oaspl_db,
        }
        points = list(self._panel.basis.point_names)
        frame = pd.DataFrame({**first, "status": status, "point": points, **columns})
        self.summary.append(frame)

    def _summary_columns(
        self,
        case: SolvedCase,
        response: LayoutResponse,
        error: uncertainty.StandardErrors | None,
        load_error: uncertainty.StandardErrors | None,
    ) -> dict[str, Any]:
        """Return rms values, their errors, masses and dead weight of a case.

        The load errs alike with and without dampers: that is no error of their ratio.
        """
        panel = self._panel
        read_at, motion = only_motion(panel, case, response, self._tabulation.scenarios)
        values = tables.summary_columns(
            response,
            case.bare,
            thickness=self._tabulation.thickness,
            power_balance_error=self._balance_error(response, case.layout.factor),
            full=self._full.get(case.scenario.label, response.response),
            read_at_g=read_at,
            patch_motion_g=motion,
        )
        masses, mass = case.masses(panel.load_area(response)), self._tabulation.panel_mass
        dead = tables.dead_weight_columns(case.bare, case.dead_weight, masses, mass)
        relative = np.nan if error is None else error.log_rms
        stretched = self._stretched.columns(case, values, relative)
        errors = tables.error_columns(values, error)
        if (total := with_model_error(error, load_error)) is not None:
            errors["acceleration_rms_error_g"] = values["acceleration_rms_g"] * total.log_rms
        return {**values, **errors, **dead, **stretched}

    def _strains(
        self, case: SolvedCase, response: PanelResponse, error: uncertainty.StandardErrors | None
    ) -> tuple[dict[str, Array], list[dict[str, Any]]]:
        """Return PSDs of strain and stress in the layers, and rows of layers and core."""
        model = broadband_error_of(case)
        parts = self._stress_psds(response)
        undamped = self._stress_psds(undamped_response(case)) if any(model) else {}
        f, points = self._panel.frequency, self._panel.basis.point_names
        log_error = None if error is None else _stress_error(f, response, error)
        rows = []
        for layer, part in parts.items():
            units = stress.CORE_QUANTITIES if layer == CORE else stress.QUANTITIES
            values = (f, part, units, points, log_error, undamped.get(layer), model)
            rows += [{"layer": layer, **row} for row in tables.stress_rows(*values)]
        psd = np.array([parts[layer] for layer in self.layers.names]).reshape(
            -1, len(f), len(points), len(stress.QUANTITIES)
        )
        names = enumerate(stress.QUANTITIES)
        return {f"{name}_psd": np.moveaxis(psd[..., i], 0, 2) for i, name in names}, rows

    def _stress_psds(self, response: PanelResponse) -> dict[str, Array]:
        """Return PSDs of strain and stress in each layer (nf, n_points, 7), and in the core."""
        psd = stress.layer_psd(response, self.layers)
        parts = {layer: psd[:, :, number] for number, layer in enumerate(self.layers.names)}
        core_stress = self._panel.basis.core_stress
        if np.any(core_stress):
            parts[CORE] = stress.core_psd(response, core_stress)
        return parts


def _full_responses(checked: CheckedResponses) -> dict[str, PanelResponse]:
    """Return responses in which dampers couple the modes, for the error of the paper's form."""
    if not checked.panel.settings.is_diagonal:
        return {}
    steady = [
        (case, Request(case.layout.patches, answer.equivalent_damping, answer.apparent_mass))
        for case in checked.cases
        if not isinstance(answer := case.response, UnstableDamping)
    ]
    responses = checked.panel.solver(full=True).responses([request for _, request in steady])
    return {
        case.scenario.label: response.scaled(case.layout.factor)
        for (case, _), response in zip(steady, responses, strict=True)
    }


def _stress_error(
    frequency: Array, response: PanelResponse, error: uncertainty.StandardErrors
) -> Array:
    """Return errors of ln PSD (nf, n_points), correlated over lines like the acceleration's.

    Shifted resonances raise some lines and lower others, so errors of lines cancel in part.
    """
    psd, square = response.acceleration_psd, response.acceleration_rms**2
    common = np.trapezoid(psd * error.log_psd, frequency, axis=0)
    moves = (square > 0) & (common > 0)
    share = np.divide(2 * square * error.log_rms, common, out=np.zeros_like(square), where=moves)
    return np.asarray(error.log_psd * share)


def _refuse_outside(frequency: Array, case: SolvedCase, response: LayoutResponse) -> None:
    for damper, gamma, inside in zip(
        case.dampers, response.acceleration_g, response.inside, strict=True
    ):
        if inside.all():
            continue
        worst = frequency[~inside]
        raise OutsideSimulatedRange(
            f"{case.scenario.label}: C_e is evaluated at {gamma:.3g} g, "
            f"{worst.min():.4g} to {worst.max():.4g} Hz, outside the range of the data "
            f"of {damper.name}; widen its sweep or table, or set damping.level.outside: mark"
        )


def write_csv(path: Path, frame: pd.DataFrame, digits: int = 6) -> None:
    """Write a table with numbers of ``digits`` digits, more where lines would coincide."""
    if FREQUENCY in frame:
        frame = frame.assign(**{FREQUENCY: _distinct(frame[FREQUENCY].to_numpy(), digits)})
    frame.to_csv(path, index=False, float_format=f"%.{digits}g")


def _distinct(frequency: Array, digits: int) -> list[str]:
    """Return frequencies as text, with all digits where two rows would be alike, as at a step."""
    values = frequency.astype(float).tolist()
    texts = [f"{value:.{digits}g}" for value in values]
    alike = {
        place
        for row in range(1, len(values))
        if texts[row - 1] == texts[row] and values[row - 1] != values[row]
        for place in (row - 1, row)
    }
    return [repr(value) if row in alike else texts[row] for row, value in enumerate(values)]
