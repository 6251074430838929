"""A study on a shaker without sound: what it may have, its rules, its page."""

import pytest
import yaml
from moving import HERE, run_stages

from pidpanel.check import checked_study
from pidpanel.cli.commands import pidpanel
from pidpanel.coupled.from_study import coupled_scenarios, depends_on
from pidpanel.optimise.from_study import counted_excitations
from pidpanel.report.from_study import write_study_page
from pidpanel.study import StudyError, load_study
from tests.commands import jobs, snakemake

SOUND = "sound: {spectrum: smc_s_016_2014_min_third.csv}\n"


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """The file of the study, the base of tests/base without its sound."""
    path = tmp_path_factory.mktemp("alone") / "alone.yaml"
    text = (HERE / "shaken.yaml").read_text()
    path.write_text(text.replace(SOUND, "").replace(", oaspl_db: [140, 143]", ""))
    return path


def test_a_study_of_base_motion_alone_is_allowed(alone):
    study = checked_study(alone)
    assert study.sound is None and study.oaspl_db is None
    assert [scenario.label for scenario in study.all_scenarios()] == [
        "bare", "PID-1_acrylic_r0.5", "PID-1_printed_r0.5",
    ]  # fmt: skip
    with pytest.raises(StudyError, match="sound: missing; this is a study of base motion alone"):
        _ = study.acoustics


def test_a_study_needs_sound_or_base_motion(alone, tmp_path):
    lines = alone.read_text().splitlines()
    start, end = lines.index("base:"), lines.index("response: {frequency_hz: [30, 300]}")
    path = tmp_path / "neither.yaml"
    path.write_text("\n".join(lines[:start] + lines[end:]))
    with pytest.raises(StudyError) as error:
        load_study(path)
    assert str(error.value).splitlines()[-1].endswith("sound: missing")


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("fill_fraction: 0.5}", "fill_fraction: 0.5, oaspl_db: 150}", "scenarios.half.oaspl_db"),
        ("300]}", "300], radiation: one_side}", "response.radiation"),
        ("300]}", "300], maps: [bare]}", "response.maps"),
        ("scenarios:", "severity: {duration_s: 60}\nscenarios:", "severity"),
    ],
)
def test_what_is_computed_under_sound_alone_is_refused_without_it(alone, tmp_path, old, new, key):
    path = tmp_path / "asks.yaml"
    path.write_text(alone.read_text().replace(old, new))
    with pytest.raises(StudyError) as error:
        load_study(path)
    (line,) = str(error.value).splitlines()
    assert f": {key} = " in line and line.endswith("only allowed with a section sound")


def test_layouts_are_searched_under_base_motion_but_not_under_a_sound_that_is_not_there(
    alone, tmp_path
):
    path = tmp_path / "asks.yaml"
    pad = "pad: {equivalent_damping_n_s_m3: 400, apparent_mass_kg_m2: 4}"
    text = alone.read_text().replace("dampers: {", f"dampers: {{{pad}, ")
    search = "optimise: {mass_kg: 1, patch_size_m: [0.2, 0.2], dampers: [pad]}"
    path.write_text(f"{text}{search}\n")
    study = load_study(path)
    assert counted_excitations(study) == ["base"]
    wanted = jobs(snakemake(tmp_path, path, "-n"))
    assert set(wanted) == {"panel", "base", "base_export", "optimise", "report"}
    for wanted in ("sound", "both"):
        path.write_text(f"{text}{search.replace('}', f', excitation: {wanted}}}')}\n")
        with pytest.raises(StudyError, match=f"excitation.*{wanted} needs a section sound"):
            load_study(path)


def test_panel_base_and_report_are_all_that_runs(alone, tmp_path):
    assert set(jobs(snakemake(tmp_path, alone, "-n"))) == {"panel", "base", "base_export", "report"}


@pytest.mark.slow
def test_the_page_answers_and_has_the_panel_on_its_shaker(alone, tmp_path):
    study = load_study(alone)
    run_stages(study, tmp_path)
    page = tmp_path / "report.html"
    write_study_page(study, alone, tmp_path, page, tmp_path / "report")
    text = page.read_text()
    assert "PID-1, acrylic, r = 0.5 lowers the largest acceleration of all points most, to" in text
    assert (
        "Cₑ is negative, so there is no steady" in text
        and "radiation into the air is not included" in text
    )
    for name in ("base_centre", "base_interface", "base_sine_0", "mode_shapes"):
        assert f'id="{name}"' in text
    assert "Sound" not in text.replace("Soundness", "")


BED = """
    cell: {shape: hexagon, across_flats_mm: 6.35, depth_mm: 25, count: 3}
    particles: {diameter_mm: 2, density_kg_m3: 1190, youngs_modulus_mpa: 50}
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("", "", None),
        ("base:", f"{SOUND}base:", "base = "),
        ("[bed, table]", "bed", "base.sine = "),
        ("  random:", "  x-random:", "base.random: missing; required for dampers with model"),
    ],
)
def test_coupled_runs_move_the_supports_of_a_study_without_sound(
    alone, tmp_path, old, new, message
):
    lines = alone.read_text().splitlines()
    lines[1] = f"dampers:\n  table: {{table: acrylic_2mm.csv}}\n  bed:{BED}"
    text = "\n".join(lines).replace("[acrylic, printed]", "[bed, table]")
    path = tmp_path / "coupled.yaml"
    if new == "  x-random:":
        lines = [
            line for line in text.splitlines() if not line.startswith(("  random", "  notching"))
        ]
        text, old, new = "\n".join(lines), "", ""
    path.write_text(text.replace(old, new) if old else text)
    if message is None:
        study = load_study(path)
        assert list(coupled_scenarios(study)) == ["PID-1_bed_r0.5"]
        assert depends_on(study, "PID-1_bed_r0.5")["base"]["random"]["overall_g"] == 10.0
        return
    with pytest.raises(StudyError, match=message):
        load_study(path)


def test_an_export_of_a_sweep_alone_is_refused_in_a_line(alone, tmp_path):
    # red: base.random not asked for
    values = yaml.safe_load(alone.read_text())
    values["base"] = {"sine": {"frequency_hz": [20, 200], "acceleration_g": 1}}
    (tmp_path / "sweep.yaml").write_text(yaml.safe_dump(values))
    arguments = ["export", str(tmp_path / "sweep.yaml"), "--directory", str(tmp_path)]
    with pytest.raises(StudyError, match=r"only sound and base\.random have files"):
        pidpanel.main(arguments, standalone_mode=False)
