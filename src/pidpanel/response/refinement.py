"""The basis of a study's responses: checked in every scenario, and widened until it is right."""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

from pidpanel.arrays import Array, Complexes
from pidpanel.geometry.plane_mesh import boundary_edges, cell_areas
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.matrices import StoredPlate
from pidpanel.panel.resolution import ORDER, BoundaryStrain, element_sizes
from pidpanel.provenance.results import read_netcdf
from pidpanel.response.cases import (
    CasePlan,
    ResponseScenario,
    SolvedCase,
    heaviest_dampers,
    plan_cases,
    resolve,
)
from pidpanel.response.panel import ExcitationSource, ResponsePanel, WaveShift, widen
from pidpanel.response.truncation import truncation_errors
from pidpanel.solve.basis_error import (
    BasisCheck,
    ForceAt,
    basis_shapes,
    check_basis,
    lines_to_try,
    pressure_errors,
    sufficient_basis,
)
from pidpanel.solve.layout import LayoutResponse, SearchResults
from pidpanel.solve.mesh_error import MeshError, MeshShift, mesh_error, point_shifts, shift_of_modes
from pidpanel.solve.model import UnstableDamping
from pidpanel.solve.receptances import patch_stiffness
from pidpanel.solve.sharpness import LoadedModes, flanks, loaded_modes
from pidpanel.solve.solvers import PanelSolver, damper_key

# Largest shift of a resonance by the mesh over that of `resolution.ElementKind`: waves along
# the edges of rectangles have 1.2 times that.
MARGIN = 1.25

# Damping ratio of the sharpest resonance below which lines are tried on flanks too: between
# resonances that far apart a shifted one is not seen.
SHARP = 5e-3

TINY = 1e-300  # energy where a mode is at rest
# Largest curvature of feet over that of the panel; those that turn have 2e-4 by rounding.
UNBENT = 2e-3
RESTS = 1e-9  # largest motion of a vertex on a support, over that of the panel


@dataclass(frozen=True)
class CheckedResponses:
    """Responses with the error of the basis in which they were computed."""

    panel: ResponsePanel
    solver: PanelSolver
    cases: Sequence[SolvedCase]
    # (n_cases,) largest relative error of the PSD of a point at the lines tried, of the scenario,
    # its bare panel and its dead weight; NaN where there is no response
    basis_error: Array
    further_shapes: Array  # (n_free, k) what was added to the basis of the panel stage
    # (n_cases,) what the mesh does to the PSDs and rms values; None where there is no response
    mesh_error: Sequence[MeshError | None]


class _Attempt(NamedTuple):
    """What belongs to a basis: its errors by case, and the shapes that joined it."""

    panel: ResponsePanel
    solver: PanelSolver
    plan: CasePlan
    motions: SearchResults
    errors: Array
    further_shapes: Array


def checked_responses(
    panel: ResponsePanel,
    plate: StoredPlate,
    scenarios: Sequence[ResponseScenario],
    source: ExcitationSource,
) -> CheckedResponses:
    """Return every scenario, in a basis whose error is within `basis_error.ALLOWED`.

    Parameters
    ----------
    source
        Source of the excitation on shapes that join the basis, and on all elements.
    """
    panel = resolve(panel, heaviest_dampers(panel, scenarios))
    if plate.is_of_modes:
        return _in_modes(panel, plate, scenarios, source)

    def tried(further_shapes: Array, attempt: int) -> tuple[_Attempt, list[BasisCheck]]:
        wider = widen(panel, plate, further_shapes, source)
        plan = plan_cases(wider, scenarios)
        columns = len(plan.layouts) * len(panel.basis.point_names)
        lines = lines_to_try(
            panel.settings.frequency_range, plate.stiffness.shape[0], columns, attempt
        )
        solver, plain = wider.solver(rms_only=True), plan.response_alone()
        motions = plan.search(solver)  # do not depend on the lines of the result
        if wider.resolved_ratio < SHARP:
            lines = _with_flanks(lines, wider, solver, plain.solve(solver, motions))
        solver = solver.with_lines(lines, wider.deflection_at_points)
        cases = plain.solve(solver, motions)
        check, rows = _check(panel, wider, plate, further_shapes, cases, lines, source.force_at)
        worst = [check.largest[row].max() if row else np.nan for row in rows]
        return _Attempt(wider, solver, plan, motions, np.array(worst), further_shapes), [check]

    start = np.zeros((plate.shapes.shape[0], 0))
    (wider, checked, plan, motions, worst, further_shapes), _ = sufficient_basis(start, tried)
    solver = checked.with_lines(wider.frequency, wider.motion_at_points)
    cases = plan.solve(solver, motions)
    errors = _mesh_errors(wider, cases, mesh_shifts(wider, scenarios))
    return CheckedResponses(wider, solver, cases, worst, further_shapes, errors)


def _in_modes(
    panel: ResponsePanel,
    plate: StoredPlate,
    scenarios: Sequence[ResponseScenario],
    source: ExcitationSource,
) -> CheckedResponses:
    """Return every scenario in the modes of a file, with what their number leaves out."""
    no_shapes = np.zeros((plate.shapes.shape[0], 0))
    panel = widen(panel, plate, no_shapes, source)
    plan = plan_cases(panel, scenarios)
    worst = truncation_errors(panel, plan)
    solver = panel.solver()
    cases = plan.solve(solver)
    errors = _mesh_errors(panel, cases, mesh_shifts(panel, scenarios))
    return CheckedResponses(panel, solver, cases, worst, no_shapes, errors)


def mesh_shifts(
    panel: ResponsePanel, scenarios: Sequence[ResponseScenario]
) -> dict[str, MeshShift]:
    """Return frequency errors due to the mesh by scenario, each with its heaviest dampers."""
    f, basis = panel.frequency, panel.basis
    shifts: dict[str, MeshShift] = {}
    for scenario in scenarios:
        mass = heaviest_dampers(panel, [scenario])
        modes = loaded_modes(panel.modal, basis.patch_overlap, mass, panel.mass_per_area)
        up_to = modes.frequency <= 2 * f[-1]
        modes = LoadedModes(*(values[..., up_to] for values in modes))
        bare, patches = np.split(mode_shifts(basis, modes, mass, panel.wave_shift), [1])
        points = point_shifts(basis.reactions @ modes.shape, 2 * np.pi * modes.frequency)
        shift = shift_of_modes(f, modes, MARGIN * bare[0], MARGIN * patches, MARGIN * points)
        shifts[scenario.label] = MeshShift(*shift, panel.point_refinement_error)
    return shifts


def mode_shifts(basis: PanelBasis, modes: LoadedModes, mass: Array, wave_shift: WaveShift) -> Array:
    """Return the shifts of modes by the mesh of the panel and by that of each patch (1 + n_p, n).

    The size of the elements is the mean over the kinetic energy of the mode there.
    """
    size = element_sizes(basis.vertex_position, basis.cells)
    motion = basis.shape_at_vertices @ modes.shape
    area = np.abs(cell_areas(basis.vertex_position, basis.cells))
    energy = area[:, None] * np.mean(motion[basis.cells] ** 2, axis=1)
    if basis.frequency_shift is not None:  # mode by mode, the mass of dampers left out
        # the modes come first; a translation of the supports comes last
        count = int(np.argmax(np.append(basis.is_residual, True)))
        count = min(count, len(basis.frequency_shift))
        rise = np.maximum.accumulate(basis.frequency_shift[:count])
        shift = np.interp(modes.frequency, basis.natural_frequency[:count], rise)
        return np.tile(shift / MARGIN, (1 + len(mass), 1))
    strains: list[BoundaryStrain | None] = [None] * len(modes.frequency)
    if basis.quadrature_normal is None:  # of a plate
        parts = zip(*edge_curvature(basis, modes), foot_bending(basis, modes), strict=True)
        strains = [BoundaryStrain(*of_mode) for of_mode in parts]
    rows = []
    for cells, extra in zip(
        (slice(None), *basis.cell_in_patch), (0.0, *mass.tolist()), strict=True
    ):
        weight = energy[cells] + TINY
        edge = (size[cells] ** ORDER @ weight / weight.sum(axis=0)) ** (1 / ORDER)
        of_modes = zip(edge.tolist(), modes.frequency.tolist(), strains, strict=True)
        rows.append([wave_shift(h, f, extra, strain=strain) for h, f, strain in of_modes])
    return np.array(rows)


def edge_curvature(basis: PanelBasis, modes: LoadedModes) -> tuple[Array, Array]:
    """Return ∮ κ² ds/(2 ω²) of modes of 1 kg along edges, each (n_modes,) [1/N].

    The first is that of the twist 2κ_nt along free edges, of which shear relieves a layer; the
    second that of κ_nn along the others, which bends such a layer. An edge is free where it moves.
    """
    edges = boundary_edges(basis.cells)
    moves = np.abs(basis.shape_at_vertices).max(axis=1, initial=0.0) > RESTS
    free = moves[edges].all(axis=1)
    step = np.diff(basis.vertex_position[edges], axis=1)[:, 0]
    length = np.linalg.norm(step, axis=1)
    tx, ty = step.T / length
    twist = np.stack([2 * tx * ty, -2 * tx * ty, ty**2 - tx**2], axis=1)
    normal = np.stack([ty**2, tx**2, -tx * ty], axis=1)
    omega = 2 * np.pi * modes.frequency
    sums = []
    for weight, part in ((twist, free), (normal, ~free)):
        squares = np.zeros(modes.shape.shape[1])
        for end in (0, 1):
            curvature = basis.curvature_at_vertices[edges[part, end]]
            found = np.einsum("ec,ecn->en", weight[part], curvature) @ modes.shape
            squares += length[part] @ found**2 / 2
        sums.append(np.divide(squares, 2 * omega**2, out=np.zeros_like(omega), where=omega > 0))
    return sums[0], sums[1]


def foot_bending(basis: PanelBasis, modes: LoadedModes) -> Array:
    """Return ∫ κκᵀ dA/(2 ω²) of modes of 1 kg over the elements at feet (n_modes, 3, 3).

    These are the elements with a vertex inside where no shape is bent: those at the rims on thin
    plates, whose curvature is held there, and in other sections those of the feet, with half of it.
    """
    size = np.abs(basis.curvature_at_vertices).max(axis=(1, 2), initial=0.0)
    is_held = size < UNBENT * size.max(initial=0.0)
    is_held[boundary_edges(basis.cells)] = False  # corners of clamped edges
    cells = basis.cells[is_held[basis.cells].any(axis=1)]
    area = np.abs(cell_areas(basis.vertex_position, cells))
    curvature = np.einsum("vkn,nm->vkm", basis.curvature_at_vertices, modes.shape)[cells]
    omega = 2 * np.pi * modes.frequency
    share = np.divide(1, 2 * omega**2, out=np.zeros_like(omega), where=omega > 0)
    return np.einsum("c,cvkn,cvln,n->nkl", area, curvature, curvature, share) / cells.shape[1]


def _mesh_errors(
    panel: ResponsePanel, cases: Sequence[SolvedCase], shifts: Mapping[str, MeshShift]
) -> list[MeshError | None]:
    """Return the error of each case, with the shifts of its scenario by `mesh_shifts`."""
    f = panel.frequency
    spectrum = panel.excitation.spectrum(f)
    errors: list[MeshError | None] = []
    for case in cases:
        if isinstance(case.response, UnstableDamping):
            errors.append(None)
            continue
        psd = case.response.response.acceleration_psd
        errors.append(mesh_error(f, psd, spectrum, shifts[case.scenario.label]))
    return errors


def _with_flanks(
    lines: Array, panel: ResponsePanel, solver: PanelSolver, cases: Sequence[SolvedCase]
) -> Array:
    """Return the lines with as many on the flanks of resonances."""
    answers = [
        answer.response.acceleration_psd
        for case in cases
        for answer in (case.response, case.bare, case.dead_weight)
        if isinstance(answer, LayoutResponse)
    ]
    flank_lines = flanks(solver.panel.frequency, answers, panel.resolved_ratio, len(lines))
    return np.unique(np.concatenate([lines, flank_lines]))


def write_further_shapes(path: Path, further_shapes: Array, attributes: dict[str, str]) -> None:
    """Write what was added to the basis of the panel stage (n_free, k)."""
    # NetCDF 3 has no dimension of length 0: the first column is empty
    stored = np.pad(further_shapes, ((0, 0), (1, 0)))
    variable = (("coordinate", "shape"), stored, {"units": "1"})
    xr.Dataset({"left_out": variable}, attrs=attributes).to_netcdf(path, engine="scipy")


def read_further_shapes(path: Path) -> Array:
    """Read what `write_further_shapes` wrote."""
    return read_netcdf(path, ["left_out"])["left_out"].to_numpy().astype(np.float64)[:, 1:]


def _check(
    panel: ResponsePanel,
    wider: ResponsePanel,
    plate: StoredPlate,
    further_shapes: Array,
    cases: Sequence[SolvedCase],
    lines: Array,
    force_at: ForceAt,
) -> tuple[BasisCheck, list[list[int]]]:
    """Return the check of all solutions, and the rows of it that belong to each case."""
    rows: dict[Hashable, int] = {}
    answers: list[LayoutResponse] = []

    def row(answer: LayoutResponse | UnstableDamping | None) -> list[int]:
        """Return the row of an answer: the same for equal dampers, whatever the sound level."""
        if answer is None or isinstance(answer, UnstableDamping):
            return []
        loads = tuple(answer.patches.tolist())
        key = damper_key(loads, answer.equivalent_damping, answer.apparent_mass)
        if key not in rows:
            rows[key] = len(answers)
            answers.append(answer)
        return [rows[key]]

    by_case = [
        row(case.response) + row(case.bare) + row(case.dead_weight) if row(case.response) else []
        for case in cases
    ]
    shapes = plate.shapes
    if further_shapes.shape[1]:
        shapes = basis_shapes(panel.basis, plate, further_shapes).vectors.astype(np.float32)
    check = check_basis(
        wider.basis,
        plate,
        shapes,
        pressure_errors(wider.basis, plate, wider.excitation, force_at),
        panel.settings.damping_ratio,
        panel.settings.frequency_range[1],
        lines,
        np.array([stiffness_on_patches(wider, answer) for answer in answers]),
    )
    return check, by_case


def stiffness_on_patches(panel: ResponsePanel, response: LayoutResponse) -> Complexes:
    """Return s (n_patches, nf) [N/m³] on the lines: of its loads the mean over their areas."""
    area, frequency = panel.load_area(response), response.response.frequency
    values = np.zeros((2, len(panel.basis.patch_names), frequency.size))
    patches = panel.carriers[response.patches]
    for load, patch in enumerate(patches.tolist()):
        share = area[load] / area[patches == patch].sum()
        values[0, patch] += share * response.equivalent_damping[load]
        values[1, patch] += share * response.apparent_mass[load]
    return patch_stiffness(frequency, *values)
