"""The panel of a study ready to carry any layout of dampers on its patches.

The lines are run through in chunks, for all layouts of a call together, so that memory does not
grow with their number; what fits into `HELD_BYTES` is kept between calls.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.progress import tracked
from pidpanel.solve.dampers import acceleration_slope, attach_dampers
from pidpanel.solve.diagonal import DiagonalMotions, diagonal_response, diagonal_slope
from pidpanel.solve.direct import DirectMotions, DirectPanel
from pidpanel.solve.in_air import PanelInAir, SmoothStiffness
from pidpanel.solve.lines import root_mean_square
from pidpanel.solve.modal import (
    OVERLAP_CUTOFF,
    BarePanel,
    MatrixInput,
    bare_panels,
    checked_motions,
    chunks_of_lines,
    joined,
    matrices_at,
    patch_motions_in_vacuum,
)
from pidpanel.solve.model import ModalBasis, Patches, Response
from pidpanel.solve.motions import Motions, ReducedMotions

SEARCH_CUTOFF = 1e-4
"""Eigenvalues of D dropped in the search for Γ: rms of the patch within 1e-3."""

DIRECT_SHARE = 0.6
"""Share of the shapes from which on several patches are solved directly: their low-rank update
multiplies two matrices of its width beside the solve, four times the cost of the solve alone."""

HELD_BYTES = 400e6
"""Most memory for the bare panel on the lines of the result, and for the matrices of direct solves
on those of either the result or a search, each."""

Loaded = tuple[int, ...]
"""Indices of the patches that carry dampers together."""


@dataclass(frozen=True)
class PanelInField:
    """A panel with patches in its sound.

    Parameters
    ----------
    basis
        Shapes of the bare panel.
    patches
        All patches that may be loaded.
    pressure_psd
        S_p [Pa²/Hz] over frequencies (nf,) [Hz].
    modal_force, air_stiffness
        As of `modal.bare_panels`: functions of frequency or one matrix.
    cells
        Parts of the patches over which the motion is looked at beside the patch's mean; None for
        none.
    cell_patch
        (n_cells,) the patch of each cell.
    """

    basis: ModalBasis
    patches: Patches
    pressure_psd: Callable[[Array], Array]
    modal_force: MatrixInput
    air_stiffness: MatrixInput | None = None
    cells: Patches | None = None
    cell_patch: Index | None = None


@dataclass(frozen=True)
class Request:
    """Dampers whose response is asked for.

    Parameters
    ----------
    patches
        Indices of the patches.
    equivalent_damping, apparent_mass
        (n_loads, nf) C_e [N s/m³] and m_a [kg/m²].
    with_slope
        Whether how the PSDs follow the dampers is asked for too.
    """

    patches: Loaded
    equivalent_damping: Array
    apparent_mass: Array
    with_slope: bool = False


@dataclass(frozen=True)
class Answer:
    """A response, and t (n_loads, nf, n_points) of `dampers.acceleration_slope` if asked for."""

    response: Response
    slope: Complexes | None


class PanelWithLayouts(ABC):
    """What both solvers have in common: the search for Γ.

    Parameters
    ----------
    panel
        The panel in its sound.
    frequency
        (nf,) lines of the result [Hz].
    motion_at_points
        (n_points, m, n) as of `modal.bare_panels`.
    search_frequency
        Fewer lines, for the search of Γ [Hz].

    Attributes
    ----------
    searched
        What the search found, by layout: it does not depend on the lines of the result.
    """

    def __init__(
        self,
        panel: PanelInField,
        frequency: Array,
        motion_at_points: ArrayLike,
        search_frequency: Array,
    ) -> None:
        self.panel = panel
        self.frequency = frequency
        self.search_frequency = search_frequency
        self._points = checked_motions(motion_at_points, panel.patches.shapes)
        self._carriers: dict[Loaded, Patches] = {}
        self._motions: dict[Loaded, Motions] = {}
        self.searched: dict[Hashable, Any] = {}

    def on(self, frequency: Array, motion_at_points: ArrayLike) -> Self:
        """Return a solver of the same panel on other lines, for which the search is done.

        Parameters are those of the class.
        """
        other = type(self)(self.panel, frequency, motion_at_points, self.search_frequency)
        other._carriers, other._motions, other.searched = (
            self._carriers, self._motions, self.searched,
        )  # fmt: skip
        if "bare_acceleration_rms" in self.__dict__:
            other.__dict__["bare_acceleration_rms"] = self.bare_acceleration_rms
        return other

    def in_field(self, panel: PanelInField) -> Self:
        """Return a solver on the same lines in another field; the bare panel stays in this one."""
        other = type(self)(panel, self.frequency, self._points, self.search_frequency)
        other._carriers = self._carriers
        other.__dict__["bare_acceleration_rms"] = self.bare_acceleration_rms
        return other

    @abstractmethod
    def prepare(self, layouts: Sequence[Loaded]) -> None:
        """Make the motions of several sets of patches ready together."""

    @abstractmethod
    def responses(self, requests: Sequence[Request]) -> list[Answer]:
        """Return the response with each of several sets of dampers, in one run over the lines.

        Raises
        ------
        UnstableDamping
            Where C_e is negative.
        """

    def motions(self, patches: Loaded) -> Motions:
        """Return the motions of patches loaded together, on the lines of the search."""
        self.prepare([patches])
        return self._motions[patches]

    def carrier(self, patches: Loaded) -> Patches:
        """Return the patches of a set."""
        if patches not in self._carriers:
            self._carriers[patches] = self.panel.patches.only(patches)
        return self._carriers[patches]

    @cached_property
    def bare_acceleration_rms(self) -> Array:
        """(n_patches,) rms over time and patch of the bare panel's acceleration [m/s²]."""
        known = {index for key in self._motions for index in key}
        every = range(self.panel.patches.count)
        self.prepare([(index,) for index in every if index not in known])
        rms = np.zeros(len(every))
        for key in sorted(self._motions, key=len, reverse=True):  # one patch alone comes last
            rms[list(key)] = self._motions[key].bare_acceleration_rms()
        return rms

    def cell_acceleration_rms(self, patches: Loaded, covariance: Array) -> Array:
        """Return the lowest and the highest rms acceleration of a cell of each loaded patch.

        Parameters
        ----------
        patches
            The loaded patches.
        covariance
            `Motions.acceleration_covariance` with their dampers.

        Returns
        -------
        (n_loads, 2) [m/s²]; NaN for a patch without cells.
        """
        found = np.full((len(patches), 2), np.nan)
        cells, owner = self.panel.cells, self.panel.cell_patch
        if cells is None or owner is None:
            return found
        motions = self.motions(patches)
        for load, patch in enumerate(patches):
            own = cells.only(np.flatnonzero(owner == patch).tolist())
            square = [
                np.sum(seen * (covariance @ seen)) / area
                for seen, area in zip(map(motions.seen, own.factors(0.0)), own.area, strict=True)
            ]
            if square:
                found[load] = np.sqrt([min(square), max(square)])
        return found


class PanelSolver(PanelWithLayouts):
    """Panel with its full modal damping matrix; parameters are those of `PanelWithLayouts`."""

    @cached_property
    def _held(self) -> dict[tuple[Loaded, int], BarePanel]:
        """What is kept between calls, by the patches and the chunk of lines."""
        return {}

    @cached_property
    def _held_bytes(self) -> dict[Loaded, float]:
        """Size of it by the patches; 0 where there is no room."""
        return {}

    def prepare(self, layouts: Sequence[Loaded]) -> None:
        """Solve the bare panel on the lines of the search, once for several sets of patches."""
        lines, panel = self.search_frequency, self.panel
        wanted = [key for key in dict.fromkeys(layouts) if key and key not in self._motions]
        reduced = [key for key in wanted if not self._is_direct(key, SEARCH_CUTOFF)]
        for key, one in self._of_the_result(reduced).items():
            self._motions[key] = ReducedMotions(one)
        reduced = [key for key in reduced if key not in self._motions]
        if reduced:
            nothing = np.zeros((0, 1, panel.patches.shapes))
            made = bare_panels(
                lines, panel.basis, [self.carrier(key) for key in reduced], nothing,
                panel.pressure_psd(lines), panel.modal_force, panel.air_stiffness,
                overlap_cutoff=SEARCH_CUTOFF,
            )  # fmt: skip
            for key, one in zip(reduced, made, strict=True):
                self._motions[key] = ReducedMotions(one)
        for key in wanted:
            if key not in self._motions:
                sound, carrier = panel.pressure_psd(lines), self.carrier(key)
                direct = DirectPanel(
                    lines, panel.basis, carrier, sound, panel.modal_force, panel.air_stiffness
                )
                self._motions[key] = DirectMotions(direct, HELD_BYTES)

    def _of_the_result(self, wanted: Sequence[Loaded]) -> dict[Loaded, BarePanel]:
        """Return the bare panels of a search on the lines of the result, which then keeps them."""
        wanted = [key for key in wanted if not self._is_direct(key, OVERLAP_CUTOFF)]
        if not wanted or not np.array_equal(self.frequency, self.search_frequency):
            return {}
        chunks = chunks_of_lines(self.frequency.size, self.panel.patches.shapes)
        for number, lines in enumerate(chunks):
            self._on_lines(number, lines, wanted)
        return {
            key: joined([self._held[key, number] for number in range(len(chunks))]).with_fewer(
                SEARCH_CUTOFF
            )
            for key in wanted
            if (key, 0) in self._held
        }

    @cached_property
    def bare_acceleration_rms(self) -> Array:
        """(n_patches,) rms over time and patch of the bare panel's acceleration [m/s²]."""
        panel, lines = self.panel, self.search_frequency
        if panel.air_stiffness is not None:
            return super().bare_acceleration_rms
        motion = patch_motions_in_vacuum(
            lines, panel.basis, panel.patches, panel.pressure_psd(lines), panel.modal_force
        )
        return root_mean_square(lines, (2 * np.pi * lines[:, None]) ** 4 * motion)

    def responses(self, requests: Sequence[Request]) -> list[Answer]:
        """Return the response with each of several sets of dampers, see `PanelWithLayouts`."""
        count, (n_points, m, _) = self.frequency.size, self._points.shape
        psds = [np.empty((count, n_points, m, m), complex) for _ in requests]
        slopes = [
            np.empty((len(one.patches), count, n_points), complex) if one.with_slope else None
            for one in requests
        ]
        chunks = list(enumerate(chunks_of_lines(count, self.panel.patches.shapes)))
        for number, lines in tracked(chunks, "parts of the frequency range"):
            reduced, direct = self._on_lines(number, lines, [one.patches for one in requests])
            for one, psd, slope in zip(requests, psds, slopes, strict=True):
                dampers = one.equivalent_damping[:, lines], one.apparent_mass[:, lines]
                if one.patches in direct:
                    panel = direct[one.patches]
                    psd[lines] = panel.response(self._points, *dampers).cross_psd
                    if slope is not None:
                        slope[:, lines] = panel.slope(self._points, *dampers)
                else:
                    bare = reduced[one.patches]
                    psd[lines] = attach_dampers(bare, *dampers).cross_psd
                    if slope is not None:
                        slope[:, lines] = acceleration_slope(bare, *dampers)
        return [
            Answer(Response(self.frequency, psd), slope)
            for psd, slope in zip(psds, slopes, strict=True)
        ]

    def _on_lines(
        self, number: int, lines: slice, wanted: Sequence[Loaded]
    ) -> tuple[dict[Loaded, BarePanel], dict[Loaded, DirectPanel]]:
        """Return what carries each set of patches on a chunk of lines."""
        keys = list(dict.fromkeys(wanted))
        direct = [key for key in keys if self._is_direct(key, OVERLAP_CUTOFF)]
        missing = [key for key in keys if key not in direct and (key, number) not in self._held]
        panel, sound = self.panel, self._sound[lines]
        made: dict[Loaded, BarePanel] = {}
        held = [key for key in self._held_bytes if (key, number) in self._held]
        if () in missing and held:
            missing.remove(())
            made[()] = self._held[held[0], number].without_patches(self.carrier(()))
        if missing or direct:
            n, frequency = panel.patches.shapes, self.frequency
            force, air = panel.modal_force, panel.air_stiffness
            if direct:
                force, air = self._held_matrices
            if direct or not callable(force):  # a function may know a shorter form of G
                force = matrices_at(force, frequency, lines, n)
            if air is not None and (direct or not callable(air)):
                air = matrices_at(air, frequency, lines, n)
        if missing:
            carriers = [self.carrier(key) for key in missing]
            bare = bare_panels(
                self.frequency[lines], panel.basis, carriers, self._points, sound, force,
                self._in_air or air,
            )  # fmt: skip
            made |= zip(missing, bare, strict=True)
            for key, one in zip(missing, bare, strict=True):
                if self._has_room(key, one):
                    self._held[key, number] = one
        reduced = {
            key: made[key] if key in made else self._held[key, number]
            for key in keys
            if key not in direct
        }
        return reduced, {
            key: DirectPanel(
                self.frequency[lines], panel.basis, self.carrier(key), sound, force, air
            )
            for key in direct
        }

    @cached_property
    def _in_air(self) -> PanelInAir | None:
        """The panel in air on all lines; None in vacuum or where the air is not smooth."""
        air = self.panel.air_stiffness
        if not isinstance(air, SmoothStiffness):
            return None
        return PanelInAir(self.frequency, self.panel.basis, air)

    @cached_property
    def _sound(self) -> Array:
        return self.panel.pressure_psd(self.frequency)

    def _has_room(self, key: Loaded, one: BarePanel) -> bool:
        """Whether the bare panel with these patches is kept, on all lines or on none."""
        if key not in self._held_bytes:
            a_line = sum(part[0].nbytes for part in (one.receptance, one.patch_psd, one.point_psd))
            size = float(a_line * self.frequency.size)
            fits = sum(self._held_bytes.values()) + size <= HELD_BYTES
            self._held_bytes[key] = size if fits else 0.0
        return self._held_bytes[key] > 0

    @cached_property
    def _held_matrices(self) -> tuple[MatrixInput, MatrixInput | None]:
        """Return G and the air as arrays where there is room, else as they are given."""
        panel, n, lines = self.panel, self.panel.patches.shapes, self.frequency
        if lines.size * n * n * (8 if panel.air_stiffness is None else 24) > HELD_BYTES:
            return panel.modal_force, panel.air_stiffness
        every, air = slice(None), panel.air_stiffness
        return (
            matrices_at(panel.modal_force, lines, every, n),
            None if air is None else matrices_at(air, lines, every, n),
        )

    def _is_direct(self, patches: Loaded, cutoff: float) -> bool:
        if not patches:
            return False
        width = self.carrier(patches).coordinates(cutoff).columns.shape[1]
        return width > DIRECT_SHARE * self.panel.patches.shapes


class DiagonalSolver(PanelWithLayouts):
    """The paper's form (Eq. 9-15): modes uncoupled by the dampers, in vacuum.

    Parameters are those of `PanelWithLayouts`.
    """

    def prepare(self, layouts: Sequence[Loaded]) -> None:
        """Make the motions of several sets of patches ready together."""
        lines, panel = self.search_frequency, self.panel
        for key in layouts:
            if key and key not in self._motions:
                self._motions[key] = DiagonalMotions(
                    lines, panel.basis, self.carrier(key), panel.pressure_psd(lines),
                    panel.modal_force,
                )  # fmt: skip

    def responses(self, requests: Sequence[Request]) -> list[Answer]:
        """Return the response with each of several sets of dampers, see `PanelWithLayouts`."""
        panel, lines = self.panel, self.frequency
        sound = panel.pressure_psd(lines)
        answers = []
        for one in requests:
            inputs = (
                lines, panel.basis, self.carrier(one.patches), self._points, sound,
                panel.modal_force, one.equivalent_damping, one.apparent_mass,
            )  # fmt: skip
            slope = diagonal_slope(*inputs) if one.with_slope else None
            answers.append(Answer(diagonal_response(*inputs), slope))
        return answers
