"""Long stages say how far they have come; a run says it for them."""

import itertools
import logging
import os
from types import SimpleNamespace

import numpy as np
import pytest
from snakemake_interface_logger_plugins.common import LogEvent

import snakemake_logger_plugin_pidpanel as plugin
from pidpanel.geometry.plane_waves import PanelQuadrature
from pidpanel.progress import CORES, map_in_forks, time_left, with_progress
from pidpanel.sound.field import tabulate_diffuse
from pidpanel.sound.radiation import tabulate_added_mass


def test_the_time_left_is_that_of_the_rest_at_the_pace_so_far():
    # red: elapsed * total / done
    assert time_left(30.0, 3, 12).total_seconds() == 90


def test_a_stage_says_how_many_are_done_where_it_takes_long(capsys, monkeypatch):
    # red: a line for each item; `print` to stdout
    assert list(with_progress("abc", "cases")) == ["a", "b", "c"]
    assert capsys.readouterr().err == ""
    monkeypatch.setattr("pidpanel.progress.SECONDS_BETWEEN_LINES", 0.0)
    assert list(with_progress("abc", "cases")) == ["a", "b", "c"]
    said = capsys.readouterr()
    assert said.out == "" and said.err.splitlines()[1].startswith("2 of 3 cases, 0:00:00 left")


def test_pieces_come_in_their_order_from_forks_of_this_process(monkeypatch):
    # red: the forks see two cores too; as_completed in place of map; all pieces in this process
    monkeypatch.setenv(CORES, "2")
    factor = np.full(3, 7)  # not pickled, but inherited

    def piece(number):
        return number * factor[0], os.getpid(), os.environ[CORES]

    values, processes, cores = zip(*map_in_forks(piece, range(5)), strict=True)
    assert values == (0, 7, 14, 21, 28)
    assert os.getpid() not in processes and len(set(processes)) <= 2
    assert set(cores) == {"1"}


def test_a_single_piece_or_a_single_core_needs_no_fork(monkeypatch):
    # red: forks for all
    monkeypatch.setenv(CORES, "2")
    assert list(map_in_forks(lambda _: os.getpid(), [0])) == [os.getpid()]
    monkeypatch.delenv(CORES)
    assert list(map_in_forks(lambda _: os.getpid(), [0, 1])) == 2 * [os.getpid()]


def test_the_error_of_a_piece_is_that_of_the_whole(monkeypatch):
    # red: errors of forks lost
    monkeypatch.setenv(CORES, "2")
    with pytest.raises(ZeroDivisionError):
        list(map_in_forks(lambda number: 1 / number, [1, 0]))


def test_only_a_line_that_tells_the_time_left_is_taken_from_a_log(tmp_path):
    # red: any last line; control characters kept
    log = tmp_path / "a.log"
    assert plugin.said_last(log) == ""
    log.write_text("warning\n2 of 3 cases, 0:01:00 left\n\n")
    assert plugin.said_last(log) == "2 of 3 cases, 0:01:00 left"
    log.write_text("2 of 3 cases, \x1b[1m0:01:00 left")
    assert "\x1b" not in plugin.said_last(log)
    log.write_text("2 of 3 cases, 0:01:00 left\nNotSteady\n")
    assert plugin.said_last(log) == ""


def record(event, **values):
    one = logging.LogRecord("snakemake", logging.INFO, "", 0, "said", (), None)
    vars(one).update(event=event, **values)
    return one


def test_a_run_tells_of_its_long_jobs_without_control_characters(tmp_path, monkeypatch, capsys):
    # red: JOB_FINISHED that keeps the job; `_look` that is never started
    monkeypatch.setattr(plugin, "SECONDS_BETWEEN_LOOKS", 0.01)
    monkeypatch.setattr(plugin, "SECONDS_BETWEEN_LINES", 0.0)
    log = tmp_path / "a.log"
    log.write_text("2 of 3 cases, 0:01:00 left\n")
    settings = SimpleNamespace(
        stdout=True, nocolor=False, verbose=False, dryrun=False, printshellcmds=False
    )
    handler = plugin.LogHandler(settings, None)
    try:
        handler.emit(record(LogEvent.RUN_INFO, stats={"total": 4}))
        info = {"jobid": 7, "rule_name": "shake", "log": [str(log)]}
        handler.emit(record(LogEvent.JOB_INFO, **info))
        said = ""
        while "shake: 2 of 3 cases, 0:01:00 left" not in said:
            said += capsys.readouterr().out
        handler.emit(record(LogEvent.JOB_FINISHED, job_id=7))
        assert handler.jobs == {}
    finally:
        handler.close()
    assert "0 of 4 jobs; shake: 2 of 3" in said and "\x1b" not in said


def test_the_sound_and_the_maps_say_how_far_they_have_come(capsys, monkeypatch):
    # red: `with_progress` left out of tabulate_diffuse or tabulate_added_mass
    monkeypatch.setattr("pidpanel.progress.SECONDS_BETWEEN_LINES", 0)
    clock = itertools.count(0, 30)
    monkeypatch.setattr("pidpanel.progress.time.monotonic", lambda: next(clock))
    axis, weight = np.polynomial.legendre.leggauss(12)
    x, y = (one.ravel() for one in np.meshgrid(axis, axis))
    face = PanelQuadrature(
        np.column_stack([x, y]), np.outer(weight, weight).ravel(), np.cos(x)[:, None]
    )
    for tabulate, what in (
        (tabulate_diffuse, "wavenumbers of the sound"),
        (tabulate_added_mass, "parts of the air's wavenumbers"),
    ):
        tabulate(1.0, face)
        lines = capsys.readouterr().err.splitlines()
        assert lines and all(what in line and line.endswith(" left") for line in lines)
