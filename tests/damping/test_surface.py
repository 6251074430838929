"""The surface of C_e and m_a: right at and between the cases, in its limits, honest beyond."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from pidpanel.damping import surface_files
from pidpanel.damping.models import DampingError
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_cases import groups, onset

FILLS = np.array([0.1, 0.5, 0.9])
FREQUENCIES = np.geomspace(30.0, 2000.0, 5)
LEVELS = np.array([3.0, 30.0, 300.0])
MASS_PER_FILL = 13.0


def law(r, f, level):
    """η falls like Γ^−0.8 and rises with the stroke over the gap; no dissipation below 1 g."""
    stroke = level / f**2 / (1 - r)
    return (1 - 1 / level**2) * 4 * r * f * level**-0.8 * (1 + 300 * stroke) ** 0.3


def mass(r, f, level):
    """All mass at the onset, a tenth of it in the gas."""
    return MASS_PER_FILL * r * (1 - 0.9 * (1 - 1 / level**2))


def frame(fills=FILLS, frequencies=FREQUENCIES, levels=LEVELS, relative=0.02):
    rows = [
        {"fill_fraction": r, "frequency_hz": f, "acceleration_g": a,
         "equivalent_damping_n_s_m3": law(r, f, a),
         "equivalent_damping_error_n_s_m3": relative * law(r, f, a),
         "apparent_mass_kg_m2": mass(r, f, a), "apparent_mass_error_kg_m2": 0.01,
         "particle_mass_per_area_kg_m2": MASS_PER_FILL * r, "status": "ok"}
        for r in fills for f in frequencies for a in levels
    ]  # fmt: skip
    return pd.DataFrame(rows).sample(frac=1, random_state=1)


@pytest.fixture(scope="module")
def surface():
    return DampingSurface.from_frame(frame())


def test_at_the_cases_it_gives_them_back_within_their_errors(surface):
    cases = frame()
    found = surface.evaluate(cases["fill_fraction"], cases["frequency_hz"], cases["acceleration_g"])
    away = found.equivalent_damping / cases["equivalent_damping_n_s_m3"] - 1
    assert np.abs(away).max() < 0.04  # two standard errors
    np.testing.assert_allclose(found.apparent_mass, cases["apparent_mass_kg_m2"], atol=0.02)
    assert found.inside.all()


def test_between_the_cases_a_smooth_law_is_found_within_the_errors_foretold(surface):
    rng = np.random.default_rng(3)
    r, f, level = (
        rng.uniform(0.1, 0.9, 300),
        np.exp(rng.uniform(np.log(30), np.log(2000), 300)),
        np.exp(rng.uniform(np.log(3), np.log(300), 300)),
    )
    found = surface.evaluate(r, f, level)
    true = law(r, f, level)
    z = (found.equivalent_damping - true) / found.equivalent_damping_error
    # one function, smoother than most of its kind: errors are foretold, if anything, too large
    assert (np.abs(z) < 2).mean() > 0.95
    assert np.abs(np.log(found.equivalent_damping / true)).max() < 0.2


# ------------------------------------------------------------------------ limits


def test_below_the_onset_the_bed_rides_along_with_all_its_mass(surface):
    found = surface(np.array([50.0, 500.0]), 0.5, 0.99)
    assert (found.equivalent_damping == 0).all()
    np.testing.assert_allclose(found.apparent_mass, 0.5 * MASS_PER_FILL)
    assert not found.inside.any()


def test_without_gravity_there_is_no_onset():
    surface = DampingSurface.from_frame(frame(), onset_g=0.0)
    assert surface.evaluate(0.5, [100.0], 0.01).equivalent_damping


def test_the_share_of_the_onset_is_that_of_the_kinetic_energy_at_lift_off():
    # at sin ωt = 1/Γ the cell moves at ωW cos ωt: cos² = 1 − 1/Γ²
    phase = np.arcsin(1 / 1.7)
    assert onset(1.7, 1.0) == pytest.approx(np.cos(phase) ** 2)


def test_nowhere_is_it_negative_or_above_the_bound(surface):
    rng = np.random.default_rng(5)
    r, f, level = (
        rng.uniform(0, 1, 2000),
        10 ** rng.uniform(0, 4, 2000),
        10 ** rng.uniform(-1, 4, 2000),
    )
    found = surface.evaluate(r, f, level)
    held_r, held_f = np.clip(r, 0.1, 0.9), np.clip(f, 30, 2000)
    bound = 4 * MASS_PER_FILL * held_r * 2 * np.pi * held_f / np.pi
    assert (found.equivalent_damping >= 0).all()
    assert (found.equivalent_damping <= bound * (1 + 1e-12)).all()


def test_the_bound_bites_where_the_cases_rise_towards_it():
    # η near the bound in all cases of a coarse sweep, rising with r: between, it must not exceed
    rows = frame(relative=0.3)
    bound = 8 * rows["particle_mass_per_area_kg_m2"] * rows["frequency_hz"]
    rows["equivalent_damping_n_s_m3"] = bound * np.where(rows["frequency_hz"] > 500, 0.99, 0.3)
    surface = DampingSurface.from_frame(rows)
    f = np.geomspace(30, 2000, 200)
    found = surface(f, 0.5, 30.0).equivalent_damping
    assert (found <= 8 * 0.5 * MASS_PER_FILL * f * (1 + 1e-12)).all()


def test_a_case_above_the_bound_lifts_it_to_its_own_share():
    rows = frame()
    first = rows.index[0]
    bound = 8 * rows.loc[first, "particle_mass_per_area_kg_m2"] * rows.loc[first, "frequency_hz"]
    rows.loc[first, "equivalent_damping_n_s_m3"] = 1.3 * bound
    assert DampingSurface.from_frame(rows).bound == pytest.approx(1.3 * 8 * MASS_PER_FILL)


def test_the_groups_do_not_change_where_stroke_and_gap_grow_alike():
    # half the gap and half the stroke (√2 times the frequency): the same W/L and Γ
    half = (1 - (1 - 0.94 * 0.5) / 2) / 0.94
    one = groups(np.array([0.5]), np.array([100.0]), np.array([7.0]))[0]
    other = groups(np.array([half]), np.array([100.0 * np.sqrt(2)]), np.array([7.0]))[0]
    np.testing.assert_allclose(one[1:], other[1:])


# ------------------------------------------------------------------------ domain


def test_beyond_the_cases_values_are_held_and_marked(surface):
    beyond = surface(np.array([100.0, 3000.0]), 0.5, 900.0)
    at_the_edge = surface(np.array([100.0, 2000.0]), 0.5, 300.0)
    assert not beyond.inside.any()
    # but for h, which is 1 − 1/900² in place of 1 − 1/300²
    np.testing.assert_allclose(beyond.equivalent_damping, at_the_edge.equivalent_damping, rtol=2e-5)


def test_a_corner_without_cases_lies_outside():
    rows = frame()
    lacking = (rows["frequency_hz"] < 100) & (rows["acceleration_g"] > 100)
    surface = DampingSurface.from_frame(rows[~lacking])
    assert surface(np.array([35.0, 250.0]), 0.5, 280.0).inside.tolist() == [False, True]
    # between the lowest frequency's last level and the next frequency's, by the line in ln f, ln Γ
    second = np.sort(rows["frequency_hz"].unique())[2]
    middle = np.sqrt(30.0 * second)
    edge = np.sqrt(30.0 * 300.0)
    assert surface(np.array([middle]), 0.5, edge * 0.99).inside.all()
    assert not surface(np.array([middle]), 0.5, edge * 1.01).inside.any()


@pytest.mark.parametrize(
    ("of", "asked", "inside"),
    [
        ({"levels": LEVELS[:1]}, (0.3, 3.0), [True]),
        ({"fills": FILLS[1:2]}, (0.5, 30.0), [True]),
        ({"fills": FILLS[1:2]}, (0.6, 30.0), [False]),
        ({"fills": FILLS[:1], "levels": LEVELS[:1]}, (0.1, 3.0), [True]),
        ({"fills": FILLS[:1], "levels": LEVELS[:1], "frequencies": [100.0]}, (0.1, 3.0), [True]),
    ],
)
def test_a_sweep_without_spread_along_an_axis_has_a_domain_all_the_same(of, asked, inside):
    found = DampingSurface.from_frame(frame(**of))(np.array([100.0]), *asked)
    assert found.inside.tolist() == inside
    assert (found.equivalent_damping > 0).all()


# ------------------------------------------------------------------------ what counts


def test_rows_that_failed_or_vanish_in_their_error_or_lie_below_the_onset_do_not_count():
    rows = frame()
    a, b, c = rows.index[:3]
    rows.loc[a, "status"] = "EnergyNotClosed"
    rows.loc[b, "equivalent_damping_error_n_s_m3"] = 1e9
    rows.loc[c, "acceleration_g"] = 0.7
    assert len(DampingSurface.from_frame(rows).cases) == len(rows) - 3


def test_without_any_row_that_counts_it_refuses():
    with pytest.raises(DampingError, match="0 of 45 rows count"):
        DampingSurface.from_frame(frame().assign(status="RunStopped"))


def test_two_rows_at_one_point_are_refused():
    rows = frame()
    with pytest.raises(DampingError, match="duplicate rows at fill_fraction"):
        DampingSurface.from_frame(pd.concat([rows, rows.iloc[:1]]))


# ------------------------------------------------------------------------ covariance


def test_the_covariance_has_the_standard_errors_on_its_diagonal(surface):
    frequency = np.geomspace(30, 2000, 40)
    covariance = surface.covariance(frequency, 0.3, 20.0)
    found = surface.evaluate(np.full(40, 0.3), frequency, np.full(40, 20.0))
    relative = found.equivalent_damping_error / found.equivalent_damping
    error = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(error[:40], relative, rtol=1e-6)
    # m_a: read a second surface that differs in g_m by its standard error
    point = groups(np.full(40, 0.3), frequency, np.full(40, 20.0))
    of = surface.mass.riding
    mass_error = 0.3 * (1 - 1 / 400) * np.hypot(of.standard_error(point), of.scatter)
    np.testing.assert_allclose(error[40:], mass_error, rtol=1e-6)
    assert np.linalg.eigvalsh(covariance).min() > -1e-12


def test_two_points_of_one_surface_err_alike_as_far_as_they_are_alike(surface):
    # a Gaussian process is a function: values at two points are jointly normal, so their joint
    # matrix has no negative eigenvalue, the blocks on its diagonal are the covariances, and the
    # difference of the two has the variance that the process itself foretells for it
    frequency = np.geomspace(30, 2000, 12)
    one, other = (0.3, 20.0), (0.7, 5.0)
    blocks = [
        [surface.cross_covariance(frequency, a, b) for b in (one, other)] for a in (one, other)
    ]
    joint = np.block(blocks)
    # what rounding leaves of the posterior, 1e-9 of the prior variance of the mean
    assert np.linalg.eigvalsh(joint).min() > -1e-9 * np.diag(joint).max()
    for block, point in ((blocks[0][0], one), (blocks[1][1], other)):
        np.testing.assert_array_equal(block, surface.covariance(frequency, *point))
    np.testing.assert_allclose(blocks[0][1], blocks[1][0].T, rtol=1e-6, atol=1e-12)
    points = [groups(np.full(12, r), frequency, np.full(12, level)) for r, level in (one, other)]
    both = surface.damping.riding.covariance(np.concatenate(points))
    np.testing.assert_allclose(blocks[0][1][:12, :12], both[:12, 12:], rtol=1e-6, atol=1e-12)
    h = [1 - 1 / level**2 for _, level in (one, other)]
    mass = surface.mass.riding.covariance(*points) * 0.3 * h[0] * 0.7 * h[1]
    np.testing.assert_allclose(blocks[0][1][12:, 12:], mass, rtol=1e-6)
    assert (blocks[0][1][:12, 12:] == 0).all() and (blocks[0][1][12:, :12] == 0).all()
    # near points err nearly alike
    near = surface.cross_covariance(frequency, one, (0.301, 20.1))
    np.testing.assert_allclose(np.diag(near), np.diag(blocks[0][0]), rtol=0.02)


def test_the_particles_weigh_what_the_cases_say(surface):
    assert surface.mass_per_area(0.4) == pytest.approx(0.4 * MASS_PER_FILL)
    assert surface.without_mass().mass_per_area(0.4) == surface.mass_per_area(0.4)
    unknown = frame().drop(columns="particle_mass_per_area_kg_m2")
    assert np.isnan(DampingSurface.from_frame(unknown).mass_per_area(0.4))


# ------------------------------------------------------------------------ files


def test_the_file_gives_the_surface_back(surface, tmp_path):
    surface_files.to_dataset(surface).to_netcdf(tmp_path / "s.nc", engine="scipy")
    with xr.open_dataset(tmp_path / "s.nc", engine="scipy") as dataset:
        assert dataset["case_frequency_hz"].attrs["units"] == "Hz"
        back = surface_files.from_dataset(dataset.load())
    asked = np.geomspace(20, 3000, 50)
    for name in ("equivalent_damping", "equivalent_damping_error", "apparent_mass", "inside"):
        np.testing.assert_array_equal(
            getattr(back(asked, 0.4, 20.0), name), getattr(surface(asked, 0.4, 20.0), name)
        )


def test_the_bound_is_that_of_an_inelastic_bed_where_the_mass_is_known(surface):
    # C_e ≤ 4 m₁ r ω/π = 8 m₁ r f
    assert surface.bound == pytest.approx(8 * MASS_PER_FILL)
    unknown = DampingSurface.from_frame(frame().drop(columns="particle_mass_per_area_kg_m2"))
    assert unknown.bound == np.inf


def test_a_surface_of_one_acceleration_has_its_covariance_whatever_is_asked():
    one = DampingSurface.from_frame(frame(levels=LEVELS[1:2]))
    assert not one.depends_on_acceleration
    frequency = np.array([50.0, 400.0])
    asked = [one.covariance(frequency, 0.5, gamma) for gamma in (3.0, 30.0, 300.0)]
    np.testing.assert_array_equal(asked[0], asked[1])
    np.testing.assert_array_equal(asked[2], asked[1])
    assert (np.diag(asked[1]) > 0).all()
