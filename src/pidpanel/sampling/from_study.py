"""The rounds of a study: the only module of the stage that reads it."""

from __future__ import annotations

from pathlib import Path

from pidpanel.coupon.from_study import cases_of
from pidpanel.coupon.round import Round
from pidpanel.damping.from_study import read_cases, surface_of
from pidpanel.response.from_study import PanelFiles, read_response_panel, scenarios_of
from pidpanel.sampling.rounds import next_tones, swept_round
from pidpanel.study import Study, StudyError


def write_round(
    study: Study, files: PanelFiles, last_round: Path | None, cases: Path | None, output: Path
) -> None:
    """Write the round of a study's tones that follows another.

    Parameters
    ----------
    study
        With ``damping.tones``.
    last_round, cases
        The round before and the table of its cases; None for round 0.
    output
        ``design/round<n>.json``.

    Raises
    ------
    StudyError
        For a study without tones.
    """
    tones, coupon = study.damping.tones, study.coupon
    if tones is None or coupon is None:
        raise StudyError(f"{study.name}: damping.tones: missing")
    if last_round is None or cases is None:
        swept_round(cases_of(coupon)).write(output)
        return
    surface = surface_of(coupon, read_cases(cases))
    if not study.response.damper_mass:
        surface = surface.without_mass()
    panel = read_response_panel(study, files, study.response.radiation)
    error, fastest = coupon.accuracy.relative_error, coupon.sweep.max_velocity_m_s
    scenarios = scenarios_of(study)
    next_tones(Round.read(last_round), tones, error, fastest, panel, scenarios, surface).write(
        output
    )
