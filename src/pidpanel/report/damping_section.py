"""The damping on the page: the surface, the law as an engineer quotes it, the forms compared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd

from pidpanel.arrays import Array
from pidpanel.damping import forms
from pidpanel.damping.fit import AT_FILL, OVER_FILL, constants_at
from pidpanel.damping.laws import equation_5, paper_constants
from pidpanel.damping.surface import DampingSurface
from pidpanel.report import damping_figures, style
from pidpanel.report.html import Block, Paragraph, Picture, Section, Table
from pidpanel.report.tables import number, records

FORM_NAMES = {
    "paper_corrected": "the paper's law, corrected: Eq. 5 and 6, |a₁|, f in Hz, its constants",
    "paper": "Eq. 5 and 6, constants fitted to all cases (no Γ)",
    "paper_level": "the same times Γ^c",
    "groups": "η = h A r^p Γ^−q (W/L)^s",
    "two_regimes": "η = h [A r^p Γ^−q + B x^s/(1 + (x/x₀)^t)], x = W/L",
    "surface": "the surface (Gaussian process)",
}

SHARES = (("normal_share", "along the normal"), ("tangential_share", "along the surface"))


@dataclass(frozen=True)
class DampingResults:
    """What the damping stage left.

    Attributes
    ----------
    surface
        ``damping/surface.nc``.
    law, comparison
        ``damping/law.csv``, ``damping/forms.csv``.
    cases
        ``coupon/cases.csv``.
    depth
        Of the cell, m.
    rounds
        ``design/round*.json`` in order; empty for a study without a target.
    """

    surface: DampingSurface
    law: pd.DataFrame
    comparison: pd.DataFrame
    cases: pd.DataFrame
    depth: float
    rounds: Sequence[Mapping[str, Any]] = ()


def damping_section(results: DampingResults) -> Section:
    """Surface, law, forms."""
    surface = results.surface
    left = surface.leave_one_out()
    z = left["log_error"] / left["log_standard_error"]
    rms = float(np.sqrt((left["log_error"] ** 2).mean()))
    blocks: list[Block] = [
        Paragraph(
            f"The {len(surface.cases)} cases that count become C_e(r, f, Γ) and m_a(r, f, Γ) with "
            "a standard error everywhere: Gaussian processes in r, Γ and stroke over clear gap "
            "W/L, weighted by the errors of the cases, without dissipation below the onset "
            f"Γ₀ = {surface.onset_g:g} and cut at the bound of an inelastic bed. Each case "
            f"foretold by the others: ln C_e is off by {rms:.2f} rms, a factor of "
            f"{np.exp(rms):.2f}; {(z.abs() < 1.96).mean():.0%} lie within 1.96 of the standard "
            "errors foretold. The domain is the convex hull of the cases in r, ln f and ln Γ: "
            + ", ".join(
                f"{name} {low:g} to {high:g}"
                for name, low, high in zip(("r", "f", "Γ"), surface.low, surface.high, strict=True)
            )
            + " (Hz, g)."
        ),
        _picture(
            "map_frequency_level",
            damping_figures.map_figure(surface, "frequency_hz", "acceleration_g"),
            "C_e and loss factor over frequency and amplitude at the fills that were run. Circles: "
            "cases; white: outside the domain.",
        ),
        _picture(
            "map_fill_frequency",
            damping_figures.map_figure(surface, "fill_fraction", "frequency_hz"),
            "The same over fill fraction and frequency at the amplitudes that were run.",
        ),
        _picture(
            "damping_left_out",
            damping_figures.left_out_figure(left),
            "Each case as the others foretell it, with the standard error foretold.",
        ),
    ]
    if results.rounds:
        blocks.insert(1, target_table(results.rounds))
    blocks += law_blocks(results)
    blocks += form_blocks(results)
    good = results.cases[results.cases["status"] == "ok"]
    if all(column in good and good[column].notna().any() for column, _ in SHARES):
        blocks.append(
            _picture(
                "loss_split",
                damping_figures.split_figure(good, SHARES),
                "What the spheres lose along the normal of their contacts and along the surface "
                "(friction), as shares of the loss.",
            )
        )
    return Section("damping", "Damping law", blocks)


def target_table(rounds: Sequence[Mapping[str, Any]]) -> Table:
    """How the rms values narrowed, round by round."""
    rows = []
    for before, one in pairwise(rounds):
        worst = max(
            (error, f"{label}, point {point}")
            for label, of in one["relative_error"].items()
            for point, error in of.items()
        )
        rows.append([str(one["round"]), str(len(before["cases"])), f"{worst[0]:.2%}", worst[1]])
    last = rounds[-1]
    end = "is met" if last["reached"] else "is not met: no case was left, or none was allowed"
    return Table(
        f"Cases chosen in rounds, each of those that narrow the rms accelerations most; the target "
        f"{end} with {len(last['cases'])} cases",
        ["round", "cases run", "largest relative standard error of the rms", "of"],
        rows,
    )


# --------------------------------------------------------------------------- the law


def law_blocks(results: DampingResults) -> list[Block]:
    """The equation with its constants, at every amplitude and fill, beside the paper's."""
    law = results.law[results.law["form"] == "paper"]
    over = law[law["fill_fraction"].isna()]
    blocks: list[Block] = []
    if len(over):
        best = float(over["acceleration_g"].to_numpy()[int(over["scatter"].argmin())])
        of = over[over["acceleration_g"] == best].set_index("constant")
        blocks.append(Paragraph(quoted(of, best)))

    def fitted(frequency: Array, fill: float, level: float) -> Array:
        of = over[np.isclose(over["acceleration_g"], level)].set_index("constant")
        if not len(of):
            return np.full(frequency.shape, np.nan)
        constants = of.loc[list(OVER_FILL), "value"].to_numpy(float)
        a1, a2, a3 = constants_at(np.full(frequency.shape, fill), constants)
        with np.errstate(invalid="ignore"):
            return np.where(a1 > 0, equation_5(2 * np.pi * frequency, a1, a2, a3), np.nan)

    blocks.append(
        _picture(
            "damping_law",
            damping_figures.law_figure(results.surface, fitted),
            "Cases with their standard errors, the surface with its own, and Eq. 5 with constants "
            "in the structure of Eq. 6 fitted at each Γ. Dotted: C_e = 4 m″ω/π.",
        )
    )
    if len(over):
        blocks.append(_over_fill_table(over))
    at = law[law["fill_fraction"].notna()]
    if len(at):
        blocks.append(_at_fill_table(at))
    return blocks


def quoted(of: pd.DataFrame, level: float) -> str:
    """The law in one sentence, as it would be quoted.

    Parameters
    ----------
    of
        Rows of ``law.csv`` over fill at one amplitude, by constant.
    level
        That amplitude, g.
    """
    v = {str(name): float(value) for name, value in of["value"].items()}
    first = of.iloc[0]
    a1 = f"{number(np.exp(v['ln_alpha']))} r (1{_term(v['beta1'])} r{_term(v['beta2'])} r²)"
    a2 = f"{number(v['gamma0'])}{_term(v['gamma1'])} r"
    a3 = f"r ({_signed(v['delta0'])}{_term(v['delta1'])} r)"
    return (
        f"The law of these cases at Γ = {level:g}, where the form fits best: "
        f"C_e = (1/2π) a₁ ω^(a₂−1) e^(−a₃ω) with a₁ = {a1}, a₂ = {a2}, a₃ = {a3} s; C_e in N s/m³, "
        f"ω = 2πf in rad/s. It scatters by {first['scatter']:.2f} in ln C_e about the "
        f"{int(first['points'])} cases; the intervals of its constants stand in the table."
    )


def _term(value: float) -> str:
    return f" {'−' if value < 0 else '+'} {number(abs(value))}"


def _interval(of: pd.DataFrame, constant: str, *, exponent: bool = False) -> str:
    """Value [low, high] of a constant, or of e to it."""
    numbers = [float(of[name][constant]) for name in ("value", "low", "high")]
    value, low, high = (float(np.exp(n)) for n in numbers) if exponent else numbers
    return f"{_signed(value)} [{_signed(low)}, {_signed(high)}]"


def _signed(value: float) -> str:
    return ("−" if value < 0 else "") + number(abs(value))


def _over_fill_table(over: pd.DataFrame) -> Table:
    names = ["α", "β₁", "β₂", "γ₀", "γ₁", "δ₀, s", "δ₁, s"]
    rows = []
    for level, of in over.groupby("acceleration_g"):
        by_name = of.set_index("constant")
        cells = [_interval(by_name, c, exponent=c == "ln_alpha") for c in OVER_FILL]
        first = of.iloc[0]
        rows.append([f"{level:g}", *cells, f"{first['scatter']:.2f}", str(int(first["points"]))])
    return Table(
        "Eq. 5 in the structure of Eq. 6, a₁ = α r (1 + β₁ r + β₂ r²), a₂ = γ₀ + γ₁ r, "
        "a₃ = r (δ₀ + δ₁ r), ω in rad/s, fitted at each Γ: value [95 % confidence interval]. As "
        "printed, with ω or f: α = −20·10⁻⁴, β₁ = −1.80, β₂ = 1.26, γ₀ = 4.10, γ₁ = −0.6, "
        "δ₀ = 8.8·10⁻⁴, δ₁ = −12.5·10⁻⁴; corrected: |a₁| and f in Hz.",
        ["Γ", *names, "scatter of ln C_e", "cases"],
        rows,
    )


def _at_fill_table(at: pd.DataFrame) -> Table:
    rows = []
    for (level, fill), of in at.groupby(["acceleration_g", "fill_fraction"]):
        by_name = of.set_index("constant")
        cells = [_interval(by_name, c, exponent=c == "ln_a1") for c in AT_FILL]
        a1, a2, a3 = paper_constants(float(of["fill_fraction"].iloc[0]))
        # (f in Hz) = ω/2π: the corrected law with ω in rad/s
        corrected = [abs(a1) * (2 * np.pi) ** (1 - a2), a2, a3 / (2 * np.pi)]
        first = of.iloc[0]
        rows.append(
            [f"{level:g}", f"{fill:g}", *cells, ", ".join(_signed(c) for c in (a1, a2, a3)),
             ", ".join(_signed(c) for c in corrected), f"{first['scatter']:.2f}",
             str(int(first["points"]))]
        )  # fmt: skip
    return Table(
        "Constants of Eq. 5 at each Γ and fill: value [95 % confidence interval], ω in rad/s; wide "
        "where three constants meet four or five frequencies",
        ["Γ", "r", "a₁", "a₂", "a₃, s", "the paper's a₁, a₂, a₃ as printed",
         "corrected, for ω in rad/s", "scatter of ln C_e", "cases"],
        rows,
        folded=True,
    )  # fmt: skip


# --------------------------------------------------------------------------- the forms


def form_blocks(results: DampingResults) -> list[Block]:
    """Forms compared by cases left out, and the collapse on dimensionless axes."""
    rows = [
        [
            FORM_NAMES[row["form"]],
            str(int(row["constants"])) if row["constants"] else "–",
            f"{row['rms']:.2f}",
            f"{row['held_out_rms']:.2f}",
            f"{np.exp(row['held_out_rms']):.2g}",
            f"{np.exp(row['held_out_largest']):.2g}",
            number(row["information"]),
        ]
        for row in records(results.comparison)
    ]
    table = Table(
        "Closed forms for all cases of every Γ, with η = C_e/(m″ω), h = 1 − (Γ₀/Γ)² and W/L the "
        "stroke over the clear gap. Errors are those of ln C_e; cases left out are a tenth at a "
        "time, all constants fitted anew without them; AICc: lower is better",
        ["form", "constants", "rms, fitted", "rms, left out", "typical factor, left out",
         "largest factor, left out", "AICc"],
        rows,
    )  # fmt: skip
    points, log_eta = forms.points_of(results.surface, results.depth)
    of = results.law[results.law["form"] == "two_regimes"].set_index("constant")
    regimes = None
    blocks: list[Block] = [table]
    if len(of):
        (form,) = (f for f in forms.FORMS if f.name == "two_regimes")
        constants = of.loc[list(form.constants), "value"].to_numpy(float)
        regimes = damping_figures.Regimes(lambda p: form.function(constants, p))
        blocks.insert(0, Paragraph(quoted_regimes(of)))
    blocks.append(
        _picture(
            "damping_collapse",
            damping_figures.collapse_figure(points, log_eta, regimes),
            "Loss factors of all cases on dimensionless axes; the larger the dot, the fuller the "
            "cell. Lines: the form of two regimes at r = 0.5. Dotted: bound of an inelastic bed, "
            "4/π.",
        )
    )
    return blocks


def quoted_regimes(of: pd.DataFrame) -> str:
    """The form of two regimes with its constants and their 95 % intervals."""

    def value(name: str) -> str:
        return _interval(of, name, exponent=name.startswith("ln_"))

    return (
        "One law for every amplitude: C_e = m″ω h [A r^p Γ^−q + B x^s/(1 + (x/x₀)^t)], x = W/L, "
        f"with A = {value('ln_A')}, p = {value('p')}, q = {value('q')} (the agitated bed) and "
        f"B = {value('ln_B')}, s = {value('s')}, x₀ = {value('ln_x0')}, t = {value('t')} (the bed "
        "that crosses the gap as one)."
    )


def _picture(name: str, figure: damping_figures.Figure, caption: str) -> Picture:
    return Picture(name, style.png(figure), caption)
