"""Proposed layouts against all layouts of 20 panels drawn at random: the table of docs/theory."""

import sys
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "tests" / "optimise"))

from random_panels import RandomPanel, exhaustive, problems

from pidpanel.optimise.search import branch_and_bound, greedy, sample_submodularity

PANELS = int(sys.argv[1]) if sys.argv[1:] else 20


def main() -> None:
    """Print a row per excitation."""
    print("| excitation | largest excess, dB | largest gap, dB | gap holds | violations on |")
    print("|---|---|---|---|---|")
    for number, excitation in enumerate(("sound", "base", "both")):
        excesses, gaps, violated = np.zeros((3, PANELS))
        for seed in range(PANELS):
            panels = [RandomPanel(seed, seed % 4 == 3, moving) for moving in (False, True)]
            problem, whole = (problems(*panels, is_largest=seed % 2 == 0)[number] for _ in range(2))
            sampling = sample_submodularity(problem)
            proof = branch_and_bound(problem, greedy(problem), sampling, 100)
            excesses[seed] = 10 * np.log10(proof.value / exhaustive(whole))
            gaps[seed], violated[seed] = proof.gap_db, sampling.violations > 0
        holds = np.count_nonzero(excesses <= gaps + 1e-3)
        print(
            f"| {excitation} | {excesses.max():.3f} | {gaps.max():.3f} | {holds} of {PANELS} | "
            f"{violated.sum():.0f} of {PANELS} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
