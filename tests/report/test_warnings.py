"""Limitations are stated where the numbers have them, and nowhere else."""

import dataclasses

import numpy as np
import pytest

from pidpanel.panel.from_study import StudiedPanel
from pidpanel.report import warnings
from pidpanel.report.answer import answer_of
from pidpanel.report.inputs import CouponResults
from pidpanel.response.from_study import scenarios_of
from pidpanel.response.trust import judged
from pidpanel.study import Study
from pidpanel.study.coupon import Coupon

POINTS = ["middle", "corner"]


@pytest.fixture
def said(inputs, study):
    """The warnings of a summary with the doubts that its numbers raise."""

    def of(summary, **changes):
        error = study.damping.coupled.relative_error
        doubted = judged(scenarios_of(study), summary, error)
        told = dataclasses.replace(inputs, summary=doubted, **changes)
        return warnings.study_warnings(told, answer_of(told.study, doubted))

    return of


def test_damping_outside_the_simulated_range_is_named_with_what_is_missing(said, study, respond):
    lowered = {(s.label, p): 1.0 for s in study.all_scenarios() if s.patch for p in POINTS}
    summary, psd = respond(lowered, read_at=312.0, inside=0.75)
    (outside,) = (text for text in said(summary, psd=psd) if "extrapolated" in text)
    count = len({s.label for s in study.all_scenarios() if s.patch})
    assert outside.startswith("A, r = 0.1, 150 dB; ")
    assert f"; {count - 3} more: damping partly extrapolated" in outside
    assert "up to 25 % of the change in mean square; extend dem to 61 g" in outside


def test_beds_that_may_ride_or_cross_are_simulated_on_demand(said, respond):
    summary, _ = respond({})
    assert not any("cross their gap" in text for text in said(summary))
    summary.loc[summary["scenario"] == "B_r0.5_150dB", "between_share"] = 0.31
    (text,) = (t for t in said(summary) if "cross their" in t)
    assert "B, r = 0.5, 150 dB: simulate these beds" in text and "p to 31 %" in text
    assert "model: coupled" in text


def test_motion_beyond_a_tenth_of_the_thickness_is_told(said, respond):
    summary, _ = respond({})
    assert not any("tenth" in text for text in said(summary))
    first = summary.index[0]
    summary.loc[first, "beyond_linear_plate"] = True
    summary.loc[first, "displacement_rms_mm"] = 25.5
    (text,) = (text for text in said(summary) if "tenth" in text)
    assert text.startswith("Bare panel, 150 dB: the rms displacement, up to 26 mm, is more than a")
    summary.loc[summary["scenario"] == summary["scenario"][first], "beyond_linear_plate"] = True
    assert sum("tenth" in text for text in said(summary)) == 1


def test_a_motion_that_is_not_converged_and_a_basis_that_is_not_right_are_told(said, respond):
    summary, _ = respond({})
    summary["basis_error"] = 1e-4
    assert not any("converged" in text or "all elements" in text for text in said(summary))
    of = summary["scenario"] == "B_r0.5_150dB"
    summary.loc[of, ["motion_residual", "basis_error"]] = 0.02, 0.011
    lines = said(summary)
    assert any(
        "B, r = 0.5, 150 dB: the acceleration for Cₑ is not" in t and "2.0 %" in t for t in lines
    )
    assert any("B, r = 0.5, 150 dB: the basis is too small" in t and "1.1 %" in t for t in lines)


def test_a_mesh_that_is_too_coarse_says_how_much_shorter_its_elements_must_be(said, respond):
    summary, _ = respond({})
    last = summary.index[summary["status"] == "ok"][-1]
    for column, value in (("mesh_error", 10 ** (16 * 0.65 / 10) - 1), ("mesh_error_rms", 0.405)):
        worse = summary.assign(**{column: summary[column].where(summary.index != last, value)})
        (mesh,) = (text for text in said(worse) if "mesh is too coarse" in text)
        # 16 and 81 times what is allowed, which falls with the fourth power
        factor = "2.0" if column == "mesh_error" else "3.0"
        assert mesh.endswith(f"Use element edges {factor} times shorter.")


def test_elements_of_a_shell_are_shorter_in_proportion_before_what_is_always_true(
    said, respond, monkeypatch
):
    monkeypatch.setattr(StudiedPanel, "cause_of_shift", lambda *_: "layers")
    monkeypatch.setattr(Study, "massless_dampers", {"bed": "dampers.bed.apparent_mass"})
    texts = said(respond({})[0].assign(mesh_error_rms=0.0151))
    (mesh,) = (text for text in texts if "mesh is too coarse" in text)
    assert mesh.endswith("they must be 3.1 times shorter (structure.shell.size_m).")
    (massless,) = (text for text in texts if "no mass in the computation" in text)
    assert texts.index(mesh) < texts.index(massless)


def test_single_points_have_the_largest_shift_of_a_mode_of_the_range(inputs, respond):
    summary, _ = respond({})
    basis, highest = inputs.basis, inputs.study.response.frequency_hz[1]
    root = 2 * np.pi * basis.natural_frequency * np.sqrt(basis.modal_mass)  # of the elastic energy
    share = np.where(basis.natural_frequency < highest, 1e-4, 0.5)
    share[:2] = 0.03, 0.5
    reactions = np.array([np.sqrt(share) * root, 0 * root])[:, None]
    is_residual = np.arange(len(root)) == 1
    held = dataclasses.replace(basis, reactions=reactions, is_residual=is_residual)
    found = warnings.at_points(dataclasses.replace(inputs, basis=held), summary)
    assert found["shift"] == pytest.approx(0.03) and found["rms"] == 0


def test_those_of_a_point_on_a_support_are_none(said, respond):
    summary, _ = respond({})
    summary.loc[(summary["point"] == "corner") & (summary["status"] == "ok"), "status"] = "held"
    assert not any("no steady response" in text for text in said(summary))


def test_power_that_is_lost_from_the_balance_is_told(said, respond):
    summary, _ = respond({})
    summary.loc[0, "power_balance_error"] = 0.02
    assert any("0.020 of the power input" in text for text in said(summary))


@pytest.mark.parametrize(
    ("column", "value", "words"),
    [
        (
            "status",
            "NotSteady",
            "did not reach steady state; included with enlarged errors: r0.3_f400Hz_a12g.",
        ),
        ("status", "ParticlesLost", "excluded (ParticlesLost): r0.3_f400Hz_a12g."),
        ("target_met", False, "before reaching the requested accuracy"),
        ("share_of_bound", 1.2, "inelastic bed (up to 1.20 times the bound): r0.3_f400Hz_a12g."),
        ("equivalent_damping_n_s_m3", 5.0, "no larger than its own standard error: r0.3"),
    ],
)
def test_coupon_cases_that_count_less_are_told(cases, column, value, words):
    assert warnings.coupon_warnings(cases) == []
    cases.loc[4, column] = value
    (said,) = warnings.coupon_warnings(cases)
    assert words in said
    assert said.startswith("1 of 12 coupon cases ")


def test_the_accuracy_of_cases_stopped_at_max_cycles_is_the_largest_of_them(cases):
    cases.loc[[4, 5], "target_met"] = False
    cases.loc[5, "equivalent_damping_error_n_s_m3"] = 300.0  # of 600
    cases.loc[0, "equivalent_damping_error_n_s_m3"] = 120.0  # of 150, and its target met
    (said,) = warnings.coupon_warnings(cases)
    assert said.startswith("2 of 12 coupon cases stopped at max_cycles")
    assert said.endswith("their relative standard errors reach 50 %.")


def test_damping_from_single_tones_comes_with_the_warning_that_it_is_overstated(
    said, respond, monkeypatch
):
    summary, _ = respond({}, read_at=312.0)
    layouts = summary[["scenario", "damping_read_at_g", "outside_run_points_share"]]
    layouts = layouts.assign(damper="law")
    overstated = "Broadband motion is damped less, by 30 % of the effect of the damping on average."
    assert overstated in " ".join(said(summary, layouts=layouts))
    assert overstated not in " ".join(said(respond({})[0]))
    monkeypatch.setattr(Study, "coupons", {"beads": Coupon.model_validate({})})
    assert overstated in " ".join(said(summary))


def test_particles_without_mass_are_named_with_the_key_that_gives_them_theirs(
    said, respond, monkeypatch
):
    monkeypatch.setattr(Study, "massless_dampers", {"bed": "dampers.bed.apparent_mass"})
    (text,) = (text for text in said(respond({})[0]) if "no mass" in text)
    assert text.startswith("The particles of bed have no mass in the computation")
    assert "dampers.bed.apparent_mass includes their mass" in text


def test_the_warnings_of_every_stage_are_on_the_page(inputs, cases, said):
    cases.loc[2, "status"] = "NotSteady"
    lines = said(
        inputs.summary,
        coupons={"coupon": CouponResults(cases)},
    )
    for words in ("Radiation damping is not included", "steady state"):
        assert sum(words in text for text in lines) == 1, words
