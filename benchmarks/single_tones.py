"""How far single tones and the paper's law are from coupled runs of the same scenarios.

The scenarios of `coupled_scenarios.py` with one damper, acrylic and steel, against the mean of
their coupled runs in the same folder. The difference of ln g rms is compared with the effect that
the damping model gives the damper, against the same mass without damping: their ratio is
`of_effect` of `pidpanel.damping.broadband`, the rms difference of the law its `of_rms`.

    python benchmarks/single_tones.py [folder] [runs]

About half an hour on two cores after `coupled_scenarios.py`. The table of docs/theory/damping.md
is printed.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import coupled_scenarios
import numpy as np
import pandas as pd
import yaml

from pidpanel.damping.broadband import PAPER_LAW, SINGLE_TONES
from pidpanel.paths import WORKFLOW

SWEEPS = {
    "acrylic": {},
    "steel": {"fill_fraction": [0.06, 0.15, 0.3, 0.45], "frequency_hz": [30, 120, 500, 2000]},
}
"""Of each damper, what its sweep has besides that of ``level.yaml``."""


def summary_of(folder: Path, damper: str) -> pd.DataFrame:
    """Return ``summary.csv`` of the scenarios with a damper, by single tones and by the law."""
    values = yaml.safe_load((WORKFLOW / "studies" / "level.yaml").read_text())
    dampers = yaml.safe_load((WORKFLOW / "studies" / "layouts.yaml").read_text())["dampers"]
    particles = dampers[damper]["particles"]
    bed = {**values["dampers"]["acrylic"], "model": "tones"}
    cases = {"acrylic": coupled_scenarios.ACRYLIC, "steel": coupled_scenarios.STEEL}[damper]
    values |= {
        "dampers": {
            "tones": {**bed, "particles": particles, "sweep": {**bed["sweep"], **SWEEPS[damper]}},
            "law": {"law": "paper_corrected"},
        },
        "damping": {"level": {"kind": "patch"}},
        "response": {"frequency_hz": [30, 2000], "damper_mass": True},
        "scenarios": {
            f"{damper}_PID-{patch}_r{fill:g}_{level:g}": {
                "patch": f"PID-{patch}", "damper": ["tones", "law"], "fill_fraction": fill,
                "oaspl_db": level,
            }
            for patch, fill, level in cases
        },
    }  # fmt: skip
    name = f"tones_{damper}"
    (folder / f"{name}.yaml").write_text(yaml.safe_dump(values, sort_keys=False))
    target = f"results/{name}/response/summary.csv"
    workflow = ["-s", str(WORKFLOW / "Snakefile"), "-d", str(folder)]
    snakemake = str(Path(sys.executable).with_name("snakemake"))
    study = ["--configfile", str(folder / f"{name}.yaml")]
    subprocess.run([snakemake, target, "-q", "all", "-j2", *workflow, *study], check=True)
    summary = pd.read_csv(folder / target, dtype={"point": str})
    filled = summary[summary["patch"] != "none"]
    label = [
        f"{damper}_{patch}_r{fill:g}_{level:g}"
        for patch, fill, level in zip(
            filled["patch"], filled["fill_fraction"], filled["oaspl_db"], strict=True
        )
    ]
    law = filled["scenario"].str.contains("_law_")
    return filled.assign(scenario=label, damper=np.where(law, "law", "tones"))


def compared(folder: Path, runs: int) -> pd.DataFrame:
    """Return a row for each damping model, scenario and point: differences of ln g rms."""
    tables = pd.concat([summary_of(folder, damper) for damper in SWEEPS])
    labels = list(dict.fromkeys(tables["scenario"]))
    coupled = pd.concat([coupled_scenarios.told(folder, label, runs) for label in labels])
    mean = coupled.groupby(["scenario", "point"], as_index=False)["g_rms"].mean()
    table = tables.merge(mean, on=["scenario", "point"])
    in_ln = np.log(10) / 20
    return table.assign(
        difference=np.log(table["acceleration_rms_g"] / table["g_rms"]),
        effect=in_ln * (table["reduction_db"] - table["dead_weight_reduction_db"]),
        error=in_ln * np.hypot(table["reduction_error_db"], 0.06),
    )


def main() -> None:
    """Print the table, and how often the stated errors hold."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "build/coupled_scenarios").resolve()
    table = compared(folder, int(sys.argv[2]) if len(sys.argv) > 2 else 2)
    table.to_csv(folder / "single_tones.csv", index=False)
    print("| scenario | Γ | coupled | single tones | over the effect | paper's law |")
    print("|---|---|---|---|---|---|")
    for label, rows in table.groupby("scenario", sort=False):
        tones, law = (rows[rows["damper"] == name] for name in ("tones", "law"))
        ratio = tones["difference"] / tones["effect"]
        print(
            f"| {label} | {tones['damping_read_at_g'].iloc[0]:.3g} | {_values(tones['g_rms'])} | "
            f"{_percent(tones['difference'])} | {' / '.join(f'{x:.2f}' for x in ratio)} | "
            f"{_percent(law['difference'])} |"
        )
    tones, law = (table[table["damper"] == name] for name in ("tones", "law"))
    z = tones["difference"] / tones["error"]
    print(
        f"single tones ({SINGLE_TONES.of_effect} of the effect): mean z {z.mean():.2f}, "
        f"rms {np.sqrt((z**2).mean()):.2f}, {(z.abs() <= 1.65).mean():.0%} within 1.65 errors"
    )
    rms = np.sqrt((law["difference"] ** 2).mean())
    print(f"law ({PAPER_LAW.of_rms}): rms difference {rms:.2f}")


def _values(column: pd.Series) -> str:
    return " / ".join(f"{value:.3g}" for value in column)


def _percent(column: pd.Series) -> str:
    return " / ".join(f"{100 * np.expm1(value):+.0f}" for value in column) + " %"


if __name__ == "__main__":
    main()
