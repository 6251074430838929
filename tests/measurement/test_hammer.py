"""Acceleration over the force of a hammer, against Navier's sum and the files that have it."""

import numpy as np
import pytest
import pyuff

from pidpanel.columns import ColumnsError
from pidpanel.measurement.computed import point_remainder, squared_accelerance
from pidpanel.measurement.files import FORCE_COLUMN, read_measured
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.navier import thin_plate_frequency
from pidpanel.panel.section import ThinSection
from pidpanel.panel.supports import Supports
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.solve.model import ModalBasis
from pidpanel.solve.panel import deflection_at_points
from tests.panel_basis import panel_basis

A, B, RATIO = 1.2, 0.8, 0.02
SECTION = ThinSection(3273.0, 4.0)
POINTS = {"X": (0.5, 0.37), "Y": (0.31, 0.22)}
FREQUENCY = np.linspace(20.0, 400.0, 97)


def navier(x, y):
    """a/F of a simply supported plate, by 60 × 60 modes [1/kg]."""
    m, n = np.mgrid[1:61, 1:61].reshape(2, -1)
    shape = [np.sin(m * np.pi * px / A) * np.sin(n * np.pi * py / B) for px, py in (x, y)]
    natural = 2 * np.pi * thin_plate_frequency(m, n, (A, B), SECTION)
    omega = 2 * np.pi * FREQUENCY[:, None]
    stiffness = SECTION.mass_per_area * A * B / 4 * (
        natural**2 - omega**2 + 2j * RATIO * natural * omega
    )  # fmt: skip
    return (omega[:, 0] ** 2) * np.sum(shape[0] * shape[1] / stiffness, axis=1)


@pytest.mark.parametrize("mass", [None, 0.5])
def test_the_accelerance_is_naviers_and_reciprocal(tmp_path, mass):
    mesh = mesh_quadrilaterals(tmp_path / "m.msh", (A, B), (24, 16), {}, POINTS)
    plate = assemble_thin_plate(mesh, SECTION)
    basis = panel_basis(mesh, plate, 900.0)
    modal = ModalBasis(basis.natural_frequency, basis.modal_mass, RATIO)
    remainder, air = point_remainder(plate, modal, deflection_at_points(basis)), None
    if mass is not None:  # of the air, taken from the panel: the sum is that of both
        whole, modal = (
            modal,
            ModalBasis(basis.natural_frequency, basis.modal_mass * (1 - mass), RATIO),
        )

        def air(frequency):
            heavy = whole.dynamic_stiffness(frequency) - modal.dynamic_stiffness(frequency)
            return heavy[:, :, None] * np.eye(basis.modal_mass.size)

    deflection = deflection_at_points(basis)
    square = squared_accelerance(modal, deflection, remainder, FREQUENCY, air)
    np.testing.assert_allclose(square, square.swapaxes(1, 2), rtol=1e-9)
    for k, point in enumerate(POINTS.values()):
        expected = np.abs(navier(point, POINTS["Y"]))
        # modes above 900 Hz are taken as static: (400/900)² of their share, and their elements' error
        found, atol = np.sqrt(square[:, k, 1]), 2e-3 * expected.max()
        np.testing.assert_allclose(found, expected, rtol=0.01, atol=atol)


def test_a_free_panel_hit_slowly_is_a_rigid_mass(tmp_path):
    mesh = mesh_quadrilaterals(tmp_path / "m.msh", (A, B), (12, 8), {}, {"C": (A / 2, B / 2)})
    plate = assemble_thin_plate(mesh, SECTION, Supports("free"))
    basis = panel_basis(mesh, plate, 500.0)
    modal = ModalBasis(basis.natural_frequency, basis.modal_mass, RATIO)
    deflection = deflection_at_points(basis)
    remainder = point_remainder(plate, modal, deflection)
    square = squared_accelerance(modal, deflection, remainder, np.array([0.5]), None)
    mass = SECTION.mass_per_area * A * B
    assert square.item() == pytest.approx(mass**-2, rel=1e-3)  # (0.5 Hz/f₁)² of the elastic part


@pytest.mark.parametrize(("over", "scale"), [("N", 1.0), ("lbf", 1 / 4.4482216)])
def test_an_acceleration_over_force_is_read_with_its_units(tmp_path, over, scale):
    path = tmp_path / "tap.uff"
    values = navier(POINTS["X"], POINTS["Y"])
    pyuff.UFF(str(path)).write_sets(
        pyuff.prepare_58(
            func_type=4, rsp_node=7, rsp_dir=3, ref_node=9, ref_dir=3, binary=1,
            abscissa_spec_data_type=18, ordinate_spec_data_type=12, orddenom_spec_data_type=13,
            ordinate_axis_units_lab="m/s^2", orddenom_axis_units_lab=over, x=FREQUENCY, data=values,
        ), mode="add",
    )  # fmt: skip
    measured = read_measured(path)
    assert measured.column == FORCE_COLUMN
    np.testing.assert_allclose(measured.psd, np.abs(scale * values) ** 2, rtol=1e-6)
    table = tmp_path / "tap.csv"
    table.write_text("f (Hz);Accelerance (g/N)\n20;0,1\n30;0,2\n")
    np.testing.assert_allclose(read_measured(table).psd, [0.980665**2, 1.96133**2])
    table.write_text("f,Accelerance (dB)\n20,1\n30,2\n")
    with pytest.raises(ColumnsError, match="must be in m/s"):
        read_measured(table)
