"""Rows of a case: damage, peaks and indices with their errors."""

import math

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from pidpanel.severity.fatigue import FatigueLine
from pidpanel.severity.kurtosis import transformed
from pidpanel.severity.strength import LayerStrength
from pidpanel.severity.tables import (
    COLUMNS,
    CORE,
    STRESSES,
    Bursts,
    fatigue_rows,
    index_maps,
    peak_rows,
    strength_rows,
)
from pidpanel.solve.stress import CORE_STRESSES
from tests.severity.motions import ERROR, FREQUENCY, WHERE, motion


def table(name, rows):
    return pd.DataFrame(list(rows), columns=list(COLUMNS[name]))


def stress_of(level, layers=("top", "bottom")):
    """PSDs of stresses [Pa²/Hz], each layer and stress with its own level; P1 does not move."""
    shape = (FREQUENCY.size, 2, len(layers))
    scale = np.array([0.0, 1.0])[:, None] * np.arange(1.0, len(layers) + 1)
    psd = {
        f"{name}_psd": (("frequency", "point", "layer"), np.broadcast_to(k * level * scale, shape))
        for k, name in enumerate(STRESSES, 1)
    }
    return xr.Dataset(psd, {"frequency": FREQUENCY, "point": ["P0", "P1"], "layer": list(layers)})


@pytest.mark.parametrize("exponent", [4.0, 9.0])
def test_the_error_of_damage_is_what_a_stress_larger_by_its_error_does(exponent):
    # damage grows with the power b of the stress
    places = pd.MultiIndex.from_product([["P0", "P1"], ["top", "bottom"], STRESSES])
    error = pd.Series(0.01 * np.arange(1.0, len(places) + 1), places)
    line = FatigueLine(100e6, 1e6, exponent)

    def rows(level, seconds=60.0, bursts=Bursts.none(2)):  # noqa: B008
        stress = stress_of(level)
        return table(
            "fatigue", fatigue_rows(WHERE, stress, FREQUENCY, error, line, seconds, bursts)
        )

    stated = rows(1e8)
    assert set(stated["point"]) == {"P1"} and len(stated) == 8  # what does not move has no row
    for row in stated.itertuples():
        relative = error[row.point, row.layer, row.quantity]
        larger = rows(1e8 * (1 + relative) ** 2)
        same = larger[(larger["layer"] == row.layer) & (larger["quantity"] == row.quantity)]
        for count in ("damage_dirlik", "damage_narrow_band"):
            ratio = same[count].item() / getattr(row, count)
            assert row.damage_log_error == pytest.approx(math.log(ratio), rel=1e-9)
    twice = rows(1e8, 120.0)
    for count in ("damage_dirlik", "damage_narrow_band"):
        np.testing.assert_allclose(twice[count], 2 * stated[count], rtol=1e-12)
    # √(level of the stress and its layer over 480 Hz) [MPa]
    levels = [k * n for k in range(1, 5) for n in (1, 2)]
    np.testing.assert_allclose(stated["stress_rms_mpa"], np.sqrt(0.048 * np.array(levels)))


def test_a_peak_is_that_of_the_rms_with_its_error():
    # a flat PSD from a to b: ν₀² = (b³ − a³) / 3(b − a); Davenport's factor of ν₀T crossings
    rows = pd.DataFrame(peak_rows(motion(1e-4, points=("P", "Q")), 60.0)).iloc[0]
    rate = math.sqrt((500.0**3 - 20.0**3) / 3 / 480.0)
    root = math.sqrt(2 * math.log(60.0 * rate))
    assert rows["acceleration_rms_g"] == pytest.approx(math.sqrt(0.048))
    assert rows["three_sigma_g"] == pytest.approx(3 * math.sqrt(0.048))
    assert rows["zero_crossings_hz"] == pytest.approx(rate)
    assert rows["peak_g"] == pytest.approx((root + 0.5772156649 / root) * math.sqrt(0.048))
    assert rows["peak_error_g"] == pytest.approx(ERROR * rows["peak_g"])
    assert not list(peak_rows(motion(0.0), 60.0))


def test_bursts_raise_peaks_and_damage_where_the_records_have_them():
    bursts = Bursts(*np.array([[0.0, 1.4], [0.0, 0.3], [0.0, 2.3], [0.0, 0.7]]))
    psd = motion(1e-4, points=("P0", "P1"), error=0.0)._replace(bursts=bursts)
    calm, loud = list(peak_rows(psd, 60.0))
    largest = calm["peak_g"] / calm["acceleration_rms_g"]
    assert loud["peak_g"] == pytest.approx(calm["peak_g"] * transformed(largest, 1.4) / largest)
    ends = [transformed(largest, 1.4 + sign * 0.3) for sign in (1, -1)]
    error = (ends[0] - ends[1]) / 2 * loud["acceleration_rms_g"]
    assert loud["peak_error_g"] == pytest.approx(error)
    places = pd.MultiIndex.from_product([["P0", "P1"], ["top"], STRESSES])
    none = pd.Series(0.0, places)
    line = FatigueLine(100e6, 1e6, 8.0)
    stress = stress_of(1e8, ("top",))
    few, many = (
        table("fatigue", fatigue_rows(WHERE, stress, FREQUENCY, none, line, 60.0, records))
        for records in (Bursts.none(2), bursts)
    )
    np.testing.assert_allclose(many["damage_dirlik"] / few["damage_dirlik"], np.exp(2.3))
    assert (many["damage_log_error"] == 0.7).all() and (few["damage_log_error"] == 0).all()


@pytest.mark.parametrize("exponent", [3.0, 4.0, 6.0, 8.0, 12.0, 20.0])
def test_damage_of_records_goes_with_the_exponent_as_that_of_a_slow_factor(exponent):
    # a Gaussian motion whose ln rms has the variance v: ⟨a^b⟩/⟨a²⟩^(b/2) = exp(v b(b − 2)/2)
    variance = np.array([0.02, 0.0, -0.01])
    columns = {"excess_kurtosis": 0.1, "excess_kurtosis_error": 0.1}
    for b in (4, 8, 12):
        columns |= {f"log_damage_{b}": variance * b * (b - 2) / 2, f"log_damage_error_{b}": 0.0}
    found = Bursts.recorded(pd.DataFrame(columns), exponent)
    expected = np.maximum(variance, 0) * exponent * (exponent - 2) / 2
    np.testing.assert_allclose(found.damage, expected, atol=1e-12)


def three_sigmas():
    """Stresses of 3σ of a layer and of the core at a point [MPa], with errors."""
    rows = [("P", "top", name, 10.0 * k, 0.1 * k) for k, name in enumerate(STRESSES, 1)]
    rows += [("P", CORE, name, -1.0 * k, 0.2 * k) for k, name in enumerate(CORE_STRESSES, 1)]
    names = ["point", "layer", "quantity", "three_sigma", "relative_error"]
    return pd.DataFrame(rows, columns=names).set_index(names[:3])


def test_indices_are_those_of_the_strengths_that_a_study_states():
    layers, core = LayerStrength(100.0, 100.0, 50.0, 50.0, 60.0), (4.0, 4.0)
    both = table("strength", strength_rows(WHERE, three_sigmas(), layers, core))
    expected = {"top": max(10 / 100, 20 / 50, 30 / 60), CORE: 2.0 / 4}
    assert both.set_index("layer")["maximum_stress_index"].to_dict() == pytest.approx(expected)
    assert both.set_index("layer")["relative_error"].to_dict() == pytest.approx(
        {"top": 0.3, CORE: 0.4}
    )
    assert both["layer"].tolist() == ["top", CORE]  # as in the table of the stresses
    alone = table("strength", strength_rows(WHERE, three_sigmas(), layers, None))
    assert alone["layer"].tolist() == ["top"]
    alone = table("strength", strength_rows(WHERE, three_sigmas(), None, core))
    assert alone["layer"].tolist() == [CORE] and np.isnan(alone["tsai_wu_index"]).all()


def test_maps_of_indices_are_of_three_sigma():
    fields = {f"{name}_rms": (("case", "layer", "vertex"), np.full((1, 1, 3), 1e6 * k))
              for k, name in enumerate(STRESSES[:3], 1)}  # fmt: skip
    fields |= {f"{name}_rms": (("case", "vertex"), np.full((1, 3), 1e5 * k))
               for k, name in enumerate(CORE_STRESSES, 1)}  # fmt: skip
    fields |= {"vertex_position": (("vertex", "axis"), np.zeros((3, 2))),
               "cells": (("cell", "corner"), np.zeros((1, 3), int))}  # fmt: skip
    layers = LayerStrength(30.0, 30.0, 30.0, 30.0, 30.0)
    maps = index_maps(xr.Dataset(fields), layers, (0.6, 1.2))
    np.testing.assert_allclose(maps["maximum_stress_index"], 3 * 3 / 30)
    np.testing.assert_allclose(maps["core_index"], max(0.3 / 0.6, 0.6 / 1.2))
    assert "core_index" not in index_maps(xr.Dataset(fields), layers, None)
