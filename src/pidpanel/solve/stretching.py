"""Response of a panel that its deflection stretches, by equivalent linearisation.

The membrane energy U = ½ Σ A_ijkl q_i q_j q_k q_l of some modes (`pidpanel.panel.stretching`) is
replaced by the stiffness whose force errs least in the mean square; under Gaussian motion of
covariance C that is

    K_ij = E[∂²U/∂q_i ∂q_j] = 2 A_ijkl C_kl + 4 A_ikjl C_kl,

and C follows from the response with it (Roberts and Spanos, Random Vibration and Statistical
Linearization, 1990, ch. 4 and 6). The loss of the modes stays as it is.

The error has two parts for each mode, both from its share β of K in the stiffness. A mode alone
under white noise, whose density is exp(−V/T) exactly, moves more by `duffing_excess`, at most
8.2 %; modes together by less, since the force of many is closer to Gaussian, and those of little
motion take energy from the others. Under a load whose PSD falls as f^−p the mode meets less of it
the farther it moves; by the stochastic averaging of the energy of a mode alone
(p(E) ∝ period/T(E) exp(−∫ dE/T(E))) its rms changes by a further `SLOPE` β p.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from pidpanel.arrays import Array
from pidpanel.panel.matrices import Stretching
from pidpanel.solve.layout import DamperLayout, by_force, evaluate_dampers, sine_accelerations_g
from pidpanel.solve.lines import trapezoid_weights
from pidpanel.solve.modal import BarePanel, bare_panels
from pidpanel.solve.model import Patches
from pidpanel.solve.receptances import Receptances, patch_stiffness, traces
from pidpanel.solve.search import LinearisationError
from pidpanel.solve.solvers import SEARCH_CUTOFF, PanelSolver

# Relative change of the stiffness at which the iteration ends, and its most steps.
CONVERGED, STEPS = 1e-6, 200

# Change of ln Γ of the patches at which their dampers are no longer evaluated again, and how often
# they are at most.
SETTLED, ROUNDS = 0.01, 6

# Change of ln rms of a mode by the slope p of its load, over β p: 0.115 to 0.145 for β up to 0.7.
SLOPE = 0.13

# Distance of two frequencies between which a load has its slope, at least: a third octave.
LEAST_RATIO = 2 ** (1 / 3)


def gaussian_stiffness(tensor: Array, covariance: Array) -> Array:
    """Return E[∂²U/∂q_i ∂q_j] (n, n) [N/m] of A (n, n, n, n) [N/m³] and C (n, n) [m²].

    Examples
    --------
    >>> gaussian_stiffness(np.full((1, 1, 1, 1), 2.0), np.full((1, 1), 0.5))
    array([[6.]])
    """
    direct = np.einsum("ijkl,kl->ij", tensor, covariance)
    return np.asarray(2 * direct + 4 * np.einsum("ikjl,kl->ij", tensor, covariance))


def linearised_stiffness(
    tensor: Array, covariance_with: Callable[[Array], Array], start: Array | None = None
) -> Array:
    """Return the stiffness K (n, n) [N/m] that reproduces itself.

    Parameters
    ----------
    tensor
        (n, n, n, n) A [N/m³].
    covariance_with
        Covariance C (n, n) [m²] of the modes of a panel with a further stiffness K.
    start
        K with which the search begins; None for none.

    Raises
    ------
    LinearisationError
        If no stiffness reproduces itself within `STEPS`.
    """
    stiffness = np.zeros(tensor.shape[:2]) if start is None else start
    for _ in range(STEPS):
        following = gaussian_stiffness(tensor, covariance_with(stiffness))
        change = np.abs(following - stiffness).max(initial=0.0)
        # C falls as K rises: half a step does not overshoot
        stiffness = (stiffness + following) / 2
        if change <= CONVERGED * np.abs(stiffness).max(initial=0.0):
            return stiffness
    raise LinearisationError(f"the stiffness of stretching has not settled in {STEPS} steps")


@cache
def _duffing_table() -> tuple[Array, Array]:
    """Return shares β, rising from 0 to 1, and excess of the rms, by quadrature of exp(−V/T)."""
    cubic = np.geomspace(1e-6, 1e8, 281)  # k₃T/k²
    reach = 8 / np.sqrt(1 + np.sqrt(cubic))  # beyond it the density is below exp(−15)
    x = np.linspace(-1, 1, 4001)[:, None] * reach
    density = np.exp(-(x**2) / 2 - cubic * x**4 / 4)
    exact = (density * x**2).sum(axis=0) / density.sum(axis=0)
    gaussian = (np.sqrt(1 + 12 * cubic) - 1) / (6 * cubic)  # of σ² = 1/(1 + 3 k₃ σ²)
    share = 1 - gaussian
    excess = np.sqrt(exact / gaussian) - 1
    return np.concatenate([[0], share, [1]]), np.concatenate([[0], excess, excess[-1:]])


def duffing_excess(share: Array) -> Array:
    """Return rms displacement of a mode alone in white noise over the linearised one, less 1.

    Parameters
    ----------
    share
        β = K/(k + K) of the linearised stiffness.

    Examples
    --------
    >>> duffing_excess(np.array([0.0, 0.5, 1.0])).round(3)
    array([0.   , 0.032, 0.082])
    """
    return np.asarray(np.interp(share, *_duffing_table()))


@dataclass(frozen=True)
class StretchedResponse:
    """Motion with stretching over that without, at points (n_points,), with relative errors."""

    acceleration: Array  # ratio of rms accelerations [1]
    acceleration_error: Array
    displacement: Array  # ratio of rms displacements [1]
    displacement_error: Array
    frequency: float  # ratio of the frequency of the mode of largest displacement [1]
    frequency_error: float  # of this ratio
    acceleration_g: Array  # (n_loads,) Γ at which dampers were evaluated


@dataclass(frozen=True)
class StretchedPanel:
    """A panel whose modes stretch, with dampers on some patches, on the lines of the search."""

    solver: PanelSolver
    stretching: Stretching
    patches: tuple[int, ...]  # that carry dampers

    @cached_property
    def bare(self) -> BarePanel:
        """The panel seen from its points and modes, with the modes as a further patch."""
        panel, modes = self.solver.panel, self.stretching.modes
        lines, n = panel.search_frequency, panel.patches.shapes
        unit = np.zeros((1, n, n))
        unit[0, modes, modes] = 1.0
        carriers = self.solver.carrier(self.patches)
        overlap = np.concatenate([carriers.overlap, unit])
        deflection = np.concatenate([panel.points[:, 0], np.eye(n)[modes]])
        (bare,) = bare_panels(
            lines, panel.basis, [Patches(overlap, np.append(carriers.area, 1.0))], deflection[None],
            self.solver.excitation.spectrum(lines), self.solver.excitation, panel.air_stiffness,
            overlap_cutoff=SEARCH_CUTOFF,
        )  # fmt: skip
        return bare

    def response(self, layout: DamperLayout, gamma: Array) -> StretchedResponse:
        """Return the motion with a layout whose dampers are first evaluated at Γ (n_loads,)."""
        linear = damped = DampedModes(self, layout, gamma)
        none = np.zeros(2 * self.stretching.modes.shape)
        stiffness, follows = none, layout.follows_motion
        if follows.any():
            # Γ of the linear panel is that of the search, whatever the lines here
            scale = gamma / linear.patch_motion(none)
        for _ in range(ROUNDS):
            stiffness = linearised_stiffness(self.stretching.tensor, damped.covariance, stiffness)
            if not follows.any():
                break
            moved = np.where(follows, scale * damped.patch_motion(stiffness), gamma)
            if np.abs(np.log(moved / damped.gamma))[follows].max() < SETTLED:
                break
            damped = DampedModes(self, layout, moved)
        return self._compared(damped.mean_squares(stiffness), linear.mean_squares(none), stiffness,
                              damped.gamma)  # fmt: skip

    def _compared(
        self, stretched: Array, linear: Array, stiffness: Array, gamma: Array
    ) -> StretchedResponse:
        """Return ratios of mean squares (2, n_points + n) of w and its acceleration."""
        panel, modes, further = self.solver.panel, self.stretching.modes, np.diag(stiffness)
        modal_stiffness = panel.basis.modal_mass * panel.basis.angular_frequency**2
        share = further / (modal_stiffness[modes] + further)
        errors = np.hypot(duffing_excess(share), SLOPE * share * self._slope(share))
        shapes, count = panel.points[:, 0, modes] ** 2, len(panel.points)
        part = shapes * stretched[:, None, count:]  # (2, n_points, n)
        total = np.maximum(stretched[:, :count], part.sum(axis=2))
        error = np.divide(part @ errors, total, out=np.zeros_like(total), where=total > 0)
        plain = linear[:, :count]
        ratio = np.divide(stretched[:, :count], plain, out=np.ones_like(plain), where=plain > 0)
        largest = int(np.argmax(stretched[0, count:]))
        return StretchedResponse(
            acceleration=np.sqrt(ratio[1]),
            acceleration_error=error[1],
            displacement=np.sqrt(ratio[0]),
            displacement_error=error[0],
            frequency=float(1 / np.sqrt(1 - share[largest])),
            frequency_error=float(errors[largest]),
            acceleration_g=gamma,
        )

    def _slope(self, share: Array) -> Array:
        """Return p (n,) of the PSDs of the modal forces about the frequencies with stretching."""
        panel, excitation, modes = self.solver.panel, self.solver.excitation, self.stretching.modes
        ratio = np.maximum(1 / np.sqrt(1 - share), np.sqrt(LEAST_RATIO))
        centre = panel.basis.natural_frequency[modes] / np.sqrt(1 - share)
        ends = np.clip([centre / ratio, centre * ratio], *panel.search_frequency[[0, -1]])
        level = np.empty_like(ends)
        for end, frequency in enumerate(ends):
            shape = len(modes), *2 * (panel.patches.shapes,)
            force = np.broadcast_to(excitation(frequency), shape)
            level[end] = force[range(len(modes)), modes, modes].real
            level[end] *= excitation.spectrum(frequency)
        steps = np.diff(np.log(ends), axis=0)[0]
        fall = -np.diff(np.log(np.maximum(level, 1e-300)), axis=0)[0]
        return np.divide(fall, steps, out=np.zeros_like(fall), where=steps > 0)


class DampedModes:
    """The modes of a panel with dampers, ready to take a further stiffness K of the modes.

    Parameters
    ----------
    gamma
        (n_loads,) Γ at which the dampers are evaluated.
    """

    def __init__(self, panel: StretchedPanel, layout: DamperLayout, gamma: Array) -> None:
        bare, modes = panel.bare, panel.stretching.modes
        self.gamma, self._frequency = gamma, bare.frequency
        self._shares = bare.coordinates.weight[:-1]
        self._area = panel.solver.carrier(panel.patches).area  # (n_loads,) [m²]
        value, mass, _ = evaluate_dampers(layout.dampers, bare.frequency, gamma)
        s = patch_stiffness(bare.frequency, value, mass)
        damped, drop = bare.receptances.damped(bare.pull(np.pad(s, ((0, 1), (0, 0)))))
        psd, q = bare.point_psd[:, 0] - drop, slice(-len(modes), None)
        # the modes are qᵀ u among the motions that are felt, and the last that are observed
        felt = bare.coordinates.inverse[:, modes]
        across, patch_psd = damped.across @ felt, damped.felt_psd @ felt
        self._points = Receptances(across[:, q], across, psd[:, q, q], psd[:, :, q])
        self._patches = Receptances(across[:, q], damped.felt @ felt, felt.T @ patch_psd, patch_psd)
        self._point_psd, self._patch_psd = np.einsum("fii->fi", psd).real, damped.felt_psd
        self._weight = layout.factor * trapezoid_weights(bare.frequency)

    def covariance(self, stiffness: Array) -> Array:
        """Return C (n, n) [m²] of the modes with a stiffness."""
        psd = self._points.felt_psd_with(stiffness[None])
        return np.asarray(np.tensordot(self._weight, psd, axes=1))

    def mean_squares(self, stiffness: Array) -> Array:
        """Return those of displacement and acceleration of points and modes with a stiffness."""
        psd = self._point_psd - self._points.reaction(stiffness[None]).taken
        omega = 2 * np.pi * self._frequency
        return np.stack([self._weight @ psd, (self._weight * omega**4) @ psd])

    def patch_motion(self, stiffness: Array) -> Array:
        """Return Γ (n_loads,) of the patches with a stiffness."""
        psd = self._patch_psd - self._patches.reaction(stiffness[None]).drop
        weight = self._weight * (2 * np.pi * self._frequency) ** 4
        covariance = np.tensordot(weight, psd.real, axes=1)[None]
        return sine_accelerations_g(np.sqrt(traces(self._shares, covariance)[:, 0] / self._area))


def stretched_responses(
    solver: PanelSolver, stretching: Stretching, cases: Sequence[tuple[DamperLayout, Array]]
) -> list[StretchedResponse | LinearisationError]:
    """Return the stretched motion of layouts, each with Γ (n_loads,) of its linear response.

    Parameters
    ----------
    solver
        The panel and its excitation; its lines of the search are used.
    stretching
        Membrane energy of some of its shapes.
    """

    def together(
        solver: PanelSolver, cases: Sequence[tuple[DamperLayout, Array]]
    ) -> list[StretchedResponse | LinearisationError]:
        sets = {layout.patches for layout, _ in cases}
        panels = {patches: StretchedPanel(solver, stretching, patches) for patches in sets}
        answers: list[StretchedResponse | LinearisationError] = []
        for layout, gamma in cases:
            try:
                answers.append(panels[layout.patches].response(layout, gamma))
            except LinearisationError as error:
                answers.append(error)
        return answers

    return by_force(solver, cases, together)
