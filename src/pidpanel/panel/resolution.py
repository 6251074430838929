"""The longest element edge that a frequency allows, under dampers that weigh on the panel.

An element that is not much shorter than a wave is too stiff: the frequency of the wave is too high
by a share that grows with the fourth power of edge over half-wave. Under a damper waves are
shorter, with m″ + m_a instead of m″. Every resonance is then too high, and next to a sharp one
PSDs are wrong by more than 0.5 dB long before its frequency is by 1 %.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.geometry.plane_mesh import edge_lengths
from pidpanel.panel.section import Section, ThinSection

# Longest element edge over half a wave up to which the frequency of a mode errs by at most
# 1 %; measured on a simply supported rectangle (thin; Argyris elements would allow 2, 0.1 %) and
# on clamped and simply supported skew plates: sandwiches with cores of 3 to 25 mm, whose error at
# 0.9 is 0.7 to 1.6 %, and solids of 0.5 to 30 mm.
LONGEST_EDGE = {
    "thin quadrilaterals": 0.65,
    "thin triangles": 1.2,
    "sandwich triangles": 0.8,
    "solid triangles": 0.9,
}


# Elements that see nothing of the shear layer at free edges: order and edge over its depth at which
# half of it is seen; measured mode by mode on free panels against elements of a quarter to a sixth:
# sandwiches with edges of 2.7 to 30 depths, solids of 21 to 200.
EDGE_LAYER = {"sandwich triangles": (0.9, 8.7), "solid triangles": (0.5, 29.0)}
# Likewise, where the mode is not known, of the largest shift of any; elements of 2 to 73 depths.
EDGE_LAYER_OF_ANY = {"sandwich triangles": (2.0, 26.0), "solid triangles": (1.5, 55.0)}

# Error of the frequency over the share of a mode's energy in bending of the elements at feet: 0.15
# to 0.18 in each of 15 modes of a thin plate; -0.1 to 0.5 on sandwiches, up to 0.02 on solids.
FOOT_SHIFT = {"thin": 0.16, "sandwich": 0.16, "solid": 0.03}
# The largest of any mode, over element size at the rim and radius, on thin plates: linear from
# 0.025 to 0.5 radii; 9e-3 for hold-downs of 3 cm, one or three on 1.2 m × 0.9 m, up to 1.8e-2 for
# two and three of 1.5 to 2.3 cm on plates of 0.5 to 1 m; less with hinges.
FOOT_SHIFT_OF_ANY = 1.5e-2
# Largest frequency shift due to feet of whole elements in mesh files over `checks.jaggedness`, with
# four hold-downs of 3, 4.5 and 6 cm on elements of 2.5 and 5 cm: modes were up to 15 % too high on
# thin plates and 11 % on others.
JAGGED_SHIFT = {"thin": 0.45, "shear": 0.32}
# Frequency shift of rectangles per end of a supported part of an edge, over element size/√area.
# Four ends of clamped parts on 1.2 m × 0.9 m: 6.7, 3.5 and 1.8 % with elements of 10, 5 and 2.5 cm;
# a fifth of it if the parts are simply supported.
END_SHIFT = 0.2

# Error of the frequency there, and the power of the edge with which it grows; of waves with the
# dampers of a panel, for which that of Argyris elements and solids is overestimated.
WORST_SHIFT, ORDER = 0.01, 4
# Error of the frequency where edges are half a wave, of waves that only bend, and its order:
# measured on panels without dampers; of Argyris elements with the corners of clamped plates.
WAVES = {
    "thin quadrilaterals": (0.01 / 0.65**4, 4),
    "thin triangles": (3e-4 / 1.2**4, 4),
    "sandwich triangles": (0.033, 4),
    "solid triangles": (0.01 / 0.9**6, 6),
}
# Growth of that with the share of the energy that clamped edges bend to a depth of √(D/S).
CLAMPED = 5.0
# Largest shift under a damper, over ζ: where a mode moves the patch most of all.
LOCAL_SHIFT = 0.4
# Mass of panel and damper over that of the panel above which elements that are made for a damper
# are shorter: such a patch resonates more sharply by itself. Under 30 times the mass of sandwiches
# the stated error of the mesh is 0.1 to 0.5 dB; without this, 0.5 to 1.6.
HEAVY = 7.2
# Largest error of a PSD [dB] that a mesh may make at any line.
LINE_ERROR_DB = 0.5
# Frequencies at which that is estimated, over this share of the highest.
TRIED, LOWEST_TRIED = 60, 1 / 30


@dataclass(frozen=True)
class Region:
    """A part of the panel that carries the same mass all over."""

    name: str  # of the patch; empty for what has no damper
    area: float  # [m²]
    longest_edge: float  # of its elements [m]
    added_mass: float = 0.0  # m_a of its damper, or its mass where that is larger [kg/m²]


class BoundaryStrain(NamedTuple):
    """Curvatures of a mode of 1 kg at the boundary of the panel, over 2 ω²."""

    twist: float  # ∮ (2κ_nt)² ds along free edges [1/N]
    normal: float  # ∮ κ_nn² ds along the others [1/N]
    feet: Array  # (3, 3) ∫ κκᵀ dA over the elements at feet [m/N]


def element_sizes(vertices: Array, cells: Index) -> Array:
    """Return the size of each cell [m]: of a triangle the mean edge, of a rectangle the longest."""
    edges = edge_lengths(vertices, cells)
    return edges.mean(axis=1) if cells.shape[1] == 3 else edges.max(axis=1)


def half_wave(section: Section, frequency: float, added_mass: float = 0.0) -> float:
    """Return half the length of the shortest free bending wave [m]; infinite at 0 Hz.

    k follows from D k⁴ = m″ ω² (1 + D k² / S), without rotary inertia. D and S are the smaller
    ones of an anisotropic section.

    Parameters
    ----------
    section
        Section of the panel.
    frequency
        Frequency [Hz].
    added_mass
        Mass per area of a damper all over the panel [kg/m²].

    Examples
    --------
    The paper's panel at 2 kHz, three elements of 5 cm:

    >>> from pidpanel.panel.section import ThinSection
    >>> round(half_wave(ThinSection(3273.07, 4.0), 2000.0), 3)
    0.15
    """
    D = float(np.diag(section.bending)[:2].min())
    shear = 0.0 if isinstance(section, ThinSection) else np.linalg.eigvalsh(section.shear).min()
    k2 = _square_wavenumber(section, frequency, added_mass, D, float(shear))
    return float(np.pi / np.sqrt(k2)) if k2 > 0 else float(np.inf)


def _square_wavenumber(
    section: Section, frequency: float, added_mass: float, D: float, shear: float
) -> float:
    """Return k² [1/m²] of waves with stiffnesses D and S; without shear where S is 0."""
    inertia = (section.mass_per_area + max(added_mass, 0.0)) * (2 * np.pi * frequency) ** 2
    softening = inertia * D / shear if shear else 0.0
    return float((softening + np.sqrt(softening**2 + 4 * D * inertia)) / (2 * D))


@dataclass(frozen=True)
class ElementKind:
    """Elements of a panel, and what a mesh of them does to its resonances."""

    kind: str  # a key of `LONGEST_EDGE`
    section: Section

    def allowed_edge(self, frequency: float, added_mass: float) -> float:
        """Return the edge [m] with which the frequency of a wave errs by `WORST_SHIFT`."""
        return LONGEST_EDGE[self.kind] * half_wave(self.section, frequency, added_mass)

    def frequency_shifts(
        self,
        edge: float,
        frequency: float,
        added_mass: float = 0.0,
        free_edges: float = 0.0,
        feet: float = 0.0,
        jagged: float = 0.0,
        ends: float = 0.0,
        strain: BoundaryStrain | None = None,
    ) -> dict[str, float]:
        """Return about the relative frequency errors of a resonance due to edges, by cause [1].

        Along a free edge, shear relieves a layer of depth λ = √(D₆₆/S) of its torsion.

        Parameters
        ----------
        edge
            Length of the element edges [m].
        frequency, added_mass
            Same as in `half_wave`.
        free_edges
            Half the length of the free edges over the area of the panel [1/m].
        feet
            Size of elements at the rims of feet over their radius [1].
        jagged
            ln(reach/radius) of the feet; see `checks.jaggedness`.
        ends
            Sum of the element sizes at the ends of supported parts of edges, over √area [1].
        strain
            That of the mode; it takes the place of ``free_edges`` and ``feet``, with which the
            shift is the largest of any mode.
        """
        section, D = self.section, self.section.bending
        is_thin = isinstance(section, ThinSection)
        shifts = {"waves": self._wave_shift(edge, frequency, added_mass), "ends": END_SHIFT * ends}
        at_feet = FOOT_SHIFT_OF_ANY * feet if is_thin else 0.0
        if strain is not None:
            at_feet = FOOT_SHIFT[self.kind.split()[0]] * float(np.sum(D * strain.feet))
        shifts["feet"] = at_feet + JAGGED_SHIFT["thin" if is_thin else "shear"] * jagged
        if isinstance(section, ThinSection):
            return shifts
        shear = np.linalg.eigvalsh(section.shear).max()
        order, half = EDGE_LAYER_OF_ANY[self.kind]
        if strain is not None:
            free_edges, (order, half) = float(D[2, 2]) * strain.twist, EDGE_LAYER[self.kind]
            stiffness = float(D[0, 0])
            shifts["waves"] *= 1 + CLAMPED * stiffness**1.5 / float(np.sqrt(shear)) * strain.normal
        layer = float(np.sqrt(D[2, 2] / shear))
        shifts["waves"] += layer * free_edges / (1 + (half * layer / edge) ** order)
        return shifts

    def _wave_shift(self, edge: float, frequency: float, added_mass: float) -> float:
        """Return the shift of waves: elements are too stiff in bending, hardly in shear."""
        section, shear = self.section, 0.0
        D = float(np.sqrt(np.prod(np.diag(section.bending)[:2])))
        if not isinstance(section, ThinSection):
            shear = float(np.sqrt(np.linalg.det(section.shear)))
        k2 = _square_wavenumber(section, frequency, added_mass, D, shear)
        bending_share = 1 / (1 + D * k2 / shear) if shear else 1.0
        at_half_wave, order = WAVES[self.kind]
        return float(at_half_wave * (edge**2 * k2 / np.pi**2) ** (order / 2) * bending_share)

    def frequency_shift(
        self, edge: float, frequency: float, added_mass: float = 0.0, **rough: Any
    ) -> float:
        """Return the sum of `frequency_shifts`."""
        return sum(self.frequency_shifts(edge, frequency, added_mass, **rough).values())

    def longest_edge(self, frequency: float, added_mass: float, damping_ratio: float) -> float:
        """Return the longest edge up to a frequency [m], under a damper or without one."""
        allowed = self.allowed_edge(frequency, added_mass)
        if added_mass <= 0:
            return allowed
        return float(allowed * min(LOCAL_SHIFT * damping_ratio / WORST_SHIFT, 1.0) ** (1 / ORDER))

    def made_edge(self, frequency: float, added_mass: float, damping_ratio: float) -> float:
        """Return the edge [m] of elements that are made for a damper; see `longest_edge`."""
        heavier = 1 + added_mass / self.section.mass_per_area
        return self.longest_edge(frequency, added_mass, damping_ratio * min(HEAVY / heavier, 1.0))

    def check(self, regions: Sequence[Region], frequency: float, damping_ratio: float) -> None:
        """Refuse a mesh too coarse for a frequency [Hz], with the longest edge that would do.

        The regions are the panel without dampers, and its patches with theirs.
        """
        for region in regions:
            longest = self.longest_edge(frequency, region.added_mass, damping_ratio)
            if region.longest_edge > longest * (1 + 1e-9):
                half = half_wave(self.section, frequency, region.added_mass)
                allowed = self._allowed_for_all(regions, region, longest, frequency, damping_ratio)
                raise ValueError(
                    f"mesh: element edges of {region.longest_edge:.3g} m{_under(region)} are too"
                    f" coarse for {frequency:g} Hz, where half a bending wavelength is {half:.3g}"
                    f" m; at most {_rounded_down(allowed):g} m"
                )
        error = self.line_error_db(regions, frequency, damping_ratio)
        if error > LINE_ERROR_DB:
            shifts = self._shifts(regions, frequency, {})
            worst = regions[int(np.argmax(shifts))]
            allowed = self._allowed_for_all(
                regions, worst, worst.longest_edge, frequency, damping_ratio
            )
            raise ValueError(
                f"mesh: element edges of {worst.longest_edge:.3g} m{_under(worst)} raise resonances"
                f" by up to {max(shifts):.2g} of their frequency, which with damping_ratio ="
                f" {damping_ratio:g} changes PSDs by about {error:.1f} dB, more than"
                f" {LINE_ERROR_DB:g} dB; at most {_rounded_down(allowed):g} m"
            )

    def _allowed_for_all(
        self,
        regions: Sequence[Region],
        region: Region,
        longest: float,
        frequency: float,
        damping_ratio: float,
    ) -> float:
        """Return the longest edge that a region may have, up to `longest`, by both conditions [m].

        Elements of patches that are too coarse are as long as those of the panel.
        """
        limit = {r.name: self.longest_edge(frequency, r.added_mass, damping_ratio) for r in regions}
        coarse = {r.name for r in regions if r.longest_edge > limit[r.name] * (1 + 1e-9)}
        longest = min([longest, *(limit[name] for name in coarse)])

        def error(edge: float) -> float:
            shorter = [
                replace(r, longest_edge=min(r.longest_edge, edge))
                if r.name in coarse or r is region or not region.name
                else r
                for r in regions
            ]
            return self.line_error_db(shorter, frequency, damping_ratio)

        low, high = 0.0, longest
        if error(high) <= LINE_ERROR_DB:
            return high
        for _ in range(30):  # to a billionth
            middle = (low + high) / 2
            low, high = (middle, high) if error(middle) <= LINE_ERROR_DB else (low, middle)
        # where the others alone are too coarse, as if all were as much shorter as this
        return low or longest * (LINE_ERROR_DB / error(longest)) ** (1 / ORDER)

    def _shifts(
        self, regions: Sequence[Region], frequency: float, rough: Mapping[str, float]
    ) -> list[float]:
        return [
            self.frequency_shift(region.longest_edge, frequency, region.added_mass, **rough)
            for region in regions
        ]

    def line_error_db(
        self, regions: Sequence[Region], frequency: float, damping_ratio: float, **rough: float
    ) -> float:
        """Estimate the largest error of a PSD that a mesh makes up to a frequency [dB].

        Resonances a spacing δ apart make S ∝ sinh x/(cosh x − cos(2π f/δ)) with x = 2πζf/δ, whose
        slope is at most 2π/(δ sinh x); the shift of the resonances times that is the error. Each
        part of the panel has its share of the modes in the shift and in the damping. ``rough`` has
        parameters of `frequency_shifts`; without them the error is that of waves alone.
        """
        tried = frequency * np.geomspace(LOWEST_TRIED, 1.0, TRIED)
        mass, area = np.array([(region.added_mass, region.area) for region in regions]).T
        wavenumber = np.pi / np.array(
            [[half_wave(self.section, f, extra) for extra in mass.tolist()] for f in tried.tolist()]
        )
        shift = np.array([self._shifts(regions, f, rough) for f in tried.tolist()])
        modes_below = area * wavenumber**2 / (4 * np.pi)  # modes below a frequency
        total = modes_below.sum(axis=1)
        share = modes_below / total[:, None]
        ratio = damping_ratio * share @ (1 + mass / self.section.mass_per_area) ** -0.5
        density = tried * np.gradient(total, tried)
        slope = 2 * np.pi * density / np.sinh(np.minimum(2 * np.pi * density * ratio, 100.0))
        error = 10 / np.log(10) * np.sum(share * shift, axis=1) * slope
        return float(np.max(error[total >= 1.0], initial=0.0))


def _rounded_down(size: float) -> float:
    """Return a value rounded down to three digits."""
    unit = 10.0 ** (math.floor(math.log10(size)) - 2)
    return math.floor(size / unit) * unit


def _under(region: Region) -> str:
    if not region.name:
        return ""
    return f" under {region.name}, whose damper can weigh {region.added_mass:.3g} kg/m²,"
