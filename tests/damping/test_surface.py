"""The table of C_e and m_a: right at the run points, between them, and honest beyond."""

import numpy as np
import pandas as pd
import pytest

from pidpanel.damping.surface import DampingError, DampingTable

FILLS = np.array([0.1, 0.5, 0.9])
FREQUENCIES = np.array([30.0, 200.0, 2000.0])
LEVELS = np.array([3.0, 30.0, 300.0])


def law(r, f, level):
    """C_e = 1000 e^{2r} (f/100)^0.7 Γ^−0.8: a plane in (r, ln f, ln Γ) for ln C_e."""
    return 1000 * np.exp(2 * r) * (f / 100) ** 0.7 * level**-0.8


def mass(r, f, level):
    return 1 + 2 * r - 0.5 * np.log(f / 100) - 0.3 * np.log(level)


def table(**changes):
    grid = np.meshgrid(FILLS, FREQUENCIES, LEVELS, indexing="ij")
    values = {"damping": law(*grid), "error": 0.05 * law(*grid), "mass": mass(*grid)}
    values.update(changes)
    return DampingTable(
        FILLS, FREQUENCIES, LEVELS, values["damping"], values["error"], values["mass"]
    )


def test_a_power_law_is_recovered_everywhere_between_the_run_points():
    frequency = np.array([30.0, 55.5, 200.0, 700.0, 2000.0])
    for r, level in ((0.1, 3.0), (0.33, 17.0), (0.9, 300.0)):
        found = table()(frequency, r, level)
        # linear in r, ln f and ln Γ, so only rounding is left
        np.testing.assert_allclose(found.equivalent_damping, law(r, frequency, level), rtol=1e-12)
        np.testing.assert_allclose(found.apparent_mass, mass(r, frequency, level), rtol=1e-12)
        np.testing.assert_allclose(
            found.equivalent_damping_error, 0.05 * found.equivalent_damping, rtol=1e-12
        )
        assert found.inside.all()


def test_beyond_the_run_points_the_last_value_is_held_and_marked():
    found = table()(np.array([100.0, 3000.0]), 0.5, 900.0)
    assert not found.inside.any()
    assert found.equivalent_damping[0] == pytest.approx(law(0.5, 100.0, 300.0))
    assert found.equivalent_damping[1] == pytest.approx(law(0.5, 2000.0, 300.0))


def test_beyond_the_run_points_it_refuses_if_asked_to():
    with pytest.raises(DampingError, match=r"acceleration_g = 900 at fill_fraction 0\.5"):
        table()(np.array([100.0]), 0.5, 900.0, outside="refuse")


def test_a_failed_case_is_continued_along_the_level_and_marked():
    damping = table().equivalent_damping.copy()
    damping[1, 0, 2] = np.nan  # r = 0.5, 30 Hz, 300 g
    holed = table(damping=damping)
    found = holed(np.array([30.0, 200.0]), 0.5, 300.0)
    # a power law continues exactly; that it is a continuation is said
    assert found.equivalent_damping[0] == pytest.approx(law(0.5, 30.0, 300.0))
    assert found.inside.tolist() == [False, True]
    assert holed(np.array([30.0]), 0.5, 30.0).inside.all()
    assert not holed(np.array([30.0]), 0.5, 100.0).inside.any()


def test_a_value_within_its_own_error_is_no_run_point():
    error = 0.05 * table().equivalent_damping
    error[0, 0, 0] = 2 * table().equivalent_damping[0, 0, 0]
    assert not table(error=error)(np.array([30.0]), 0.1, 3.0).inside.any()


def test_a_frequency_without_any_case_is_refused_by_name():
    damping = table().equivalent_damping.copy()
    damping[1, 1, :] = np.nan
    with pytest.raises(
        DampingError, match=r"no case stands at fill_fraction 0\.5, frequency_hz 200"
    ):
        table(damping=damping)


def test_a_table_of_one_level_does_not_depend_on_level():
    one = DampingTable(
        FILLS,
        FREQUENCIES,
        LEVELS[:1],
        *(np.ones((3, 3, 3, 1)) * [[[[5.0]]]] * [[[[1.0]]], [[[0.1]]], [[[1.0]]]]),
    )
    assert not one.depends_on_level
    assert one(np.array([100.0]), 0.3, 3.0).equivalent_damping[0] == pytest.approx(5.0)


def frame():
    rows = [
        {"fill_fraction": r, "frequency_hz": f, "acceleration_g": a,
         "equivalent_damping_n_s_m3": law(r, f, a), "equivalent_damping_error_n_s_m3": 1.0,
         "apparent_mass_kg_m2": mass(r, f, a), "status": "ok"}
        for r in FILLS for f in FREQUENCIES for a in LEVELS
    ]  # fmt: skip
    return pd.DataFrame(rows).sample(frac=1, random_state=1)


def test_rows_in_any_order_become_the_table():
    found = DampingTable.from_frame(frame())
    np.testing.assert_allclose(found.equivalent_damping, table().equivalent_damping)


def test_rows_that_failed_do_not_count():
    rows = frame()
    rows.loc[rows.index[0], "status"] = "NotSteady"
    assert np.isnan(DampingTable.from_frame(rows).equivalent_damping).sum() == 1


def test_two_rows_at_one_point_are_refused():
    rows = frame()
    with pytest.raises(DampingError, match="two rows at fill_fraction"):
        DampingTable.from_frame(pd.concat([rows, rows.iloc[:1]]))


def test_a_missing_column_is_named(tmp_path):
    path = tmp_path / "mine.csv"
    path.write_text("# measured\nfill_fraction,frequency_hz\n0.5,100\n")
    with pytest.raises(DampingError, match=r"mine\.csv: column acceleration_g is missing"):
        DampingTable.from_csv(path)


def test_the_file_gives_the_table_back(tmp_path):
    table().to_dataset().to_netcdf(tmp_path / "t.nc", engine="scipy")
    import xarray as xr

    with xr.open_dataset(tmp_path / "t.nc", engine="scipy") as dataset:
        back = DampingTable.from_dataset(dataset.load())
    np.testing.assert_array_equal(back.equivalent_damping, table().equivalent_damping)
    assert back(np.array([77.0]), 0.4, 20.0).equivalent_damping == pytest.approx(
        table()(np.array([77.0]), 0.4, 20.0).equivalent_damping
    )
