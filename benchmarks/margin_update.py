"""Coverage, remaining shares and regret of the update of `margin_launch.yaml`.

    python benchmarks/margin_update.py runs.npz [laboratories]

makes the runs (5 CPU-minutes), unless the file is there, and prints the table of docs/margin.md.
The truth of each laboratory is a run of its own, outside of those that the chaos is fitted to. Its
tests show what that run shows, with errors. The nested share is the mean variance of the posterior
over laboratories, less that of the linear posterior of the same results, of which the regression
has the exact mean.
"""

import sys
from pathlib import Path

import numpy as np

import pidpanel.margin.from_study as stage
from pidpanel.check import checked_study
from pidpanel.margin.chaos import fitted
from pidpanel.margin.inputs.from_study import BROADBAND, UncertainStudy
from pidpanel.margin.next_test import common_errors, joined, posterior, remaining
from pidpanel.margin.observations import measurements_of
from pidpanel.margin.samples import DRAWS, columns_of
from pidpanel.margin.update.posterior import IMPROBABLE, Emulator, Result
from pidpanel.study.uncertain import SPECTRUM, Errors

RUNS, POINT = 256, 0  # of the chaos; point 326
ENDS = (0.05, 0.95)


def runs(file, laboratories):
    """Scores and what the runs show; those of laboratories are behind `RUNS`."""
    study = checked_study(Path(__file__).parents[1] / "workflow" / "studies" / "margin_launch.yaml")
    uncertain = UncertainStudy(study, None)
    if not file.exists():
        stage.TESTED = sys.maxsize
        truth = np.random.default_rng(77).standard_normal((laboratories, uncertain.size))
        samples = np.vstack([stage.scores(uncertain.groups, RUNS), np.clip(truth, -3, 3)])
        spread, rows = stage.SpreadStudy(study, None, samples), []
        rows = stage._results(spread, RUNS, rows)
        stage.DRAWS = 1  # each laboratory has a panel of its own
        rows = stage._results(spread, len(samples), rows)
        shown = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        np.savez(file, scores=samples, **shown)
    return uncertain, dict(np.load(file))


def main(file, laboratories=200):
    uncertain, shown = runs(file, laboratories)
    z, g = shown["scores"], shown["damped"][:, 0, POINT]
    parts = dict(zip((g.name for g in uncertain.groups), columns_of(uncertain.groups), strict=True))
    unseen = [parts[SPECTRUM]]
    errors = [*uncertain.error_columns.values()]
    errors += [part for name, part in parts.items() if name == BROADBAND]
    tests = measurements_of(shown, Errors(), uncertain.band_edges, unseen)
    answer = fitted(z[:RUNS], g[:RUNS], is_log=True, draws=DRAWS)
    rng = np.random.default_rng(0)
    variance = answer(rng.standard_normal((2**16, z.shape[1]))).var()
    white = rng.standard_normal((2**13, z.shape[1]))
    print(f"Q² {answer.q2:.4f}; {laboratories} laboratories", flush=True)
    print("test | 90 % covers | share: regression | nested | samples that weigh | refused")
    shares = {}
    pairs = [("modal survey", "microphones"), tuple(n for n in tests if n.startswith("acoustic"))]
    for names in [*((name,) for name in tests), *pairs, tuple(tests)]:
        parts_ = [tests[name]._replace(values=tests[name].values[:RUNS]) for name in names]
        result = [Result(n, p, p.values[0], ()) for n, p in zip(names, parts_, strict=True)]
        emulator = Emulator(z[:RUNS], result, errors)
        B, R = joined(z[:RUNS], parts_, errors)
        C = posterior(B, R)
        regression = remaining(answer, C)[0]
        gain = C @ B.T @ np.linalg.inv(R)
        offset = (
            np.concatenate([p.values.mean(axis=0) for p in parts_]) - z[:RUNS].mean(axis=0) @ B.T
        )
        value, vector = np.linalg.eigh(C)
        scatter = white @ (vector * np.sqrt(np.maximum(value, 0))).T
        own = np.diag(np.concatenate([p.error for p in parts_]) ** 2) + common_errors(parts_)
        noise = np.random.default_rng(5).standard_normal((laboratories, len(own)))
        noise = noise @ np.linalg.cholesky(own).T
        rows = []
        for number in range(laboratories):
            lab = RUNS + number
            emulator.value = np.concatenate([tests[n].values[lab] for n in names]) + noise[number]
            scores, weigh = emulator.posterior()
            values = answer(scores)
            drawn = values * np.exp(np.random.default_rng(4).choice(answer.missed, len(values)))
            low, high = np.quantile(drawn, ENDS)
            linear = answer(gain @ (emulator.value - offset) + scatter).var()
            rows.append([low <= g[lab] <= high, values.var() - linear, weigh,
                         emulator.probability()[0] < IMPROBABLE])  # fmt: skip
        covers, difference, weigh, refused = np.mean(rows, axis=0)
        error = np.std(rows, axis=0)[1] / variance / np.sqrt(laboratories)
        nested = regression + difference / variance
        if len(names) == 1:
            shares[names[0]] = regression, nested
        row = [f"{covers:.3f}", f"{regression:.3f}", f"{nested:.3f} ± {error:.3f}", f"{weigh:.2f}"]
        print(" + ".join(names), *row, f"{refused:.3f}", sep=" | ", flush=True)
    advised = min(shares, key=lambda name: shares[name][0])
    best = min(nested for _, nested in shares.values())
    print(f"advised: {advised}; regret {shares[advised][1] - best:.4f} of the variance")


if __name__ == "__main__":
    main(Path(sys.argv[1]), *map(int, sys.argv[2:]))
