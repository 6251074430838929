"""A small study with made-up responses: the report is told what came out and must say it."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from coupled_study import coupled_results, coupled_text
from made_up import responses, rows_of_patches, strains

from pidpanel.coupon import records
from pidpanel.coupon.from_study import cases_of, write_table
from pidpanel.coupon.records import CaseOutcome, Outcome, Shaken
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.navier import thin_plate_frequency
from pidpanel.panel.section import ThinSection
from pidpanel.provenance.digests import stamp
from pidpanel.report import style
from pidpanel.report.inputs import Inputs
from pidpanel.study import load_any_study, load_study
from tests.jobs import RESPONSE, call, make_panel, make_sound, within

PRINTED = Path(__file__).parents[2] / "workflow" / "data" / "paper" / "table_1.csv"
SIZE = (1.5, 1.0)

STUDY = """
title: A panel under test
assumptions: ["The spectrum is assumed."]
dampers: {law: {law: paper_corrected}}
panel:
  outline_m: [1.5, 1.0]
  section: {mass_per_area_kg_m2: 4.0, bending_stiffness_n_m: 3273.07}
  patches:
    A: {centre_m: [0.75, 0.50], size_m: [0.2, 0.2]}
    B: {centre_m: [0.20, 0.30], size_m: [0.2, 0.2]}
  points: {middle: [0.75, 0.50], corner: [0.20, 0.30]}
sound: {spectrum: smc_s_016_2014_min_third.csv, oaspl_db: 150}
response: {frequency_hz: [100, 400]}
scenarios:
  fill: {patch: A, fill_fraction: [0.1, 0.7, 0.9]}
  place: {patch: [A, B], fill_fraction: 0.5, title: "Place of the damper (Figure 6)"}
  level: {patch: A, fill_fraction: 0.5, oaspl_db: [140, 150]}
"""


@pytest.fixture(scope="session")
def study_text():
    """The study as YAML."""
    return STUDY


@pytest.fixture(scope="session")
def study(tmp_path_factory):
    path = tmp_path_factory.mktemp("study") / "trial.yaml"
    path.write_text(STUDY)
    return load_study(path)


@pytest.fixture(scope="session")
def foreign(study):
    """The study with the modes of another solver in place of its panel."""
    other = load_study(PRINTED.parents[2] / "studies" / "foreign_modes.yaml")
    return study.model_copy(update={"panel": other.panel})


@pytest.fixture(scope="session")
def printed():
    return pd.read_csv(PRINTED, comment="#")


@pytest.fixture(scope="session")
def modes():
    """The paper's panel by its closed form, up to the frequencies that Table 1 reaches."""
    m, n = (grid.ravel() for grid in np.meshgrid(range(1, 11), range(1, 9)))
    frequency = thin_plate_frequency(m, n, SIZE, ThinSection(3273.07, 4.0))
    order = np.argsort(frequency)
    return pd.DataFrame(
        {
            "mode": range(1, len(m) + 1),
            "m": m[order],
            "n": n[order],
            "frequency_hz": frequency[order],
            "navier_hz": frequency[order],
            "modal_mass_kg": 1.5,
        }
    )


@pytest.fixture(scope="session")
def basis(study, modes):
    x, y = (g.ravel() for g in np.meshgrid(np.linspace(0, 1.5, 16), np.linspace(0, 1.0, 11)))
    corner = (np.arange(10)[:, None] * 16 + np.arange(15)).ravel()
    m, n = modes["m"].to_numpy(), modes["n"].to_numpy()
    shapes = np.sin(m * np.pi * x[:, None] / 1.5) * np.sin(n * np.pi * y[:, None])
    count = len(m)
    return PanelBasis(
        natural_frequency=modes["frequency_hz"].to_numpy(),
        modal_mass=np.full(count, 1.5),
        is_residual=np.zeros(count, bool),
        shape_at_points=np.zeros((2, count)),
        patch_overlap=np.zeros((2, count, count)),
        # the shapes are zero at the edges, so that the vertices are a trapezoidal rule
        quadrature_position=np.stack([x, y], axis=1),
        quadrature_weight=np.full(len(x), 0.01),
        shape_at_quadrature=shapes,
        quadrature_wavenumber=np.inf,
        face_overlap=1.5 / 4 * np.eye(count),
        vertex_position=np.stack([x, y], axis=1),
        cells=np.stack([corner, corner + 1, corner + 17, corner + 16], axis=1),
        shape_at_vertices=shapes,
        curvature_at_vertices=np.zeros((len(x), 3, count)),
        shear_at_vertices=np.zeros((len(x), 2, count)),
        curvature_at_points=np.zeros((2, 3, count)),
        shear_at_points=np.zeros((2, 2, count)),
        reactions=np.zeros((2, 0, count)),
        layer_names=("top",),
        layer_strain=np.zeros((1, 3, 3)),
        layer_stress=np.zeros((1, 3, 3)),
        core_stress=np.zeros((2, 2)),
        point_position=np.array([[0.75, 0.5], [0.2, 0.3]]),
        cell_in_patch=np.array(
            [
                np.hypot(x[corner] + 0.05 - x0, y[corner] + 0.05 - y0) < 0.1
                for x0, y0 in ((0.75, 0.5), (0.2, 0.3))
            ]
        ),
        point_names=("middle", "corner"),
        patch_names=("A", "B"),
    )


@pytest.fixture(scope="session")
def bands():
    edge = 10 ** ((np.arange(19, 28) - 0.5) / 10)
    return pd.DataFrame(
        {
            "center_hz": 10 ** (np.arange(19, 27) / 10),
            "lower_hz": edge[:-1],
            "upper_hz": edge[1:],
            "band_spl_db": 130.0,
            "surface_pressure_psd_pa2_hz": 4000 / np.diff(edge),
        }
    )


@pytest.fixture(scope="session")
def section():
    """``panel/section.csv`` of the thin plate."""
    rows = [("bending", 1, 1, 3273.07, "N m"), ("mass_per_area", 0, 0, 4.0, "kg/m2")]
    rows += [("area", 0, 0, 1.5, "m2"), ("mass", 0, 0, 6.0, "kg")]
    return pd.DataFrame(rows, columns=["quantity", "row", "column", "value", "unit"])


@pytest.fixture(scope="session")
def inputs(study, modes, basis, section, bands, printed):
    summary, psd = responses(study, {("A_r0.1_150dB", "middle"): 3.0})
    return Inputs(
        study=study,
        stamp=stamp(study),
        summary=summary,
        layouts=rows_of_patches(summary),
        psd=psd,
        modes=modes,
        basis=basis,
        section=section,
        bands=bands,
        printed=printed,
        coupons={},
        stress=strains(study),
    )


@pytest.fixture(scope="session")
def coupled_study(study_text, tmp_path_factory):
    """The study with coupled runs."""
    path = tmp_path_factory.mktemp("coupled") / "coupled.yaml"
    path.write_text(coupled_text(study_text))
    return load_study(path)


@pytest.fixture(scope="session")
def coupled(inputs, coupled_study):
    """The inputs with coupled runs: C_e falls with frequency."""
    study = coupled_study
    summary, psd = responses(study, {("A_r0.5_150dB", "middle"): 6.0}, error_db=0.1)
    return replace(
        inputs,
        study=study,
        summary=summary,
        layouts=rows_of_patches(summary),
        psd=psd,
        stress=strains(study),
        coupled=coupled_results(study),
    )


@pytest.fixture
def respond(study):
    """Summary and PSDs as `responses` makes them."""
    return lambda scale, **options: responses(study, scale, **options)


@pytest.fixture
def respond_to():
    """Summary and PSDs of any study as `responses` makes them."""
    return responses


@pytest.fixture(autouse=True)
def look():
    with style.context():
        yield


@pytest.fixture
def cases():
    """Rows of ``coupon/cases.csv``: 2 fills × 2 frequencies × 3 levels, all ok."""
    rows = [
        {
            "case": f"r{fill:g}_f{frequency:g}Hz_a{level:g}g",
            "fill_fraction": fill,
            "frequency_hz": frequency,
            "acceleration_g": level,
            "particle_mass_per_area_kg_m2": 10 * fill,
            "dissipated_energy_j_m2": 0.2,
            "dissipated_energy_error_j_m2": 0.01,
            "equivalent_damping_n_s_m3": 500 * fill * frequency / 100,
            "equivalent_damping_error_n_s_m3": 20.0,
            "statistical_error_n_s_m3": 20.0,
            "states": 1,
            "state_damping_n_s_m3": "",
            "state_share": "",
            "apparent_mass_kg_m2": fill,
            "apparent_mass_error_kg_m2": 0.1,
            "loss_factor": 0.3,
            "loss_factor_error": 0.02,
            "bound_n_s_m3": 40 * fill * frequency,
            "share_of_bound": 0.3,
            "spheres_per_cell": 48.0,
            "youngs_modulus_mpa": 50.0,
            "closure": -0.01,
            "normal_share": 0.45,
            "cycles_run": 60,
            "cycles_used": 50,
            "target_met": True,
            "ended_by": "accuracy",
            "status": "ok",
            "message": "",
        }
        for fill in (0.3, 0.7)
        for frequency in (100.0, 400.0)
        for level in (3.0, 12.0, 50.0)
    ]
    return pd.DataFrame(rows)


# ------------------------------------------------------------------ pages of small studies

GOLDEN = Path(__file__).parents[1] / "coupon" / "liggghts" / "golden" / "shake"

COUPON = """
title: One cell
coupon:
  cell: {count: 1, depth_mm: 10}
  particles: {diameter_mm: 2.5}
  sweep: {fill_fraction: [0.5], frequency_hz: [200], acceleration_g: [10]}
  accuracy: {seeds: 1}
"""


@pytest.fixture(scope="session")
def table(tmp_path_factory, write_study, table_values):
    """Results of a study with measured damping, from mesh to maps; its file and its folder."""
    root = tmp_path_factory.mktemp("table")
    study, folder = write_study(root, "table", table_values()), root / "results" / "table"
    for stage in ("panel", "sound", "response"):
        (folder / stage).mkdir(parents=True)

    panel, sound, made = folder / "panel", folder / "sound", folder / "response"
    make_panel(study, panel)
    make_sound(study, sound, modes=panel / "modes.nc")
    upstream = {"modes": panel / "modes.nc", "modal_force": sound / "modal_force.nc"}
    upstream["plate"] = panel / "plate.nc"
    read = upstream | {"section": panel / "section.csv"}
    response = within(made, RESPONSE)
    call("response", study, read, response)
    read = upstream | {"left_out": response["left_out"], "psd": response["psd"]}
    call("maps", study, read, within(made, {"maps": "maps.nc", "folder": "maps"}))
    (folder / "severity").mkdir()
    names = ("oscillators", "peaks", "fatigue", "strength")
    severity = within(
        folder / "severity", {name: f"{name}.csv" for name in names} | {"maps": "maps.nc"}
    )
    read = {name: response[name] for name in ("psd", "summary", "stress", "stress_table")}
    read["maps"] = made / "maps.nc"
    call("severity", study, read, severity)
    read = {name: response[name] for name in ("psd", "summary")}
    call("margins", study, read, within(folder / "severity", {"margins": "margins.csv"}))
    (folder / "measurement").mkdir()
    measured = within(folder / "measurement", {n: f"{n}.csv" for n in ("measured", "differences")})
    call("measurement", study, {"response": response["psd"]}, measured)
    page = within(folder, {"page": "report.html", "figures": "report"})
    call("report", study, {}, page, params={"results": str(folder)})
    return study, folder


@pytest.fixture(scope="session")
def coupon(tmp_path_factory):
    """A study of one case and its run: the recorded one, its steps as this deck would count them."""
    folder = tmp_path_factory.mktemp("coupon")
    file = folder / "cell.yaml"
    file.write_text(COUPON)
    study = load_any_study(file)
    (case,) = cases_of(study.coupon)
    (run,), (home,) = case.runs, case.folders(folder / "runs")
    home.mkdir(parents=True)
    for name in ("last.dump", "start.data"):
        shutil.copy(GOLDEN / name, home / name.replace("last", "at_12"))
    head = [line for line in (GOLDEN / "cycles_1.txt").read_text().splitlines() if line[0] == "#"]
    rows = np.loadtxt(GOLDEN / "cycles_1.txt")
    text = [f"{number * run.steps_per_cycle} " + " ".join(f"{x:.8g}" for x in row[1:])
            for number, row in enumerate(rows, 1)]  # fmt: skip
    (home / "cycles_1.txt").write_text("\n".join([*head, *text]) + "\n")
    mass = 8 * 1190 * np.pi / 6 * 2.5e-3**3
    found = Shaken(len(rows), (len(rows),), 8, mass, "accuracy", None)
    outcome = Outcome("ok", "", found)
    records.write(case.outcome_file(folder / "runs"), CaseOutcome((outcome,)))
    write_table(study, "coupon", folder / "runs", folder / "cases.csv")
    page = within(folder, {"page": "report.html", "figures": "report"})
    call("coupon_report", file, {"cases": folder / "cases.csv"}, page)
    return file, folder, case
