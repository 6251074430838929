"""The longest element edge that a frequency allows."""

import numpy as np

from pidpanel.panel.section import Section

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


def half_wave(section: Section, frequency: float) -> float:
    """Return half the length of the shortest free bending wave [m].

    From D k⁴ = m″ ω² (1 + D k² / S), rotary inertia neglected; of a section that is not
    isotropic, the smaller D and S.

    Parameters
    ----------
    section
        Of the panel.
    frequency
        [Hz].

    Examples
    --------
    The paper's panel at 2 kHz, three elements of 5 cm:

    >>> from pidpanel.panel.section import ThinSection
    >>> round(half_wave(ThinSection(3273.07, 4.0), 2000.0), 3)
    0.15
    """
    D = float(np.diag(section.bending)[:2].min())
    inertia = section.mass_per_area * (2 * np.pi * frequency) ** 2
    shear = getattr(section, "shear", None)
    softening = 0.0 if shear is None else inertia * D / float(np.linalg.eigvalsh(shear).min())
    k2 = (softening + np.sqrt(softening**2 + 4 * D * inertia)) / (2 * D)
    return float(np.pi / np.sqrt(k2))


def check_resolution(element: str, longest_edge: float, section: Section, frequency: float) -> None:
    """Refuse a mesh that is too coarse for a frequency.

    Parameters
    ----------
    element
        A key of `LONGEST_EDGE`.
    longest_edge
        [m].
    section
        Of the panel.
    frequency
        The highest of the analysis [Hz].

    Raises
    ------
    ValueError
        With the longest edge that would do.
    """
    half = half_wave(section, frequency)
    allowed = LONGEST_EDGE[element] * half
    if longest_edge > allowed:
        raise ValueError(
            f"mesh: element edges of {longest_edge:.3g} m are too coarse for {frequency:g} Hz,"
            f" where half a bending wavelength is {half:.3g} m; at most {allowed:.3g} m"
        )
