"""Ranges and shares of a margin against plain Monte Carlo of closed forms.

Nothing is shared with the stage: simply supported panels are sine modes here, the sound is a sum of
plane waves, and a patch of dampers some of its own motions. Shares are those of `scipy.stats`.
"""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.interpolate import CubicSpline
from scipy.stats import norm, sobol_indices

from pidpanel import Model
from pidpanel.margin.from_study import SpreadStudy, write_margin

pytestmark = pytest.mark.verification

A, B, MASS, RIGIDITY = 0.9, 0.6, 4.0, 1000.0
FACE, CORE, MODULUS, POISSON, SHEAR_MODULUS = 3e-4, 10e-3, 70e9, 0.3, 50e6
LAID = 2700 * 2 * FACE + 30 * CORE  # mass of faces and core [kg/m²]
POINT, CENTRE, SIDE = (0.35, 0.25), (0.4, 0.3), 0.15
LOW, HIGH, APPARENT, G0 = 60.0, 400.0, 1.0, 9.80665
M, N = (part.ravel() for part in np.meshgrid(np.arange(1, 8), np.arange(1, 6), indexing="ij"))
PSD = 100.0  # Pa²/Hz
KX, KY = M * np.pi / A, N * np.pi / B
Z95 = norm.ppf(0.95)
DRAWN, SALTELLI = 4096, 1024

# Key → kind and values of its spread; the study has the middle.
DAMPING = {"panel.damping_ratio": ("lognormal", 0.015, 0.04)}
DAMPER = {"dampers.blanket.equivalent_damping_n_s_m3": ("normal", 200, 600)}
CASES = {
    "uniform sound": {
        **DAMPING,
        **DAMPER,
        "panel.section.bending_stiffness_n_m": ("normal", 900, 1100),
        "panel.section.mass_per_area_kg_m2": ("normal", 3.8, 4.2),
        "sound.shift_db": ("normal", -2, 2),
    },
    "diffuse sound": {
        **DAMPING,
        **DAMPER,
        "sound.speed_m_s": ("uniform", 320, 366),
        "panel.section.bending_stiffness_n_m": ("normal", 850, 1150),
        "sound.shift_db": ("uniform", -2, 2),
    },
    "diffuse sound on a sandwich": {
        **DAMPING,
        **DAMPER,
        "panel.section.bending_factor": ("normal", 0.9, 1.1),
        "panel.section.shear_factor": ("normal", 0.7, 1.3),
        "panel.section.extra_mass_per_area_kg_m2": ("normal", 1.9, 2.3),
    },
}


def study_of(case, folder):
    pd.DataFrame({"frequency_hz": [20.0, 1000.0], "psd_pa2_hz": PSD}).to_csv(
        folder / "flat.csv", index=False
    )
    section = {"mass_per_area_kg_m2": MASS, "bending_stiffness_n_m": RIGIDITY}
    if case.endswith("sandwich"):
        metal = {"youngs_modulus_gpa": 70, "poissons_ratio": POISSON, "density_kg_m3": 2700}
        section = {
            "kind": "sandwich", "materials": {"metal": metal},
            "faces": [{"material": "metal", "thickness_mm": 0.3}],
            "core": {"thickness_mm": 10, "shear_modulus_l_mpa": 50, "shear_modulus_w_mpa": 50,
                     "density_kg_m3": 30},
            "extra_mass_per_area_kg_m2": 2.1,
        }  # fmt: skip
    return {
        "panel": {
            "outline_m": [A, B], "section": section, "damping_ratio": 0.0245,
            "mesh": {"kind": "triangles", "size_m": 0.15} if case.endswith("sandwich")
                    else {"kind": "quadrilaterals", "elements": [12, 8]},
            "patches": {"A": {"centre_m": list(CENTRE), "size_m": [SIDE, SIDE]}},
            "points": {"P": list(POINT)},
        },
        "dampers": {"blanket": {"equivalent_damping_n_s_m3": 400, "apparent_mass_kg_m2": APPARENT}},
        "sound": {"spectrum": str(folder / "flat.csv"), "level": "median",
                  "field": case.split()[0]},
        "response": {"frequency_hz": [LOW, HIGH]},
        "scenarios": {"A": {"patch": "A", "damper": "blanket"}},
        "uncertain": {key: {kind: ends, "source": "a"} for key, (kind, *ends) in CASES[case].items()},
    }  # fmt: skip


def value(spread, z):
    kind, low, high = spread
    z = np.clip(z, -3, 3)
    if kind == "uniform":
        return low + (high - low) * norm.cdf(z)
    low, high = np.log([low, high]) if kind == "lognormal" else (low, high)
    number = (low + high) / 2 + z / Z95 * (high - low) / 2
    return np.exp(number) if kind == "lognormal" else number


def transform(m, length, k):
    """∫ sin(mπx/L) exp(ikx) dx over the side, (nk, nm)."""
    wave = m * np.pi / length
    k = k[:, None] + 1e-9
    return wave * (1 - (-1.0) ** m * np.exp(1j * k * length)) / (wave**2 - k**2)


def diffuse_force(k):
    """Mean over directions of F F* (n, n) at a wavenumber [rad/m]."""
    mu, weight = np.polynomial.legendre.leggauss(24)
    sine, angle = np.sqrt(1 - ((mu + 1) / 2) ** 2), np.arange(48) * 2 * np.pi / 48 + 0.01
    kx, ky = (k * np.outer(sine, wave(angle)).ravel() for wave in (np.cos, np.sin))
    F = transform(M, A, kx) * transform(N, B, ky)
    share = np.repeat(weight / 2, 48) / 48
    return ((share[:, None] * F).T @ F.conj()).real


WAVENUMBERS = np.linspace(0.5, 2 * np.pi * HIGH / 300, 40)
FORCE = CubicSpline(WAVENUMBERS, [diffuse_force(k) for k in WAVENUMBERS])
UNIFORM = np.outer(*2 * [(1 - (-1.0) ** M) / KX * (1 - (-1.0) ** N) / KY])
AT_POINT = np.sin(KX * POINT[0]) * np.sin(KY * POINT[1])


def patch_motions():
    """E (n, 8) with ∫ φ φᵀ dA = E Eᵀ, of the closed form."""

    def overlap(k, centre):
        first, second = k[:, None] - k, k[:, None] + k
        parts = (np.sinc(d * SIDE / 2 / np.pi) * np.cos(d * centre) for d in (first, second))
        return SIDE / 2 * np.subtract(*parts)

    square, vector = np.linalg.eigh(overlap(KX, CENTRE[0]) * overlap(KY, CENTRE[1]))
    return vector[:, -8:] * np.sqrt(square[-8:])


def closed_form(case, z, lines=190):
    """G rms at the point (2, n), bare and damped, at scores (n, n_inputs)."""
    x = {
        key: value(spread, part)
        for (key, spread), part in zip(CASES[case].items(), z.T, strict=True)
    }
    section = "panel.section."
    one, k2 = np.ones(len(z)), KX**2 + KY**2
    D = x.get(f"{section}bending_stiffness_n_m", RIGIDITY * one)
    mass = x.get(f"{section}mass_per_area_kg_m2", MASS * one)
    softer = 1.0
    if case.endswith("sandwich"):
        outer, inner = CORE / 2 + FACE, CORE / 2
        D = (
            x[f"{section}bending_factor"]
            * MODULUS
            / (1 - POISSON**2)
            * 2
            / 3
            * (outer**3 - inner**3)
        )
        S = x[f"{section}shear_factor"] * SHEAR_MODULUS * (CORE + FACE) ** 2 / CORE
        mass = LAID + x[f"{section}extra_mass_per_area_kg_m2"]
        softer = 1 + (D / S)[:, None] * k2
    modal, omega_i = mass * A * B / 4, np.sqrt(D[:, None] / mass[:, None] / softer) * k2
    level = PSD * 10 ** (x.get("sound.shift_db", 0 * one) / 10)
    speed, E, total = x.get("sound.speed_m_s", 343 * one), patch_motions(), np.zeros((2, len(z)))
    frequency = np.geomspace(LOW, HIGH, lines)
    step = np.gradient(frequency)
    step[[0, -1]] /= 2
    for f, df in zip(frequency, step, strict=True):
        omega = 2 * np.pi * f
        zeta = x["panel.damping_ratio"][:, None]
        H = 1 / (modal[:, None] * (omega_i**2 - omega**2 + 2j * zeta * omega_i * omega))
        s = 1j * omega * x[next(iter(DAMPER))] - omega**2 * APPARENT
        row = H * AT_POINT
        loop = np.eye(8) + s[:, None, None] * np.einsum("ir,ni,is->nrs", E, H, E, optimize=True)
        felt = np.linalg.solve(loop, (row @ E)[:, :, None])[:, :, 0]
        damped = row - s[:, None] * (felt @ E.T) * H
        G = UNIFORM if case.startswith("uniform") else FORCE(omega / speed)
        for number, motion in enumerate((row, damped)):
            pushed = motion @ G if G.ndim == 2 else np.einsum("ni,nij->nj", motion, G)
            psd = np.sum(pushed * motion.conj(), axis=1).real
            total[number] += df * omega**4 * psd
    return np.sqrt(level * total) / G0


@pytest.mark.long
@pytest.mark.parametrize("case", CASES)
def test_ranges_and_shares_of_a_margin_are_those_of_plain_monte_carlo(record, tmp_path, case):
    study = Model(study_of(case, tmp_path), tmp_path / "run").study
    spread = SpreadStudy(study, None)
    z = spread.samples[:24]
    runs = np.array([spread.run(n)[0].rms[:2, 0] for n in range(len(z))])
    row = partial(record, case=f"Margin: {case}", source="closed form, all by itself")
    deviation = np.abs(runs / closed_form(case, z, 1000).T - 1).max()
    row(
        "a run: g rms, largest error", 1 + deviation, 1.0, tolerance=5e-3,
        method=f"{len(z)} runs in the reduced basis, bare and damped",
    )  # fmt: skip
    names = ("runs.nc", "ranges.csv", "shares.csv", "next_test.csv")
    files = {name.split(".")[0]: tmp_path / name for name in names}
    write_margin(study, None, SimpleNamespace(**files))
    ranges, shares = (pd.read_csv(files[name]).set_index("panel") for name in ("ranges", "shares"))
    rng = np.random.default_rng(4)
    drawn = closed_form(case, rng.standard_normal((DRAWN, len(CASES[case]))))
    referee = sobol_indices(
        func=lambda z: closed_form(case, z.T),
        n=SALTELLI,
        dists=[norm()] * len(CASES[case]),
        rng=rng,
    )
    quantiles = ("p05_g", "p50_g", "p95_g")
    for panel, values, totals in zip(("bare", "damped"), drawn, referee.total_order, strict=True):
        again = rng.choice(values, (200, DRAWN))
        error = np.std(np.quantile(again, (0.05, 0.5, 0.95), axis=1), axis=1)
        reference = np.quantile(values, (0.05, 0.5, 0.95))
        for name, truth, sigma in zip(quantiles, reference, error, strict=True):
            row(
                f"{panel}, {name[:3].upper()}", ranges.loc[panel, name], truth, unit="g",
                tolerance=3 * sigma / truth, method="polynomial chaos of at most 256 runs",
                source=f"{DRAWN} samples, three bootstrap errors",
            )  # fmt: skip
        for key, total in zip(CASES[case], totals, strict=True):
            share = shares[shares["input"] == key].loc[panel, "share"]
            row(
                f"{panel}, share of {key}", 1 + share, 1 + total, tolerance=0.02,
                method="chaos, plus 1", source="Saltelli, scipy.stats.sobol_indices, plus 1",
            )  # fmt: skip
