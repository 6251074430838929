"""What was computed, with what, and how to reproduce it."""

import shlex
from collections.abc import Iterable, Mapping
from pathlib import Path

import pandas as pd

from pidpanel.coupon.liggghts.trust import comes_with_pidpanel
from pidpanel.paths import SECTION, STUDIES
from pidpanel.report.atlas_section import atlas_text
from pidpanel.report.base_section import base_facts
from pidpanel.report.inputs import Inputs, PanelInputs
from pidpanel.report.panel_section import panel_text
from pidpanel.report.text import READINGS, counted, number, percent
from pidpanel.solve.mesh_error import decibels


def study_facts(inputs: Inputs) -> list[tuple[str, str]]:
    """Return the facts of a study with a panel, as (name, value)."""
    study = inputs.study
    low, high = study.frequency
    good = inputs.summary[inputs.summary["status"] == "ok"]
    rows = [
        *panel_facts(inputs),
        ("Sound", study.sound),
        (
            "Response",
            f"{low:g} to {high:g} Hz, {inputs.psd.sizes['frequency']} lines; {study.terms}",
        ),
        *damping_facts(inputs),
        (
            "Power balance",
            f"power input and loss agree within {_share(good['power_balance_error'].max())} of "
            "the power input in every scenario",
        ),
        (
            "Basis",
            f"at most {percent(good['basis_error'].max(), 2)} of a PSD is missing in any "
            "scenario, at the lines that were also solved on all elements",
        ),
        (
            "Mesh",
            f"{len(inputs.basis.cells)} elements; their shift of resonances changes a PSD by at "
            f"most {number(decibels(good['mesh_error'].max()), 2)} dB at any line, an rms "
            f"acceleration by at most {percent(good['mesh_error_rms'].max(), 2)}",
        ),
    ]
    if inputs.base is not None:
        rows += base_facts(inputs.base)
    return [*rows, *software_facts(inputs)]


def panel_facts(inputs: PanelInputs) -> list[tuple[str, str]]:
    """Return what the panel is."""
    return [("Panel", panel_text(inputs.study.panel, inputs.basis, inputs.section))]


def damping_facts(inputs: PanelInputs) -> list[tuple[str, str]]:
    """Return from where the damping is."""
    study = inputs.study
    if not study.has_dampers:
        return [("Damping", "none: the bare panel alone")]
    return [
        ("Damping", "; ".join(READINGS[reading] for reading in study.readings)),
        ("C_e(r, f, Γ) evaluated at", study.read_at),
        *([("Atlas of particle beds", atlas_text(inputs.atlas))] if inputs.atlas else []),
        *coupled_facts(inputs),
    ]


def software_facts(inputs: PanelInputs) -> list[tuple[str, str]]:
    """Return the cases of the coupons, and the versions."""
    rows = []
    for name, coupon in inputs.coupons.items():
        called = "Coupon" if name == SECTION else f"Coupon {name}"
        rows.append((called, cases_text(coupon.cases)))
    dem = bool(inputs.coupons) or inputs.study.is_coupled
    return [*rows, ("Software", software_text(inputs.stamp, dem=dem))]


def coupled_facts(inputs: PanelInputs) -> list[tuple[str, str]]:
    """Return how many coupled runs there are; nothing in a study without any."""
    if inputs.coupled is None:
        return []
    runs = inputs.coupled.summary.drop_duplicates("scenario")["runs"]
    how_many = f"{counted(int(runs.sum()), 'run')} of {counted(len(runs), 'scenario')}"
    return [("Panel and particles together", how_many)]


def _share(value: float) -> str:
    """Return a share, rounding errors as such.

    Examples
    --------
    >>> _share(3e-7), _share(2e-16)
    ('3.0·10⁻⁷', '10⁻⁹')
    """
    return number(value, 2) if value > 1e-9 else "10⁻⁹"


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
    ('In the folder that holds the folder results:', 'pidpanel run paper.yaml')
    >>> run_step(Path("/home/me/my $(study).yaml"), [Path("/home/me/mine.in.j2")])[1]
    "pidpanel run '/home/me/my $(study).yaml' --trust-deck"
    """
    file = study_file.resolve()
    named = file.name if file.parent == STUDIES else str(file)
    trust = "" if all(map(comes_with_pidpanel, decks)) else " --trust-deck"
    return (
        "In the folder that holds the folder results:",
        f"pidpanel run {shlex.quote(named)}{trust}",
    )


def files_step(study: str) -> tuple[str, str]:
    """Return where the numbers of the page of a study are."""
    return (
        f"Tables and fields of this report are in results/{study}; figures are in report/. The "
        "files carry the hash of the study and the versions of the software, without time stamps.",
        "",
    )
