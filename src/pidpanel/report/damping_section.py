"""The damping on the page: the surface, the laws as an engineer quotes them."""

from functools import partial

import numpy as np
import pandas as pd

from pidpanel.arrays import Array
from pidpanel.damping import forms
from pidpanel.damping.fit import OVER_FILL, constants_at
from pidpanel.damping.laws import equation_5
from pidpanel.report import damping_figures, style
from pidpanel.report.html import Block, PageSection, Paragraph, Picture, Table
from pidpanel.report.inputs import DampingResults
from pidpanel.report.text import number, percent


def damping_section(results: DampingResults) -> PageSection:
    """Return the surface and the laws."""
    surface = results.surface
    left = surface.leave_one_out()
    z = left["log_error"] / left["log_standard_error"]
    rms = float(np.sqrt((left["log_error"] ** 2).mean()))
    blocks: list[Block] = [
        Paragraph(
            f"{len(surface.cases)} cases give C_e(r, f, Γ) and m_a(r, f, Γ) with standard "
            "errors by Gaussian processes in r, Γ and stroke over clear gap W/L, weighted by "
            "the errors of the cases. One process covers beds that ride on the floor, another "
            "the deviation from the perfectly inelastic body for beds that cross the gap. "
            "Between them the error covers both regimes. Below the onset Γ₀ = "
            f"{surface.onset_g:g} there is no dissipation, and C_e is limited to the bound of "
            "an inelastic bed. If each case is predicted from the others, the error of ln C_e "
            f"is {rms:.2f} rms (a factor of {np.exp(rms):.2f}), and "
            f"{percent((z.abs() < 1.96).mean())} of the cases lie within 1.96 predicted "
            "standard errors. The simulated range is the convex hull of the cases in r, ln f "
            "and ln Γ: "
            + ", ".join(
                f"{name} from {low:g} to {high:g}{unit}"
                for name, unit, low, high in zip(
                    ("r", "f", "Γ"), ("", " Hz", ""), surface.low, surface.high, strict=True
                )
            )
            + "."
        ),
        Picture(
            "map_frequency_acceleration",
            style.Drawing(damping_figures.map_figure, surface, "frequency_hz", "acceleration_g"),
            "C_e and loss factor over frequency and Γ at the simulated fills. Circles: cases. "
            "White: outside the simulated range.",
        ),
    ]
    blocks += law_blocks(results)
    blocks += form_blocks(results)
    return PageSection("damping", "Damping law", blocks)


def law_blocks(results: DampingResults) -> list[Block]:
    """Return the equation with its constants at every Γ and fill, beside the paper's."""
    law = results.law[results.law["form"] == "paper"]
    # at a Γ with cases of one fill alone there is nothing to tell over fill
    over_fill = law[law["fill_fraction"].isna() & law["constant"].isin(OVER_FILL)]
    blocks: list[Block] = []
    if len(over_fill):
        best = float(over_fill["acceleration_g"].to_numpy()[int(over_fill["scatter"].argmin())])
        constants = over_fill[over_fill["acceleration_g"] == best].set_index("constant")
        blocks.append(Paragraph(quoted(constants, best)))

    def fitted(frequency: Array, fill: float, gamma: float) -> Array:
        at_gamma = over_fill[np.isclose(over_fill["acceleration_g"], gamma)].set_index("constant")
        if not len(at_gamma):
            return np.full(frequency.shape, np.nan)
        constants = at_gamma.loc[list(OVER_FILL), "value"].to_numpy(float)
        a1, a2, a3 = constants_at(np.full(frequency.shape, fill), constants)
        with np.errstate(invalid="ignore"):
            return np.where(a1 > 0, equation_5(2 * np.pi * frequency, a1, a2, a3), np.nan)

    blocks.append(
        Picture(
            "damping_law",
            style.Drawing(damping_figures.law_figure, results.surface, fitted),
            "Cases and surface with their standard errors, and Eq. 5 with constants in the form of "
            "Eq. 6, fitted at each Γ. Dotted: C_e = 4 m″ω/π.",
        )
    )
    if len(over_fill):
        blocks.append(_over_fill_table(over_fill))
    return blocks


def quoted(constants: pd.DataFrame, gamma: float) -> str:
    """Return the law in one sentence, as it would be quoted."""
    v = {str(name): float(value) for name, value in constants["value"].items()}
    first = constants.iloc[0]
    a1 = f"{number(np.exp(v['ln_alpha']))} r (1{_term(v['beta1'])} r{_term(v['beta2'])} r²)"
    a2 = f"{number(v['gamma0'])}{_term(v['gamma1'])} r"
    a3 = f"r ({number(v['delta0'])}{_term(v['delta1'])} r)"
    return (
        f"Law of these cases at Γ = {gamma:g}, where the form fits best: C_e = (1/2π) a₁ "
        f"ω^(a₂−1) e^(−a₃ω) with a₁ = {a1}, a₂ = {a2}, a₃ = {a3} s; C_e in N s/m³, ω = 2πf in "
        f"rad/s. The {int(first['points'])} cases scatter about it by {first['scatter']:.2f} "
        "in ln C_e. The table gives the confidence intervals of the constants."
    )


def _term(value: float) -> str:
    return f" {'−' if value < 0 else '+'} {number(abs(value))}"


def _interval(constants: pd.DataFrame, constant: str, *, exponent: bool = False) -> str:
    """Return a constant, or e to it, with its interval: value [low, high]."""
    numbers = [float(constants[name][constant]) for name in ("value", "low", "high")]
    if exponent:
        with np.errstate(over="ignore"):  # an interval without an end
            numbers = np.exp(numbers).tolist()
    value, low, high = numbers
    return f"{number(value)} [{number(low)}, {number(high)}]"


def _over_fill_table(over_fill: pd.DataFrame) -> Table:
    names = ["α", "β₁", "β₂", "γ₀", "γ₁", "δ₀, s", "δ₁, s"]
    rows = []
    for gamma, group in over_fill.groupby("acceleration_g"):
        by_name = group.set_index("constant")
        cells = [_interval(by_name, c, exponent=c == "ln_alpha") for c in OVER_FILL]
        first = group.iloc[0]
        rows.append([f"{gamma:g}", *cells, f"{first['scatter']:.2f}", str(int(first["points"]))])
    return Table(
        "Eq. 5 in the form of Eq. 6, a₁ = α r (1 + β₁ r + β₂ r²), a₂ = γ₀ + γ₁ r, "
        "a₃ = r (δ₀ + δ₁ r), ω in rad/s, fitted at each Γ: value [95 % confidence interval]. "
        "As printed (unit of ω not stated): α = −20·10⁻⁴, β₁ = −1.80, β₂ = 1.26, γ₀ = 4.10, "
        "γ₁ = −0.6, δ₀ = 8.8·10⁻⁴, δ₁ = −12.5·10⁻⁴. Corrected: |a₁|, and f in Hz.",
        ["Γ", *names, "scatter of ln C_e", "cases"],
        rows,
    )


def form_blocks(results: DampingResults) -> list[Block]:
    """Return the law of two regimes, and the cases on dimensionless axes."""
    points, log_eta = forms.points_of(results.surface, results.depth)
    regimes = results.law[results.law["form"] == "two_regimes"].set_index("constant")
    drawn = None
    blocks: list[Block] = []
    if len(regimes):
        constants = regimes.loc[list(forms.CONSTANTS), "value"].to_numpy(float)
        drawn = partial(forms.two_regimes, constants)
        blocks.append(Paragraph(quoted_regimes(regimes)))
    blocks.append(
        Picture(
            "damping_collapse",
            style.Drawing(damping_figures.collapse_figure, points, log_eta, drawn),
            "Loss factors of all cases on dimensionless axes; larger dots: fuller cells. Lines: "
            "the form of two regimes at r = 0.5. Dotted: bound of an inelastic bed, 4/π.",
        )
    )
    return blocks


def quoted_regimes(constants: pd.DataFrame) -> str:
    """Return the form of two regimes with its constants and their 95 % intervals."""

    def value(name: str) -> str:
        return _interval(constants, name, exponent=name.startswith("ln_"))

    return (
        "One law for every Γ: C_e = m″ω h [A r^p Γ^−q + B x^s/(1 + (x/x₀)^t)], x = W/L, "
        f"with A = {value('ln_A')}, p = {value('p')}, q = {value('q')} (agitated bed) and "
        f"B = {value('ln_B')}, s = {value('s')}, x₀ = {value('ln_x0')}, t = {value('t')} (bed that "
        "crosses the gap as one body). The "
        f"{int(constants.iloc[0]['points'])} cases scatter about it by "
        f"{constants.iloc[0]['scatter']:.2f} in ln C_e."
    )
