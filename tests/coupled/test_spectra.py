"""Spectra of segments have the level, the energy and the phase of what was recorded."""

import numpy as np
import pytest

from pidpanel.coupled.spectra import (
    band_sums,
    pressure_segments,
    segment_spectra,
)

EDGE = np.array([[50.0, 100.0], [100.0, 200.0]])


def test_a_line_at_an_edge_counts_once():
    frequency = np.array([50.0, 75.0, 100.0, 150.0])
    assert band_sums(frequency, np.ones((4, 1)), EDGE).ravel().tolist() == [2.0, 2.0]


def test_bands_are_summed_along_any_axis():
    rng = np.random.default_rng(1)
    frequency = np.linspace(40, 210, 60)
    values = rng.standard_normal((3, 60, 2)) + 1j * rng.standard_normal((3, 60, 2))
    found = band_sums(frequency, values, EDGE, axis=1)
    wanted = [values[:, (frequency >= low) & (frequency < high)].sum(axis=1) for low, high in EDGE]
    assert found == pytest.approx(np.stack(wanted, axis=1), rel=1e-12)


def test_white_noise_has_its_level_in_every_segment_and_band():
    # 199 segments, half of them as good as independent, of 360 lines with a standard deviation of 1
    # each: 0.5 % with Hann's window
    rows = 3.0 * np.random.default_rng(5).standard_normal((100000, 1))
    interval = 1e-3
    lines, found = segment_spectra(rows, interval, 1000, (100.0, 460.0))
    assert found.shape == (199, 360, 1)
    assert lines == pytest.approx(np.arange(100.0, 460.0))
    psd = np.abs(found) ** 2
    assert psd.mean() == pytest.approx(9.0 * 2 * interval, rel=0.02)
    halves = psd[:, :180].mean(), psd[:, 180:].mean()
    assert halves == pytest.approx([9.0 * 2 * interval] * 2, rel=0.03)


def test_segments_overlap_by_half_and_cover_the_record():
    # a blow is seen by the two segments that contain it
    rows = np.zeros((1000, 1))
    rows[310] = 1.0
    _, found = segment_spectra(rows, 1e-3, 100, (10.0, 500.0))
    assert len(found) == 19
    power = (np.abs(found) ** 2).sum(axis=(1, 2))
    assert np.flatnonzero(power).tolist() == [5, 6]


def test_the_first_and_the_last_row_are_seen():
    # of two segments, of one that is the whole record, and of many
    for rows, segments in ((100, 1), (150, 2), (1000, 19)):
        for blow, segment in ((0, 0), (rows - 1, segments - 1)):
            record = np.zeros((rows, 1))
            record[blow] = 1.0
            _, found = segment_spectra(record, 1e-3, 100, (10.0, 500.0))
            assert len(found) == segments
            power = (np.abs(found) ** 2).sum(axis=(1, 2))
            assert np.flatnonzero(power).tolist() == [segment]


def test_a_tone_has_its_mean_square():
    interval, time = 1e-3, np.arange(4000) * 1e-3
    rows = (5.0 + 2.0 * np.cos(2 * np.pi * 123.37 * time + 0.4))[:, None]
    lines, found = segment_spectra(rows, interval, 800, (1.0, 500.0))
    squares = (np.abs(found) ** 2).sum(axis=1) * (lines[1] - lines[0])
    # over 800 rows the square of the tone under the window is its mean to 1e-3
    assert squares.ravel() == pytest.approx([2.0] * len(squares), rel=1e-3)


def test_a_force_comes_back_from_its_impulse_with_its_phase():
    # the lines beside the tone turn with their own frequency: 5 Hz × π/2 × 0.5 ms = 0.4 %
    interval, omega = 5e-4, 2 * np.pi * 450.0
    time = np.arange(2001) * interval
    pressure = 3.0 * np.cos(omega * time)
    impulse = 3.0 / omega * np.sin(omega * time) + 7.0
    found = pressure_segments(impulse[:, None], interval, 400, (400.0, 500.0))
    _, wanted = segment_spectra(pressure[:-1, None], interval, 400, (400.0, 500.0))
    size = np.abs(wanted).max()
    assert np.abs(found - wanted).max() < 6e-3 * size
