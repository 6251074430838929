"""Limitations of the numbers: where the response, the damping and the coupon cannot be trusted.

Every function returns sentences, or none.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from pidpanel.coupled.from_study import estimated_cpu_seconds
from pidpanel.damping.surface_cases import COUNTED
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.resolution import ORDER, element_sizes
from pidpanel.paths import SECTION
from pidpanel.report.answer import StudyAnswer
from pidpanel.report.answer_section import worst_map
from pidpanel.report.inputs import BaseResults, CouponResults, Inputs, PanelInputs
from pidpanel.report.names import Scenario, Study, main_scenarios, names_of
from pidpanel.report.templates import lines
from pidpanel.report.text import capitalised, records
from pidpanel.response import trust
from pidpanel.solve.mesh_error import ALLOWED_DB, ALLOWED_RMS, decibels, point_shifts
from pidpanel.structure.any_structure import MOST_TANGENTIAL
from pidpanel.structure.from_study import studied

NO_VALUES = pd.Series(dtype=float)  # of a column that is not there
NAMED = 3  # scenarios that a warning names

BETWEEN_POINTS = 1.12  # ratio to the worst point, 1 dB, above which motion elsewhere is reported

# Doubts in ``response/summary.csv`` that a page explains, in this order.
DOUBTS = (
    trust.NOT_LINEAR, trust.EXTRAPOLATED, trust.KNOWN_TO, trust.COARSE_SWEEP,
    "several solutions", "motion not converged", "basis too small",
)  # fmt: skip


def study_warnings(inputs: Inputs, answer: StudyAnswer | None) -> list[str]:
    """Return the limitations of a study with a panel, those of the answer first."""
    study, summary, base = inputs.study, inputs.summary, inputs.base
    main = main_scenarios(study)
    others = [scenario for scenario in study.all_scenarios() if scenario not in main]
    good = summary[summary["status"] == "ok"]
    is_atlas = inputs.layouts["damper"].isin(list(inputs.atlas.models if inputs.atlas else ()))
    proposed = inputs.proposal
    reads = proposed is not None and proposed.layouts["acceleration_g"].notna().any()
    base_mesh = None
    if base is not None:
        names = {scenario.layout_label: scenario.name for scenario in study.all_scenarios()}
        base_mesh = mesh_under_base_motion(inputs, names, base)
    values = {
        "trust": trust,
        "study": study,
        "answer": answer,
        "main": list(_doubts(study, summary, main)),
        "others": list(_doubts(study, summary, others)),
        "elsewhere": answer and _elsewhere(inputs, answer),
        "has_masses": answer and all(math.isfinite(c.mass) for c in answer.candidates),
        "base_mesh": base_mesh,
        "panel_mesh": coarse_mesh(inputs, inputs.names, summary),
        "at_points": at_points(inputs, summary),
        "remarks": studied(study.panel).remarks,
        "has_dampers": proposed is not None or bool(answer and answer.candidates),
        "has_tones": bool(study.coupons)
        or inputs.layouts.loc[~is_atlas, "damping_read_at_g"].notna().any()
        or (reads and inputs.atlas is None),
        "has_atlas": is_atlas.any() or (reads and inputs.atlas is not None),
        "tangential": _tangential(inputs.basis),
        "power": good["power_balance_error"].max(),
        "coupons": doubted_coupons(inputs.coupons),
    }
    return lines("warnings.html", values)


def _tangential(basis: PanelBasis) -> dict[str, float]:
    """Return the patches of a structure that move more along the surface than across it."""
    shares = np.zeros(0) if basis.tangential_share is None else basis.tangential_share
    named = zip(basis.patch_names, shares.tolist(), strict=False)
    return {name: share for name, share in named if share > MOST_TANGENTIAL}


def _doubts(
    study: Study, summary: pd.DataFrame, scenarios: Sequence[Scenario]
) -> Iterator[dict[str, Any]]:
    """Yield the doubts about scenarios."""
    rows = summary[summary["scenario"].isin([scenario.label for scenario in scenarios])]
    bare = {scenario.label for scenario in study.all_scenarios() if scenario.is_bare}
    is_all = len(scenarios) == len(study.all_scenarios())
    count, scenario_names = rows["scenario"].nunique(), names_of(study)

    def names(doubted: pd.DataFrame) -> str:
        labels = sorted(dict.fromkeys(doubted["scenario"]), key=bare.__contains__)
        named = [scenario_names[label] for label in labels[:NAMED]]
        named += [f"{len(labels) - NAMED} more"] * (len(labels) > NAMED)
        text = "; ".join(named)
        if 1 < count == len(labels):
            text = "all scenarios" if is_all else f"all scenarios with {_dampers(scenarios)}"
        return capitalised(text)

    lost = rows[~rows["status"].isin(["ok", "held"])]
    for status, doubted in lost.groupby("status", sort=False):
        yield {"names": names(doubted), "status": status}
    for doubt in DOUBTS:
        doubted = rows[rows["doubts"].fillna("").str.contains(doubt, regex=False)]
        if doubted.empty:
            continue
        worst = doubted.iloc[int(doubted["extrapolated_share"].argmax())]
        relative = doubted["acceleration_rms_error_g"] / doubted["acceleration_rms_g"]
        labels = set(doubted["scenario"])
        known = doubted["doubts"].iloc[int(relative.fillna(0.0).argmax())]
        yield {
            "names": names(doubted),
            "status": "",
            "doubt": doubt,
            "displacement": doubted["displacement_rms_mm"].max(),
            "stretched": doubted.get("stretched_displacement_rms_mm", NO_VALUES).max(),
            "shift": doubted.get("frequency_shift_percent", NO_VALUES).max(),
            "share": worst["extrapolated_share"],
            "missing": worst["data_missing"],
            "known": "".join(word for word in known.split(trust.BETWEEN) if doubt in word),
            "cpu": doubt == trust.KNOWN_TO
            and estimated_cpu_seconds(study, [s for s in scenarios if s.label in labels]),
            "residual": doubted["motion_residual"].max(),
            "basis": doubted["basis_error"].max(),
        }
    between = rows[rows["between_share"] > trust.BETWEEN_SHARE]
    if len(between):
        largest = between["between_share"].max()
        about = {"status": "", "doubt": trust.MAY_CROSS, "between": largest}
        yield {"names": names(between), **about}


def _dampers(scenarios: Sequence[Scenario]) -> str:
    return ", ".join(dict.fromkeys(s.dampers for s in scenarios if not s.is_bare))


def _elsewhere(inputs: Inputs, answer: StudyAnswer) -> dict[str, float] | None:
    """Return where the bare panel moves more than at any response point."""
    worst = worst_map(inputs)
    if worst is None:
        return None
    label, rms = worst
    bare = answer.bare.responses[answer.worst].rms
    if label != answer.bare.scenario.label or rms.max() <= BETWEEN_POINTS * bare:
        return None
    x, y = inputs.basis.vertex_position[int(rms.argmax())].tolist()
    return {"x": x, "y": y, "rms": rms.max()}


def coarse_mesh(
    inputs: PanelInputs, names: Mapping[str, str], summary: pd.DataFrame
) -> dict[str, Any] | None:
    """Return how much shorter the elements of a mesh must be; None if they are short enough.

    Parameters
    ----------
    inputs
        Inputs of the page.
    names
        Names of the scenarios by label.
    summary
        ``response/summary.csv`` or ``base/summary.csv``.
    """
    good = summary[summary["status"] == "ok"]
    rms = good["mesh_error_rms"].max()
    if not (good["mesh_error"].max() > trust.MESH_ERROR or rms > trust.MESH_RMS):
        return None
    largest = records(good.sort_values("mesh_error"))[-1]
    psd_db = decibels(largest["mesh_error"])
    excess = max(psd_db / ALLOWED_DB, rms / ALLOWED_RMS)
    edge = element_sizes(inputs.basis.vertex_position, inputs.basis.cells).max()
    highest = inputs.study.response.frequency_hz[1]
    panel = inputs.study.panel
    mesh = getattr(panel, "mesh", None)  # a structure has none of its own
    cause = studied(panel).cause_of_shift(float(edge), highest)
    has_feet = any(point.radius_m for point in panel.support_input.points.values())
    is_unsized = mesh is not None and mesh.kind == "triangles" and panel.corner_size is None
    if cause == "waves" and has_feet and is_unsized and panel.section.kind != "thin":
        cause = "unsized feet"
    return {
        "cause": cause,
        "is_file": mesh is not None and mesh.kind == "file",
        "name": names[largest["scenario"]],
        "psd_db": psd_db,
        "rms": rms,
        "shorter": math.ceil(10 * excess ** (1 / ORDER if cause == "waves" else 1)) / 10,
    }


def mesh_under_base_motion(
    inputs: PanelInputs, names: Mapping[str, str], base: BaseResults
) -> dict[str, Any] | None:
    """Return `coarse_mesh` of random motion, or of a sine sweep alone, which has no rms values."""
    if base.summary is not None:
        return coarse_mesh(inputs, names, base.summary)
    if base.peaks is None:
        return None
    return coarse_mesh(inputs, names, base.peaks.assign(status="ok", mesh_error_rms=0.0))


def at_points(inputs: PanelInputs, summary: pd.DataFrame) -> dict[str, Any]:
    """Return names of points that depend on the mesh, and changes with elements of half the size.

    Parameters
    ----------
    inputs, summary
        Same as in `coarse_mesh`.
    """
    basis = inputs.basis
    highest = inputs.study.response.frequency_hz[1]
    in_range = ~basis.is_residual & (basis.natural_frequency < highest)
    omega = 2 * np.pi * basis.natural_frequency[in_range]
    reactions = basis.reactions[:, :, in_range] / np.sqrt(basis.modal_mass[in_range])
    return {
        "names": inputs.study.panel.single_points,
        "shift": point_shifts(reactions, omega).max(initial=0.0),
        "rms": summary["point_error_rms"].max(),
    }


def coupon_warnings(cases: pd.DataFrame) -> list[str]:
    """Return the cases that are excluded, not steady or less accurate than requested."""
    return lines("coupon_warnings.html", {"cases": _doubted_cases(cases)})


def doubted_coupons(coupons: Mapping[str, CouponResults]) -> list[dict[str, Any]]:
    """Return the cases of `coupon_warnings` of each coupon, by its damper."""
    return [
        _doubted_cases(coupon.cases, "" if name == SECTION else f" of {name}")
        for name, coupon in coupons.items()
    ]


def _doubted_cases(cases: pd.DataFrame, suffix: str = "") -> dict[str, Any]:
    lost = cases[cases["status"] != "ok"].groupby("status", sort=True)["case"]
    good = cases[cases["status"] == "ok"]
    value, error = good["equivalent_damping_n_s_m3"], good["equivalent_damping_error_n_s_m3"]
    missed = ~good["target_met"].astype(bool)
    excessive = good[good["share_of_bound"] > 1]
    return {
        "count": len(cases),
        "suffix": suffix,
        "counted": COUNTED,
        "lost": [(status, list(names)) for status, names in lost],
        "missed": int(missed.sum()),
        "error": (error / value).abs()[missed].max(),
        "excessive": excessive["case"].tolist(),
        "excess": excessive["share_of_bound"].max(),
        "uncertain": good.loc[value <= error, "case"].tolist(),
    }
