"""Proposed layouts: those to confirm, and tables of them."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from pidpanel.arrays import Array, Index
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping.models import FilledDamper
from pidpanel.optimise.excitations import Finalist
from pidpanel.optimise.objectives import Objective
from pidpanel.optimise.search import Layout, Problem, Proof, Sampling, greedy
from pidpanel.optimise.variants import VARIANTS
from pidpanel.progress import with_progress
from pidpanel.solve.model import PanelResponse

BUDGETS = 5  # equally spaced budgets up to that of the study, each with its own search

BEST = 5  # best layouts of the search that are confirmed, besides the best of smaller budgets

EXCITATIONS = ("sound", "base")  # excitations that a search may use

# Largest share in the gap of what search and confirmed layouts differ by [dB]: beyond it the search
# does not know the panel, and there is no gap
LARGEST_DRIFT = 0.5

COMPUTED = 0.05  # numerical error of a difference of reductions: lines, basis, frozen damping [dB]


def layouts_to_confirm(problem: Problem, best: Layout) -> list[Layout]:
    """Return the best layouts of a search, and the best of each smaller budget."""
    budget = problem.budget
    for number in with_progress(range(1, BUDGETS), "smaller budgets"):
        problem.budget = budget * number / BUDGETS
        greedy(problem)
    problem.budget = budget
    value = problem.evaluated
    ranked = sorted(value, key=lambda layout: (value[layout], len(layout), layout))
    chosen = [best, *[layout for layout in ranked if layout != best][: BEST - 1]]
    for number in range(1, BUDGETS):
        limit = budget * number / BUDGETS * (1 + 1e-9)
        lightest = next((layout for layout in ranked if problem.mass(layout) <= limit), None)
        if lightest is not None and lightest not in chosen:
            chosen.append(lightest)
    return chosen


@dataclass(frozen=True)
class Proposals:
    """Layouts at their consistent motion."""

    problem: Problem
    fillings: Sequence[FilledDamper]
    layouts: Sequence[Layout]  # in the order in which they were confirmed
    # The same at their consistent motion, by excitation
    finalists: Mapping[str, Sequence[Finalist]]
    counted: Index  # (n,) response points of the objective
    objective: Objective  # quantity that is minimised
    variants_db: Array  # (n_layouts, n_variants) reductions of `variants` [dB]
    # Mass [kg] → reductions of thicker face sheets and of a damping layer of that mass [dB]; NaN
    # if the study does not state them
    alternatives_db: Callable[[float], tuple[float, float]]

    def value(self, response: PanelResponse) -> float:
        """Return the objective of a response, in its unit."""
        square = self.objective.mean_square(response).max()
        return self.objective.scale * float(np.sqrt(square))

    def _reductions(self, number: int) -> dict[str, dict[str, float]]:
        """Return the results of a layout under each excitation, the smallest reduction first."""
        rows: dict[str, dict[str, float]] = {}
        for name, finalists in self.finalists.items():
            finalist = finalists[number]
            bare, value, dead = (
                self.value(response)
                for response in (finalist.bare, finalist.response, finalist.dead_weight)
            )
            error = self.objective.log_error(finalist.response, finalist.log_rms_error)
            rows[name] = {
                "bare_objective": bare,
                "objective": value,
                "reduction_db": 20 * float(np.log10(bare / value)),
                "reduction_error_db": 20 / float(np.log(10)) * error,
                "dead_weight_reduction_db": 20 * float(np.log10(bare / dead)),
            }
        return dict(sorted(rows.items(), key=lambda row: row[1]["reduction_db"]))

    def front_table(self) -> pd.DataFrame:
        """Return a row per layout, the best first."""
        bare_value = float(self.problem.objective(self.problem.panel.bare))
        names = [f"{name}_reduction_db" for name in VARIANTS]
        evaluated, finalists = self.problem.evaluated, self.finalists.values()
        rows = []
        for number, layout in enumerate(self.layouts):
            reductions = self._reductions(number)
            name, worst = next(iter(reductions.items()))
            dead = min(row["dead_weight_reduction_db"] for row in reductions.values())
            faces, layer = self.alternatives_db(self.problem.mass(layout))
            rows.append(
                {
                    "confirmed": number,
                    "patches": len(layout),
                    "mass_kg": self.problem.mass(layout),
                    "objective_unit": self.objective.unit,
                    "excitation": name,
                    **worst,
                    **{
                        f"{test}_reduction_db": reductions.get(test, {}).get("reduction_db")
                        for test in EXCITATIONS
                    },
                    "search_reduction_db": 10 * np.log10(bare_value / evaluated[layout]),
                    "dead_weight_reduction_db": dead,
                    "face_sheets_reduction_db": faces,
                    "damping_layer_reduction_db": layer,
                    "loses_to_dead_weight": worst["reduction_db"] < dead,
                    "basis_error": max(final[number].basis_error for final in finalists),
                    **dict(zip(names, self.variants_db[number].tolist(), strict=True)),
                }
            )
        table = pd.DataFrame(rows).sort_values("reduction_db", ascending=False, kind="stable")
        best = table.iloc[0]
        margin = max(float(best["reduction_error_db"]), COMPUTED)
        table["is_equivalent"] = table["reduction_db"] >= best["reduction_db"] - margin
        by_mass = table.sort_values(["mass_kg", "patches"], kind="stable")["reduction_db"]
        table["is_on_front"] = by_mass > by_mass.cummax().shift(fill_value=0.0)
        table["largest_regret_db"] = (table[names].max() - table[names]).max(axis=1)
        table.insert(0, "layout", np.arange(1, len(table) + 1))
        return table

    def patch_table(self, front: pd.DataFrame) -> pd.DataFrame:
        """Return a row per patch of each layout."""
        options, places = self.problem.options, self.problem.places
        rows = []
        for name, number in zip(front["layout"], front["confirmed"], strict=True):
            layout = self.layouts[number]
            gammas = np.max([final[number].acceleration_g for final in self.finalists.values()], 0)
            for option, gamma in zip(layout, gammas.tolist(), strict=True):
                filling = self.fillings[options.filling[option]]
                place = options.place[option]
                (x, y), (across, up) = places.centre[place], places.size[place]
                rows.append(
                    {
                        "layout": name,
                        "centre_x_m": x,
                        "centre_y_m": y,
                        "size_x_m": across,
                        "size_y_m": up,
                        "patch": places.names[place] if places.names else "",
                        "damper": filling.name,
                        "fill_fraction": filling.fill_fraction,
                        "mass_kg": options.mass[option],
                        "acceleration_g": gamma,
                    }
                )
        return pd.DataFrame(rows)

    def point_table(self, front: pd.DataFrame, points: Sequence[str]) -> pd.DataFrame:
        """Return a row per layout, excitation and point."""
        frames, index = [], np.arange(len(points))
        for excitation, name, finalist in self._in_order(front):
            bare, rms, dead = (
                answer.acceleration_rms[index] / STANDARD_GRAVITY
                for answer in (finalist.bare, finalist.response, finalist.dead_weight)
            )
            columns = {
                "layout": name,
                "excitation": excitation,
                "point": points,
                "counts": np.isin(index, self.counted),
                "bare_rms_g": bare,
                "acceleration_rms_g": rms,
                "acceleration_rms_error_g": rms * finalist.log_rms_error[index],
                "dead_weight_rms_g": dead,
            }
            frames.append(pd.DataFrame(columns))
        return pd.concat(frames)

    def psd_table(self, front: pd.DataFrame, points: Sequence[str]) -> pd.DataFrame:
        """Return PSDs of each layout, and of the bare panel as layout 0."""
        answers = [(test, 0, rows[0].bare) for test, rows in self.finalists.items()]
        frames = []
        answers += [(test, name, final.response) for test, name, final in self._in_order(front)]
        for excitation, name, answer in answers:
            psd = answer.acceleration_psd / STANDARD_GRAVITY**2
            for index, point in enumerate(points):
                first = {"layout": name, "excitation": excitation, "point": point}
                lines = {"frequency_hz": answer.frequency, "acceleration_psd_g2_hz": psd[:, index]}
                frames.append(pd.DataFrame(first | lines))
        return pd.concat(frames)

    def _in_order(self, front: pd.DataFrame) -> Iterator[tuple[str, int, Finalist]]:
        """Yield excitation, number and finalist of each layout, the best first."""
        for name, number in zip(front["layout"], front["confirmed"], strict=True):
            for excitation, finalists in self.finalists.items():
                yield excitation, name, finalists[number]


def damper_rows(problem: Problem, fillings: Sequence[FilledDamper]) -> dict[str, float]:
    """Return what each damper, and its mass alone, reduces most on a single place [dB]."""
    panel, options = problem.panel, problem.options
    bare = float(problem.objective(panel.bare))
    empty = np.zeros((0, panel.frequency.size), np.complex64)
    inertia = np.outer(
        options.mass / panel.area[options.place], -((2 * np.pi * panel.frequency) ** 2)
    )
    rows = {}
    for name in dict.fromkeys(filling.name for filling in fillings):
        used = [index for index, filling in enumerate(fillings) if filling.name == name]
        usable = np.flatnonzero(np.isin(options.filling, used) & problem.feasible(()))
        if not usable.size:
            continue
        for start, stiffness in (("", options.stiffness), ("dead_weight_", inertia)):
            added = panel.mean_square(
                (), empty, options.place[usable], stiffness[usable].astype(np.complex64)
            )
            lowest = float(problem.objective(added).min())
            rows[f"{start}reduction_db of {name}"] = 10 * float(np.log10(bare / lowest))
    return rows


def search_table(
    problem: Problem,
    fillings: Sequence[FilledDamper],
    proof: Proof,
    sampling: Sampling,
    front: pd.DataFrame,
    area_error: float,
) -> pd.DataFrame:
    """Return what the search did and what it proved, a row per quantity."""
    best = front.iloc[0]
    margin = max(float(best["reduction_error_db"]), COMPUTED)
    values = np.array(list(problem.evaluated.values()))
    close = values <= proof.value * 10 ** (margin / 10)
    drift = float((front["search_reduction_db"] - front["reduction_db"]).abs().max())
    gap = proof.gap_db + 2 * drift  # of two layouts each may differ
    rows = {
        "budget_kg": problem.budget,
        "places": len(problem.places.lower),
        "options": problem.options.mass.size,
        "evaluated_layouts": values.size,
        "equivalent_layouts": int(np.count_nonzero(close)),
        "equivalent_within_db": margin,
        "gap_db": gap if 2 * drift <= LARGEST_DRIFT else np.nan,
        "drift_db": drift,
        "nodes": proof.nodes,
        "is_exhaustive": int(proof.is_exhaustive),
        "submodularity_checks": sampling.checks,
        "submodularity_violations": sampling.violations,
        "largest_violation": sampling.largest,
        "bound_factor": sampling.ratio,
        "bound_excess": sampling.excess,
        "area_error": area_error,
        **damper_rows(problem, fillings),
    }
    return pd.DataFrame({"quantity": list(rows), "value": list(rows.values())})
