"""Units of labels."""

import pytest

from pidpanel.tabular.units import UnitError, unit_of_label

G = 9.80665


@pytest.mark.parametrize(
    "label",
    ["g^2/Hz", "g²/Hz", "g2/Hz", "G2/Hz", "G**2/HZ", "g*g/Hz", "g·g/Hz", "(g)^2/Hz", "[g^2/Hz]",
     "{g}^2/Hz", "g_n^2/Hz", "gn^2/Hz", "gn2/Hz", "g_0²/Hz", "g0^2/Hz", "gₙ²/Hz", "g₀²/Hz",
     "grms^2/Hz", "g rms²/Hz", "gRMS²/Hz", "g²rms/Hz", "(g rms)^2/Hz", "g_rms^2/Hz",
     "g^2/Hz (rms)", "[g RMS]**2 / Hz", "g^2 / Hz", "g^2 Hz^-1", "g² Hz⁻¹", "g^2*s", "g²·s",
     "(g^2)/(Hz)", "gý/Hz", "g^(2)/Hz"],
)  # fmt: skip
def test_labels_of_a_psd_in_g(label):
    unit = unit_of_label(label)
    assert unit.dimension == (2, 0, -3)
    assert unit.factor == pytest.approx(G**2, rel=1e-12)


@pytest.mark.parametrize(
    ("label", "factor", "dimension"),
    [
        ("(m/s^2)^2/Hz", 1.0, (2, 0, -3)),
        ("m2/s4/Hz", 1.0, (2, 0, -3)),
        ("m²/s³", 1.0, (2, 0, -3)),
        ("m^2 s^-4 Hz^-1", 1.0, (2, 0, -3)),
        ("(m/s/s)^2/Hz", 1.0, (2, 0, -3)),
        ("mm2/s4/Hz", 1e-6, (2, 0, -3)),
        ("(MM/S^2)^2/HZ", 1e-6, (2, 0, -3)),
        ("(in/s**2)**2/Hz", 0.0254**2, (2, 0, -3)),
        ("(ft/s2)2/Hz", 0.3048**2, (2, 0, -3)),
        ("g²/kHz", 1e-3 * G**2, (2, 0, -3)),
        ("(m/s²)²/(rad/s)", 6.283185307179586, (2, 0, -3)),  # per rad/s, times 2π per Hz
        ("m.s-2", 1.0, (1, 0, -2)),
        ("cm/sec^2", 0.01, (1, 0, -2)),
        ("Gal", 0.01, (1, 0, -2)),
        ("mg", 1e-3 * G, (1, 0, -2)),
        ("kHz", 1e3, (0, 0, -1)),
        ("rad/s", 0.15915494309189535, (0, 0, -1)),
        ("rpm", 1 / 60, (0, 0, -1)),
        ("1/s", 1.0, (0, 0, -1)),
        ("lbf", 4.4482216152605, (1, 1, -2)),
        ("kgf", G, (1, 1, -2)),
        ("N/(m/s²)", 1.0, (0, 1, 0)),
        ("lbf s²/in", 175.12683524647636, (0, 1, 0)),
        ("%", 0.01, (0, 0, 0)),
        ("g/g", 1.0, (0, 0, 0)),
    ],
)
def test_labels_with_other_units(label, factor, dimension):
    unit = unit_of_label(label)
    assert unit.dimension == dimension
    assert unit.factor == pytest.approx(factor, rel=1e-12)


# Acceleration, force and mass in SI by the definitions of the units (NIST SP 811, appendix B)
NAMES = {
    (1, 0, 0): {"m": 1.0, "meter": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "µm": 1e-6, "km": 1e3,
                "in": 0.0254, "inch": 0.0254, "ft": 0.3048, "foot": 0.3048, "IN": 0.0254},
    (0, 0, 1): {"s": 1.0, "sec": 1.0, "ms": 1e-3, "min": 60.0, "S": 1.0},
    (0, 0, -1): {"Hz": 1.0, "hz": 1.0, "cps": 1.0, "kHz": 1e3, "KHz": 1e3, "MHz": 1e6,
                 "cpm": 1 / 60, "RPM": 1 / 60},
    (0, 0, 0): {"rad": 0.15915494309189535, "deg": 1 / 360, "%": 0.01, "1": 1.0},
    (1, 0, -2): {"g": G, "G": G, "g's": G, "Gs": G, "mg": 1e-3 * G, "ug": 1e-6 * G, "µg": 1e-6 * G,
                 "Gal": 0.01},
    (0, 1, 0): {"kg": 1.0, "lbm": 0.45359237, "slug": 14.593902937206364, "KG": 1.0},
    (1, 1, -2): {"N": 1.0, "kN": 1e3, "mN": 1e-3, "cN": 1e-2, "dyn": 1e-5, "kgf": G, "kp": G,
                 "lbf": 4.4482216152605, "LBF": 4.4482216152605},
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "factor", "dimension"),
    [(name, factor, key) for key, names in NAMES.items() for name, factor in names.items()],
)
def test_names_of_units(name, factor, dimension):
    unit = unit_of_label(name)
    assert unit.dimension == dimension
    assert unit.factor == pytest.approx(factor, rel=1e-12)


@pytest.mark.parametrize(
    ("label", "message"),
    [
        ("", "a unit is missing"),
        ("g/", "a unit is missing"),
        ("dB", "'dB'"),
        ("V^2/Hz", "'V'"),
        ("EU^2/Hz", "'EU'"),
        ("gE^2/Hz", "'gE'"),
        ("g/sqrt(Hz)", "'sqrt'"),
        ("g pk", "'pk'"),
        ("MN", "'MN'"),  # mega or milli
        ("lb", "'lb'"),  # of mass or of force
        ("m/s*s", "needs brackets"),
        ("N/m s2", "needs brackets"),
        ("g^0", "whole number"),
        ("g^2.5/Hz", "not expected|not a known unit"),
        ("g^2^2/Hz", "not a known unit"),
        ("(g", "( is not closed"),
        ("(g]", "( is not closed"),
        ("g^2/Hz)", "')' is not expected"),
        ("<g>", "'<' is not expected"),
    ],
)
def test_other_labels_are_refused(label, message):
    with pytest.raises(UnitError, match=message.replace("(", r"\(").replace(")", r"\)")):
        unit_of_label(label)
