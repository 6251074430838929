"""Inputs, versions and commands to reproduce the results."""

import shlex
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pidpanel.coupon.liggghts.deck import comes_with_pidpanel
from pidpanel.panel.basis import PanelBasis
from pidpanel.paths import STUDIES
from pidpanel.report.inputs import BaseResults, Inputs, PanelInputs
from pidpanel.report.names import Study, damper_titles
from pidpanel.report.templates import pairs
from pidpanel.report.text import counted
from pidpanel.solve.mesh_error import decibels


def study_facts(inputs: PanelInputs) -> list[tuple[str, str]]:
    """Return the facts of a study with a panel, as (name, value)."""
    study, base = inputs.study, inputs.base
    values: dict[str, Any] = {
        "study": study,
        "models": damper_titles(study),
        "panel": _panel(study, inputs.basis, inputs.section),
        "words": dict(pairs("words.html", {"study": study})),
        "base": None if base is None else _base(base),
        "response": None,
        "atlas": inputs.atlas.text if inputs.atlas else "",
        "runs": [],
        "proposed": [] if (found := inputs.proposal) is None else found.layouts["damper"].unique(),
        "coupons": [(name, cases_text(coupon.cases)) for name, coupon in inputs.coupons.items()],
        "software": software_text(inputs.stamp, dem=bool(inputs.coupons) or study.is_coupled),
    }
    if inputs.coupled is not None:
        runs = inputs.coupled.summary.drop_duplicates("scenario")["runs"]
        values["runs"] = runs.astype(int).tolist()
    if isinstance(inputs, Inputs):
        largest = inputs.summary[inputs.summary["status"] == "ok"].max(numeric_only=True)
        values["response"] = {
            "lines": inputs.psd.sizes["frequency"],
            "power": largest["power_balance_error"],
            "basis_error": largest["basis_error"],
            "mesh_db": decibels(largest["mesh_error"]),
            "mesh_error_rms": largest["mesh_error_rms"],
        }
    return pairs("facts.html", values)


def _panel(study: Study, basis: PanelBasis, section: pd.DataFrame) -> dict[str, Any]:
    """Return size, mass and stiffness of a panel, and its modes."""
    length, width = np.ptp(basis.vertex_position, axis=0)
    value = section.set_index(["quantity", "row", "column"])["value"]
    axes = {"thin": (1,), "unknown": ()}.get(study.panel.section.kind, (1, 2))
    modes = ~basis.is_residual
    return {
        "length": length,
        "width": width,
        "area": None if study.panel.size is not None else value["area", 0, 0],
        "mass": value["mass_per_area", 0, 0],
        "stiffness": [value["bending", i, i] for i in axes],
        "shear": [value["shear", i, i] for i in axes if len(axes) > 1],
        "modes": modes.sum(),
        "rigid": np.sum(basis.natural_frequency[modes] == 0),
        "residuals": basis.is_residual.sum(),
        "elements": len(basis.cells),
    }


def _base(base: BaseResults) -> dict[str, Any]:
    """Return the motions, and how good mesh and basis are under them."""
    rows = base.peaks if base.summary is None else base.summary
    curves = base.sine if base.psd is None else base.psd
    if rows is None or curves is None:
        raise ValueError("base motion without a response")
    return {
        "random": [] if base.psd is None else base.psd["frequency"].to_numpy().tolist(),
        "random_g": None if base.summary is None else base.summary["input_rms_g"].max(),
        "sine": [] if base.sine is None else base.sine["frequency"].to_numpy().tolist(),
        "sine_g": None if base.sine is None else base.sine.attrs["acceleration_g"],
        "mesh_db": decibels(rows["mesh_error"].max()),
        "basis_error": float(curves.attrs["basis_error"]),
    }


def cases_text(cases: pd.DataFrame) -> str:
    """Return how many cases of a coupon there are, and how many of them are ok."""
    return f"{counted(len(cases), 'case')}, {int((cases['status'] == 'ok').sum())} of them ok"


def software_text(stamp: Mapping[str, str], *, dem: bool) -> str:
    """Return the versions and the study behind the results."""
    solver = f", LIGGGHTS {stamp['liggghts_version']}" if dem else ""
    return (
        f"pidpanel {stamp['pidpanel_version']}{solver}; study {stamp['study']}, "
        f"hash {stamp['study_hash']}"
    )


def run_step(study_file: Path, decks: Iterable[Path] = ()) -> tuple[str, str]:
    """Return the command that runs a study with some decks of coupons again.

    Examples
    --------
    >>> run_step(STUDIES / "paper.yaml")
    ('In the folder that contains results/:', 'pidpanel run paper.yaml')
    >>> run_step(Path("/home/me/my $(study).yaml"), [Path("/home/me/mine.in.j2")])[1]
    "pidpanel run '/home/me/my $(study).yaml' --trust-deck"
    """
    file = study_file.resolve()
    named = file.name if file.parent == STUDIES else str(file)
    trust = "" if all(map(comes_with_pidpanel, decks)) else " --trust-deck"
    return "In the folder that contains results/:", f"pidpanel run {shlex.quote(named)}{trust}"


def files_step(study: str) -> tuple[str, str]:
    """Return where the numbers of the page of a study are."""
    return (
        f"Tables and fields of this report are in results/{study}; figures are in report/. The "
        "files carry the hash of the study and the versions of the software, without time stamps.",
        "",
    )
