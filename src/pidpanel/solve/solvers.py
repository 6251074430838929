"""The panel of a study ready to carry any layout of dampers on its patches.

The lines are run through in chunks, for all layouts of a call together, so that memory does not
grow with their number, and no chunk is kept: a call is one run.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pidpanel.arrays import Array
from pidpanel.progress import map_in_forks, with_progress
from pidpanel.solve.dampers import attach_dampers
from pidpanel.solve.excitation import Excitation, MatrixInput, air_at, matrices_at
from pidpanel.solve.lines import root_mean_square
from pidpanel.solve.modal import (
    OVERLAP_CUTOFF,
    BarePanel,
    bare_panels,
    chunks_of_lines,
    panel_in_shapes,
    patch_motions_in_vacuum,
)
from pidpanel.solve.model import PanelResponse, Patches
from pidpanel.solve.motions import Motions, ShapeMotions
from pidpanel.solve.panel import ModalPanel

SEARCH_CUTOFF = 1e-4  # eigenvalues of D dropped in the search for Γ: rms of the patch within 1e-3

# Share of the shapes from which on several patches are solved directly: their low-rank update
# multiplies two matrices of its width in addition, four times the cost of the solve alone.
DIRECT_SHARE = 0.6

Loaded = tuple[int, ...]  # indices of the patches that carry dampers together


def damper_key(patches: Loaded, equivalent_damping: Array, apparent_mass: Array) -> Hashable:
    """Return what is equal where the dampers are."""
    return patches, equivalent_damping.tobytes(), apparent_mass.tobytes()


@dataclass(frozen=True)
class Request:
    """Dampers whose response is requested."""

    patches: Loaded
    # (n_loads, nf) C_e [N s/m³] and m_a [kg/m²]
    equivalent_damping: Array
    apparent_mass: Array
    with_slope: bool = False  # whether to compute the derivatives of the PSDs too

    @property
    def key(self) -> Hashable:
        """Key of all that the response depends on."""
        return self.with_slope, damper_key(
            self.patches, self.equivalent_damping, self.apparent_mass
        )


class PanelSolver:
    """A panel under an excitation, with all that is computed once for several layouts."""

    def __init__(self, panel: ModalPanel, excitation: Excitation) -> None:
        self.panel = panel
        self.excitation = excitation
        self._carriers: dict[Loaded, Patches] = {}
        self._motions: dict[Loaded, Motions] = {}

    def with_lines(self, frequency: Array, points: Array) -> PanelSolver:
        """Return a solver of the same panel on other lines [Hz]."""
        solver = copy(self)
        solver.panel = replace(self.panel, frequency=frequency, points=points)
        return solver

    def with_excitation(self, excitation: Excitation) -> PanelSolver:
        """Return a solver under another excitation; the bare panel stays under this one."""
        _ = self.bare_acceleration_rms
        solver = copy(self)
        solver.excitation, solver._motions = excitation, {}
        return solver

    def motions(self, patches: Loaded) -> Motions:
        """Return the motions of patches loaded together, on the lines of the search."""
        self.prepare([patches])
        return self._motions[patches]

    def carrier(self, patches: Loaded) -> Patches:
        """Return the patches of a set."""
        if patches not in self._carriers:
            self._carriers[patches] = self.panel.patches.subset(patches)
        return self._carriers[patches]

    @cached_property
    def bare_acceleration_rms(self) -> Array:
        """(n_patches,) rms over time and patch of the bare panel's acceleration [m/s²]."""
        panel, lines = self.panel, self.panel.search_frequency
        if panel.air_stiffness is None:
            motion = patch_motions_in_vacuum(
                lines, panel.basis, panel.patches, self.excitation.spectrum(lines), self.excitation
            )
            return root_mean_square(lines, (2 * np.pi * lines[:, None]) ** 4 * motion)
        solved_patches = {index for key in self._motions for index in key}
        self.prepare([(p,) for p in range(panel.patches.count) if p not in solved_patches])
        rms = np.zeros(panel.patches.count)
        for key in sorted(self._motions, key=len, reverse=True):  # one patch alone comes last
            rms[list(key)] = self._motions[key].bare_acceleration_rms()
        return rms

    def cell_acceleration_rms(self, patches: Loaded, covariance: Array) -> Array:
        """Return the lowest and the highest rms acceleration of a cell of each loaded patch."""
        extremes = np.full((len(patches), 2), np.nan)
        cells = self.panel.cells
        if cells is None:
            return extremes
        motions = self.motions(patches)
        for load, patch in enumerate(patches):
            inside = cells.parts.subset(np.flatnonzero(cells.patch == patch).tolist())
            square = []
            for rows, area in zip(inside.factors(0.0), inside.area, strict=True):
                factor = motions.coordinates.inverse @ rows
                square.append(np.sum(factor * (covariance @ factor)) / area)
            if square:
                extremes[load] = np.sqrt([min(square), max(square)])
        return extremes

    def prepare(self, layouts: Sequence[Loaded]) -> None:
        """Make the motions of several sets of patches ready together, on the lines of the search.

        The bare panel is solved once for all sets that a low-rank update carries.
        """
        panel, lines = self.panel, self.panel.search_frequency
        keys = [key for key in dict.fromkeys(layouts) if key and key not in self._motions]
        reduced = [key for key in keys if not self._is_direct(key, SEARCH_CUTOFF)]
        if reduced:
            no_points = np.zeros((0, 1, panel.patches.shapes))
            panels = bare_panels(
                lines, panel.basis, [self.carrier(key) for key in reduced], no_points,
                self.excitation.spectrum(lines), self.excitation, panel.air_stiffness,
                overlap_cutoff=SEARCH_CUTOFF,
            )  # fmt: skip
            for key, bare in zip(reduced, panels, strict=True):
                self._motions[key] = Motions(bare, self.carrier(key).area)
        for key in keys:
            if key not in self._motions:
                self._motions[key] = ShapeMotions(
                    lines, panel.basis, self.carrier(key), self.excitation, panel.air_stiffness
                )

    def responses(self, requests: Sequence[Request]) -> list[PanelResponse]:
        """Return the response with each of several sets of dampers, in one run over the lines.

        Sets that are equal, such as a mass at several sound levels, are solved once.

        Raises
        ------
        UnstableDamping
            If C_e is negative.
        """
        distinct = {request.key: request for request in requests}
        frequency, (n_points, m, _) = self.panel.frequency, self.panel.points.shape
        count, responses = frequency.size, {}
        for key, request in distinct.items():
            cross_psd, slope = np.empty((count, n_points, m, m), complex), None
            if request.with_slope:
                slope = np.empty((len(request.patches), count, n_points), complex)
            responses[key] = PanelResponse(frequency, cross_psd, slope)
        chunks = chunks_of_lines(count, self.panel.patches.shapes)

        def part_of_range(lines: slice) -> list[PanelResponse]:
            panels = self._on_lines(lines, [request.patches for request in distinct.values()])
            return [
                attach_dampers(
                    panels[request.patches],
                    request.equivalent_damping[:, lines],
                    request.apparent_mass[:, lines],
                    request.with_slope,
                )
                for request in distinct.values()
            ]

        parts_of_range = map_in_forks(part_of_range, chunks)
        for lines, parts in zip(
            with_progress(chunks, "parts of the frequency range"), parts_of_range, strict=True
        ):
            for response, part in zip(responses.values(), parts, strict=True):
                response.cross_psd[lines] = part.cross_psd
                if response.slope is not None:
                    response.slope[:, lines] = part.slope
        return [responses[request.key] for request in requests]

    def _on_lines(self, lines: slice, sets: Sequence[Loaded]) -> dict[Loaded, BarePanel]:
        """Return what carries each set of patches on a chunk of lines."""
        panel, frequency, diagonal = self.panel, self.panel.frequency[lines], self.panel.is_diagonal
        keys = dict.fromkeys(sets)
        direct = [key for key in keys if diagonal or self._is_direct(key, OVERLAP_CUTOFF)]
        low_rank = [key for key in keys if key not in direct]
        spectrum = self.excitation.spectrum(frequency)
        force: MatrixInput = self.excitation
        panels: dict[Loaded, BarePanel] = {}
        if direct:
            n = panel.patches.shapes
            force = matrices_at(force, frequency, slice(None), n)
            # the paper's panel is in vacuum
            air = None if diagonal else air_at(panel.air_stiffness, frequency, slice(None), n)
            for key in direct:
                carrier = self.carrier(key)
                weight = carrier.diagonal if diagonal else carrier.overlap
                panels[key] = panel_in_shapes(
                    frequency, panel.basis, weight, panel.points, spectrum, force, air
                )
        if low_rank:
            carriers = [self.carrier(key) for key in low_rank]
            bare = bare_panels(
                frequency, panel.basis, carriers, panel.points, spectrum, force, panel.air_stiffness
            )
            panels |= zip(low_rank, bare, strict=True)
        return panels

    def _is_direct(self, patches: Loaded, cutoff: float) -> bool:
        if not patches:
            return False
        width = self.carrier(patches).coordinates(cutoff).columns.shape[1]
        return width > DIRECT_SHARE * self.panel.patches.shapes
