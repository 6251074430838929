"""g rms of panels with the atlas, against coupled runs and against simulated surfaces.

    python benchmarks/atlas_panels.py [scenarios] [panels]

The atlas has none of the rows of the coupons that it is compared with, and its constants are those
of the other rows. `scenarios`: the 22 scenarios of coupled.md with one damper and its six levels,
under sound; then its further scenarios, with the whole atlas. `panels`: ten random panels under
spectra of launchers, against the same panels with surfaces of the rows that the atlas does not
have, both of tones. Panels on which these surfaces are extrapolated are left out. Minutes on a
core. The numbers of atlas.md are printed.
"""

from __future__ import annotations

import json
import re
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml
from atlas_fit import fit_constants
from coupled_scenarios import ACRYLIC, FURTHER, STEEL

from pidpanel import Model
from pidpanel.atlas.table import read_atlas as read_table
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping.atlas import Atlas, AtlasDamping, atlas_bed
from pidpanel.damping.atlas_files import read_atlas, read_rows
from pidpanel.damping.models import Damper, FilledDamper
from pidpanel.damping.surface import DampingSurface
from pidpanel.paths import ATLAS_CASES, DATA, WORKFLOW
from pidpanel.provenance.files import Files
from pidpanel.response.cases import ResponseScenario, heaviest_dampers, plan_cases, resolve
from pidpanel.response.extrapolation import between_regimes, extrapolation_of
from pidpanel.response.from_study import read_response_panel
from pidpanel.response.model_error import model_error_of, with_model_error
from pidpanel.response.panel import ResponsePanel
from pidpanel.response.results import error_parts
from pidpanel.response.trust import EXTRAPOLATED_SHARE
from pidpanel.sound.from_study import spectrum_of

COUPONS = ("level.yaml", "single_tones.py")  # in the sources of rows of the two coupons
DENSITY = {"acrylic": 1190.0, "steel": 7850.0}  # [kg/m³]
FRICTION = {"acrylic": 0.3, "steel": 0.2}
TABLES = Path(__file__).with_name("coupled.md")
PANELS, ELEMENTS = 10, np.array([24, 18])  # random panels, and their elements by side


@dataclass(frozen=True)
class Case:
    """A damper on a patch under sound."""

    damper: str
    patch: str
    fill: float
    level: float  # OASPL [dB]


@dataclass(frozen=True)
class Rms:
    """Of a case: g rms at the points, its standard errors, and shares of the change."""

    values: np.ndarray  # (n_points,) [g]
    # (n_points,) that of C_e and m_a, and with that of tones under sound
    damping_error: np.ndarray
    log_error: np.ndarray
    between: float  # at lines where W/L lies between
    extrapolated: float  # that rests on damping beyond its data


def atlas_without_coupons(folder: Path) -> Atlas:
    """Return the atlas without the rows of the two coupons, with constants of the others."""
    cases, constants = folder / "cases.csv", folder / "processes.json"
    table = pd.read_csv(ATLAS_CASES, dtype=str, keep_default_na=False)
    table[~table["source"].str.contains("|".join(COUPONS))].to_csv(cases, index=False)
    constants.write_text(json.dumps(fit_constants(read_rows(cases))))
    return read_atlas(cases, constants)


def atlas_damping(atlas: Atlas, damper: str) -> AtlasDamping:
    """Return the damping of 2 mm spheres of a material in cells of 6.35 mm × 25 mm."""
    bed = atlas_bed(0.8, FRICTION[damper], 6.35e-3, 25e-3, 2e-3, ["flat"])
    return atlas.damping_of(bed, atlas.bulk_fraction(3.175, 12.5) * DENSITY[damper] * 25e-3)


def surface(damper: str) -> DampingSurface:
    """Return the surface of the rows of a coupon."""
    rows = read_table(ATLAS_CASES)
    of_coupon = rows["source"].str.contains("|".join(COUPONS))
    rows = rows[of_coupon & (rows["density_kg_m3"] == DENSITY[damper])]
    rows = rows.rename(columns={"gamma": "acceleration_g"})
    return DampingSurface.from_frame(
        rows.drop_duplicates(["fill_fraction", "frequency_hz", "acceleration_g"]), 1.0, 25e-3
    )


def responses(
    values: Mapping[str, Any], cases: Sequence[Case], models: Mapping[str, Damper]
) -> list[Rms]:
    """Return g rms of cases on the panel of a study, with the given damping of their dampers."""
    dampers = {"any": {"equivalent_damping_n_s_m3": 100.0, "apparent_mass_kg_m2": 1.0}}
    scenario = {"any": {"patch": next(iter(values["panel"]["patches"])), "damper": "any"}}
    kept = {key: values[key] for key in ("assumptions", "panel", "sound")}
    study = {**kept, "dampers": dampers, "scenarios": scenario,
             "response": {"frequency_hz": values["response"]["frequency_hz"]}}  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        model = Model(study, folder)
        model.response()
        stages = [model._stages.files(name).all for name in ("panel", "sound")]
        read = Files({**stages[0], **stages[1]})
        panel = read_response_panel(model.study, read)
        spectrum = spectrum_of(model.study.acoustics)
        scenarios = [
            ResponseScenario(
                str(number), "bare", case.level, spectrum.pressure_factor(case.level),
                {case.patch: FilledDamper(case.damper, models[case.damper], case.fill)},
            )
            for number, case in enumerate(cases)
        ]  # fmt: skip
    return answers(panel, scenarios)


def answers(panel: ResponsePanel, scenarios: Sequence[ResponseScenario]) -> list[Rms]:
    """Return g rms of scenarios within 1e-3 of the product's, in the shapes of coupled runs."""
    panel = resolve(panel, heaviest_dampers(panel, scenarios))
    solved = plan_cases(panel, scenarios).solve(panel.solver(rms_only=True))
    return [rms_of(case, panel.coarse_frequency) for case in solved if not case.scenario.is_bare]


def rms_of(case: Any, frequency: np.ndarray) -> Rms:
    """Return g rms of a case, its errors and its shares, with lines (nf,) [Hz]."""
    error, _ = error_parts(case, case.response)
    psd = case.bare.response.acceleration_psd, case.response.response.acceleration_psd
    between, extrapolated = (
        float(share(case.dampers, case.response, frequency).share_of_change(*psd, frequency).max())
        for share in (between_regimes, extrapolation_of)
    )
    return Rms(
        case.response.response.acceleration_rms / STANDARD_GRAVITY,
        error.log_rms,
        with_model_error(error, model_error_of(case, case.response)).log_rms,
        between,
        extrapolated,
    )


def coupled_scenarios() -> list[tuple[Case, list[float], list[float]]]:
    """Return the scenarios with the g rms of their coupled runs and its errors, as the docs do."""
    text = TABLES.read_text(encoding="utf-8")
    found: list[tuple[Case, list[float], list[float]]] = []
    for damper, cases in (("acrylic", ACRYLIC), ("steel", STEEL)):
        for patch, fill, level in cases:
            case = Case(damper, f"PID-{patch}", fill, level)
            values, runs = _row(text, case, r"([\d. /]+) \| [\d.]+ % \| ([\d., ]+) % \|")
            found.append((case, values, [0.01 * float(np.hypot(*runs)) / 2] * len(values)))
    levels, values = (
        [
            float(value.split()[0])
            for value in re.findall(rf"\| {name} \|(.+)\|\n", text)[0].split("|")
        ]
        for name in ("OASPL, dB", "`coupled`")
    )
    return found + [
        (Case("acrylic", "PID-1", 0.5, level), [value], [0.02])
        for level, value in zip(levels, values, strict=True)
    ]


def further_scenarios() -> list[tuple[Case, list[float], list[float]]]:
    """Return the further scenarios likewise, with the errors of their single runs."""
    text = TABLES.read_text(encoding="utf-8")
    found = []
    for damper, cases in FURTHER.items():
        for patch, fill, level in cases:
            case = Case(damper, f"PID-{patch}", fill, level)
            values, errors = _row(text, case, r"([\d. /]+) \| ([\d. /]+) % \|")
            found.append((case, values, [error / 100 for error in errors]))
    return found


def _row(text: str, case: Case, columns: str) -> list[list[float]]:
    """Return the numbers in the last columns of the row of a scenario."""
    label = re.escape(f"| {case.damper}, {case.patch}, r = {case.fill:g}, {case.level:g} dB |")
    (row,) = re.findall(rf"{label} \d+ \| {columns}", text)
    return [[float(value) for value in re.split("[/,]", cell)] for cell in row]


def compare_scenarios(atlas: Atlas, references: Sequence[Any]) -> None:
    """Print how far the atlas is from coupled runs."""
    values = yaml.safe_load((WORKFLOW / "studies" / "layouts.yaml").read_text(encoding="utf-8"))
    values["response"] = {"frequency_hz": [30, 2000]}
    models = {name: atlas_damping(atlas, name).under_sound() for name in DENSITY}
    results = responses(values, [case for case, *_ in references], models)
    away, errors = [], []
    print("| scenario | difference of g rms | stated error |\n|---|---|---|")
    for (case, reference, known), rms in zip(references, results, strict=True):
        count = len(reference)
        away.append(np.log(rms.values[:count] / reference))
        errors.append(np.hypot(rms.log_error[:count], known))
        print(f"| {case.damper}, {case.patch}, r = {case.fill:g}, {case.level:g} dB | "
              f"{_percent(np.expm1(away[-1]))} | {_percent(errors[-1], '')} |")  # fmt: skip
    summarise(np.concatenate(away), np.concatenate(errors))


def random_panel(rng: np.random.Generator) -> tuple[dict[str, Any], Case]:
    """Return a random panel with a damper under the spectrum of a launcher."""
    spectra = sorted(path.name for path in (DATA / "spl").glob("*.csv"))
    outline = rng.uniform([0.8, 0.6], [2.0, 1.5]).round(3)
    edge, elements = outline / ELEMENTS, 2 * rng.integers(1, 4, 2)
    size = elements * edge
    centre = size / 2 + rng.integers(1, ELEMENTS - elements) * edge
    damper = str(rng.choice(list(DENSITY)))
    heaviest = 0.9 if damper == "acrylic" else 0.45
    point = rng.integers(4, ELEMENTS - 4) * edge
    values = {
        "assumptions": ["A random panel."],
        "panel": {
            "outline_m": outline.tolist(),
            "section": {
                "kind": "thin", "thickness_mm": 25,
                "mass_per_area_kg_m2": round(rng.uniform(2.5, 6), 2),
                "bending_stiffness_n_m": round(float(np.exp(rng.uniform(*np.log([1e3, 1e4]))))),
            },
            "supports": str(rng.choice(["simply_supported", "clamped"])),
            "damping_ratio": round(rng.uniform(0.007, 0.02), 4),
            "mesh": {"kind": "quadrilaterals", "elements": ELEMENTS.tolist()},
            "patches": {"P": {"centre_m": centre.tolist(), "size_m": size.tolist()}},
            "points": {"patch": centre.tolist(), "other": point.tolist()},
        },
        "sound": {"spectrum": str(rng.choice(spectra))},
        "response": {"frequency_hz": [30, 1000]},
    }  # fmt: skip
    fill = round(rng.uniform(0.08, heaviest), 2)
    return values, Case(damper, "P", fill, round(rng.uniform(122, 146), 1))


def compare_panels(atlas: Atlas) -> None:
    """Print how far the atlas is from simulated surfaces on random panels."""
    rng, away, errors = np.random.default_rng(27), [], []
    print("| panel | W/L between | difference of g rms | stated error |\n|---|---|---|---|")
    while len(away) < PANELS:
        values, case = random_panel(rng)
        models = {"atlas": atlas_damping(atlas, case.damper), "surface": surface(case.damper)}
        cases = [Case(name, case.patch, case.fill, case.level) for name in models]
        rms, reference = responses(values, cases, models)
        if reference.extrapolated > EXTRAPOLATED_SHARE:  # no reference
            continue
        away.append(np.log(rms.values / reference.values))
        errors.append(np.hypot(rms.damping_error, reference.damping_error))
        print(f"| {len(away)}: {case.damper}, r = {case.fill:g}, {case.level:g} dB | "
              f"{rms.between:.0%} | {_percent(np.expm1(away[-1]))} | "
              f"{_percent(errors[-1], '')} |", flush=True)  # fmt: skip
    summarise(np.concatenate(away), np.concatenate(errors))


def summarise(away: np.ndarray, errors: np.ndarray) -> None:
    """Print how often values lie within 5 % and within the stated errors."""
    scores = away / errors
    print(
        f"{len(away)} values: {np.sqrt(np.mean(away**2)):.1%} rms, mean {away.mean():+.1%}, "
        f"{(np.abs(away) < 0.05).mean():.0%} within 5 %, {(np.abs(scores) < 1.96).mean():.0%} "
        f"within 1.96 stated errors (rms z {np.sqrt(np.mean(scores**2)):.2f})"
    )


def _percent(values: np.ndarray, sign: str = "+") -> str:
    return " / ".join(f"{100 * value:{sign}.0f}" for value in values) + " %"


def main() -> None:
    """Print the tables."""
    chosen = sys.argv[1:] or ["scenarios", "panels"]
    with tempfile.TemporaryDirectory() as folder:
        atlas = atlas_without_coupons(Path(folder))
    if "scenarios" in chosen:
        compare_scenarios(atlas, coupled_scenarios())
        compare_scenarios(read_atlas(), further_scenarios())
    if "panels" in chosen:
        compare_panels(atlas)


if __name__ == "__main__":
    main()
