"""Do the stated errors of coupled scenarios hold? 24 of them, run several times each.

The paper's panel with acrylic and steel particles at three patches, r = 0.05 to 0.9, 119 to 150 dB,
of 1 to 10 times the panel's mass; two layouts of two dampers. None of them set a constant of
`pidpanel.coupled`. Every run has packings and a sound of its own. What one run states is compared
with the mean of the other runs of its scenario: z is the difference over both errors together.

    python benchmarks/coupled_scenarios.py [folder] [runs]
    python benchmarks/coupled_scenarios.py folder 1 further

The second makes one run of each of the further scenarios, on which the atlas is counted.

About forty minutes on two cores for two runs. Records are kept in the folder and not made
again. The table of coupled.md is printed.
"""

from __future__ import annotations

import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupled.excited_panel import ExcitedPanel
from pidpanel.coupled.from_study import coupled_scenarios, read_excited_panel
from pidpanel.coupled.scenario_runs import ScenarioRuns
from pidpanel.paths import WORKFLOW
from pidpanel.provenance.files import Files
from pidpanel.study import Study, load_study

ACRYLIC = [
    (1, 0.1, 125), (1, 0.1, 142), (1, 0.2, 147), (1, 0.3, 119), (1, 0.3, 131), (1, 0.4, 136.7),
    (1, 0.5, 150), (1, 0.6, 122), (1, 0.7, 134), (1, 0.8, 128), (2, 0.5, 136.7), (3, 0.5, 139.7),
    (3, 0.9, 131), (2, 0.9, 142), (2, 0.2, 145), (3, 0.7, 147),
]  # fmt: skip
STEEL = [
    (1, 0.06, 136.7), (1, 0.1, 142), (2, 0.15, 131), (3, 0.2, 136.7), (1, 0.3, 139.7),
    (1, 0.45, 147),
]  # fmt: skip
"""Number of the patch, fill, level [dB]."""
FURTHER = {
    "acrylic": [
        (3, 0.9, 139.7), (1, 0.7, 145), (3, 0.8, 136.7), (2, 0.7, 142), (1, 0.15, 137),
    ],
    "steel": [(1, 0.4, 136.7), (1, 0.08, 128), (3, 0.1, 140), (1, 0.2, 131), (3, 0.3, 145)],
}  # fmt: skip
TWO = {
    "two_light": ({"PID-2": ("acrylic", 0.5), "PID-3": ("acrylic", 0.9)}, 140),
    "two_heavy": ({"PID-1": ("steel", 0.1), "PID-3": ("acrylic", 0.5)}, 136.7),
}


def scenarios() -> dict[str, object]:
    """Return the scenarios as a study has them."""
    sets = FURTHER if "further" in sys.argv else {"acrylic": ACRYLIC, "steel": STEEL}
    one = [
        (f"{damper}_PID-{patch}_r{fill:g}_{level:g}", {f"PID-{patch}": (damper, fill)}, level)
        for damper, cases in sets.items()
        for patch, fill, level in cases
    ]
    two = {} if "further" in sys.argv else TWO
    return {
        name: {
            "layout": {
                patch: {"damper": damper, "fill_fraction": fill}
                for patch, (damper, fill) in layout.items()
            },
            "oaspl_db": level,
        }
        for name, layout, level in [*one, *((name, *case) for name, case in two.items())]
    }


@cache
def studied(folder: Path) -> tuple[Study, ExcitedPanel]:
    """Return the study of all scenarios and its panel."""
    values = yaml.safe_load((WORKFLOW / "studies" / "layouts.yaml").read_text())
    values["response"] = {"frequency_hz": [30, 2000], "damper_mass": True}
    values["damping"] = {"coupled": {"runs": 8}}
    return made_panel(folder, "errors", {**values, "scenarios": scenarios()})


def made_panel(folder: Path, name: str, values: dict[str, object]) -> tuple[Study, ExcitedPanel]:
    """Return a study and its panel, meshed and solved in a folder where it is not there yet."""
    folder.mkdir(parents=True, exist_ok=True)
    path, made = folder / f"{name}.yaml", folder / "results" / name
    path.write_text(yaml.safe_dump(values, sort_keys=False))
    files = [made / file for file in ("panel/modes.nc", "sound/modal_force.nc", "panel/plate.nc")]
    targets = [str(file.relative_to(folder)) for file in files]
    workflow = ["-s", str(WORKFLOW / "Snakefile"), "-d", str(folder), "--configfile", str(path)]
    snakemake = str(Path(sys.executable).with_name("snakemake"))
    subprocess.run([snakemake, *targets, "-q", "all", "-j2", *workflow], check=True)
    study = load_study(str(path))
    named = dict(zip(("modes", "modal_force", "plate"), ([file] for file in files), strict=True))
    return study, read_excited_panel(study, Files(named))


def runs_of(folder: Path, label: str) -> ScenarioRuns:
    """Return the runs of a scenario."""
    study, panel = studied(folder)
    records = folder / "records" / label
    records.mkdir(parents=True, exist_ok=True)
    coupled = coupled_scenarios(study)[label]
    return ScenarioRuns(panel, coupled, folder / "results" / "coupon", records)


def make(folder: Path, label: str, number: int) -> str:
    """Make one record."""
    try:
        runs_of(folder, label).record(number)
    except Exception as error:  # the others go on
        return f"{label}, run {number}: {error}"
    return ""


def told(folder: Path, label: str, count: int) -> pd.DataFrame:
    """Return what each run of a scenario tells of each point: ln g rms and its errors."""
    runs = runs_of(folder, label)
    rows = []
    for number in range(1, count + 1):
        found = runs.estimate([runs.record(number)])
        acceleration = (2 * np.pi * found.frequency[:, None]) ** 4 * found.psd
        g_rms = np.sqrt(np.trapezoid(acceleration, found.frequency, axis=0)) / STANDARD_GRAVITY
        for point, name in enumerate(runs.excited.basis.point_names):
            error = found.log_error[point] / 2
            rows.append(
                {
                    "scenario": label,
                    "point": name,
                    "run": number,
                    "modulus_mpa": max(soft.modulus for soft in runs.softened) / 1e6,
                    "g_rms": g_rms[point],
                    "error": error,
                    # that of contacts is the same in all runs
                    "own_error": np.sqrt(max(error**2 - found.contact_error[point] ** 2 / 4, 0)),
                    "residual": found.residual[point] / 2,
                }
            )
    return pd.DataFrame(rows)


def counted(table: pd.DataFrame) -> pd.DataFrame:
    """Return z of each run against the mean of the others of its scenario and point."""
    parts = []
    for _, rows in table.groupby(["scenario", "point"], sort=False):
        value, error = np.log(rows["g_rms"].to_numpy()), rows["own_error"].to_numpy()
        n = len(rows)
        others = (value.sum() - value) / (n - 1)
        of_others = np.sqrt((error**2).sum() - error**2) / (n - 1)
        parts.append(rows.assign(z=(value - others) / np.hypot(error, of_others)))
    return pd.concat(parts)


def main() -> None:
    """Make the records and print the table."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "build/coupled_scenarios").resolve()
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 2
    labels = list(coupled_scenarios(studied(folder)[0]))
    wanted = [(label, number) for number in range(1, count + 1) for label in labels]
    with ProcessPoolExecutor(2) as pool:
        jobs = [pool.submit(make, folder, *one) for one in wanted]
        for job in jobs:
            if job.result():
                print(job.result(), file=sys.stderr)
        tables = [job.result() for job in [pool.submit(told, folder, one, count) for one in labels]]
    if count == 1:
        print("| scenario | modulus, MPa | g rms at 326 / 189 / 318 | stated |\n|---|---|---|---|")
        for rows in tables:
            values, errors = (
                " / ".join(f"{scale * value:.{digits}g}" for value in rows[name])
                for name, scale, digits in (("g_rms", 1, 3), ("error", 100, 2))
            )
            first = rows.iloc[0]
            print(f"| {first['scenario']} | {first['modulus_mpa']:g} | {values} | {errors} % |")
        return
    found = counted(pd.concat(tables))
    found.to_csv(folder / "z.csv", index=False)
    print("| scenario | modulus, MPa | g rms | scatter of a run | stated | z |")
    print("|---|---|---|---|---|---|")
    for label, rows in found.groupby("scenario", sort=False):
        by_point = rows.groupby("point", sort=False)
        scatter = np.sqrt(np.mean([np.log(p["g_rms"]).var(ddof=1) for _, p in by_point]))
        means = " / ".join(f"{p['g_rms'].mean():.3g}" for _, p in by_point)
        print(
            f"| {label} | {rows['modulus_mpa'].iloc[0]:g} | {means} | {scatter:.1%} | "
            f"{np.sqrt((rows['own_error'] ** 2).mean()):.1%} | "
            f"{np.sqrt((rows['z'] ** 2).mean()):.2f} |"
        )
    z = found["z"]
    print(
        f"{len(labels)} scenarios, {len(z)} values: rms z {np.sqrt((z**2).mean()):.2f}, "
        f"{(z.abs() <= 1.65).mean():.0%} within 1.65 errors"
    )


if __name__ == "__main__":
    main()
