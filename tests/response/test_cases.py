"""What is to be solved: masses, lines that resolve them, lines of the power balance."""

from types import SimpleNamespace

import numpy as np

from pidpanel.damping.models import Damper, DampingValues, FilledDamper
from pidpanel.response.cases import (
    ResponseScenario,
    balance_of,
    heaviest_dampers,
    plan_cases,
)
from pidpanel.solve.layout import DamperLayout


class Model(Damper):
    """Damping with an apparent mass that depends on Γ."""

    nodes = None

    def __init__(self, weight, mass, depends=True):
        self.weight, self.mass, self.depends_on_acceleration = weight, mass, depends
        self.asked = []

    def mass_per_area(self, fill_fraction):
        return self.weight * fill_fraction

    def __call__(self, frequency, fill_fraction, gamma):
        self.asked.append(gamma)
        mass = self.mass(gamma) * frequency / frequency.max()
        return DampingValues(mass, mass, mass, mass > 0)


def test_the_largest_mass_is_that_of_any_motion_of_four_decades():
    lines = np.array([20.0, 50.0])
    for weight, peak, expected in ((4.0, 100.0, 6.0), (8.0, 1000.0, 8.0), (np.nan, 10.0, 6.0)):
        model = Model(weight, lambda gamma, peak=peak: 6.0 if gamma == peak else 1.0)
        assert FilledDamper("d", model, 1.0).largest_mass(lines) == expected
        assert model.asked == [1.0, 10.0, 100.0, 1000.0]
    steady = Model(1.0, lambda gamma: 2.0, depends=False)
    assert FilledDamper("d", steady, 0.5).largest_mass(lines) == 2.0
    assert steady.asked == [1.0]


def test_a_patch_counts_with_its_heaviest_damper_from_end_to_end_of_the_range():
    settings = SimpleNamespace(frequency_range=(20.0, 2000.0))
    basis = SimpleNamespace(patch_names=["a", "b", "c"])
    panel = SimpleNamespace(patch_area=np.ones(3), settings=settings, basis=basis)
    heavy, light = (Model(m, lambda _: 1.0, depends=False) for m in (3.0, 2.0))
    rising = Model(1.0, lambda _: 5.0, depends=False)  # at the highest frequency
    scenarios = scenarios_of({"a": heavy, "c": rising}, {"a": light})
    assert heaviest_dampers(panel, scenarios).tolist() == [3.0, 0.0, 5.0]


def test_the_power_balance_of_a_scenario_is_that_at_its_level_and_its_worst_line(monkeypatch):
    given = {}

    def balance(frequency, modal, patches, spectrum, *others):
        given.update(frequency=frequency, spectrum=spectrum)
        return SimpleNamespace(error=np.array([1e-12, 3e-9, 1e-10]))

    monkeypatch.setattr("pidpanel.response.cases.power_balance", balance)

    class Force:
        def spectrum(self, frequency):
            return 4 * frequency

        def __call__(self, frequency):
            return frequency

    frequency = np.arange(1.0, 121.0)
    panel = SimpleNamespace(
        basis=SimpleNamespace(modal_mass=np.ones(300)), frequency=frequency, air=None, modal=None,
        excitation=Force(), carrier_patches=SimpleNamespace(subset=lambda loads: loads),
    )  # fmt: skip
    response = SimpleNamespace(
        patches=np.array([0]),
        equivalent_damping=np.zeros((1, 120)),
        apparent_mass=np.zeros((1, 120)),
    )
    assert balance_of(panel)(response, 2.5) == 3e-9
    np.testing.assert_array_equal(given["frequency"], [21, 61, 101])
    np.testing.assert_array_equal(given["spectrum"], 10 * given["frequency"])


def scenarios_of(*dampers):
    """The bare panel, and a scenario for each mapping of patches to damping models."""
    return [
        ResponseScenario("bare", "bare", 150.0, 2.5),
        *(
            ResponseScenario(
                f"s{number}", "bare", 150.0, 2.5,
                {patch: FilledDamper(f"{number}{patch}", model) for patch, model in by_patch.items()},
            )
            for number, by_patch in enumerate(dampers)
        ),
    ]  # fmt: skip


def plan_of(*models, dead_weight=True):
    settings = SimpleNamespace(stated_acceleration_g=None)
    basis = SimpleNamespace(patch_names=["a", "b"])
    panel = SimpleNamespace(basis=basis, carriers=np.array([0, 1, 1]), settings=settings)
    scenarios = scenarios_of(*({"b": model} for model in models))
    return plan_cases(panel, scenarios, dead_weight=dead_weight)


def test_masses_that_do_not_damp_are_solved_once_for_each_set_of_masses():
    heavy, alike, unknown = Model(6.0, float), Model(6.0, float), Model(np.nan, float)
    plan = plan_of(heavy, alike, unknown)
    dead = [row[4] for row in plan.rows[1:]]
    assert dead[0] == dead[1] and dead[2] is None
    assert plan.rows[0][4] is None
    layout = plan.layouts[dead[0]]
    assert isinstance(layout, DamperLayout) and not layout.with_motion and layout.factor == 2.5
    assert [load.patch for load in layout.dampers] == [1, 2]  # both elements of the patch
    damping, mass, inside = layout.dampers[0].damping(np.array([20.0, 50.0]), 3.0)
    assert not damping.any() and mass.tolist() == [6.0, 6.0] and inside.all()
    assert not layout.dampers[0].depends_on_acceleration
    assert all(row[4] is None for row in plan_of(heavy, dead_weight=False).rows)
    alone = plan.response_alone().layouts.values()
    assert not any(layout.with_motion or layout.with_slope for layout in alone)


def test_slopes_are_solved_where_a_damper_has_errors():
    exact, uncertain = Model(6.0, float), Model(6.0, float)
    uncertain.nodes = np.ones(1)
    plan = plan_of(exact, uncertain)
    own = [plan.layouts[row[2]] for row in plan.rows[1:]]
    assert [layout.with_slope for layout in own] == [False, True]


def two_patches(first, second):
    """The plan of two dampers on two patches, each with its own model."""
    _, scenario = scenarios_of({"b": first, "a": second})
    assert not scenario.is_bare and scenario.patches == ("b", "a")
    settings = SimpleNamespace(stated_acceleration_g=None)
    basis = SimpleNamespace(patch_names=["a", "b"])
    panel = SimpleNamespace(basis=basis, carriers=np.array([0, 1]), settings=settings)
    return plan_cases(panel, [scenario])


def test_one_unknown_mass_leaves_no_dead_weight_and_one_uncertain_damper_has_slopes():
    known, unknown = Model(6.0, float), Model(np.nan, float)
    unknown.nodes = np.ones(1)
    plan = two_patches(known, unknown)
    assert plan.rows[0][4] is None
    assert plan.layouts[plan.rows[0][2]].with_slope
    assert two_patches(known, known).rows[0][4] is not None
    assert ResponseScenario("bare", "bare", 150.0, 1.0).is_bare
