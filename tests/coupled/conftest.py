"""A plate of few shapes in closed form, and particles that have an impedance in closed form."""

from types import SimpleNamespace

import numpy as np
import pytest

from pidpanel.coupled.excited_panel import ExcitedPanel
from pidpanel.coupled.integration import Integration
from pidpanel.coupled.scenario import RunSettings
from pidpanel.coupon import attempts
from pidpanel.damping_ratio import DampingRatio
from pidpanel.geometry.polygon import Rectangle
from pidpanel.panel.basis import basis_of
from pidpanel.panel.files import read_plate, write_plate
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.section import ThinSection
from pidpanel.panel.shapes import panel_shapes
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.solve.excitation import ModalForce
from pidpanel.solve.model import ModalBasis
from tests.beds import hexagons


@pytest.fixture(scope="session")
def bed(tmp_path_factory):
    """Eight cells half full, and their folder."""
    folder = tmp_path_factory.mktemp("bed")
    found = hexagons(50)
    packing = folder / "packing" / found.packing.label / "packing.json"
    file = folder / "bed" / found.label / "bed.json"
    poured = attempts.pour_packing(found.packing, packing)
    loosened = attempts.loosen_bed(found, packing, file)
    assert (poured.status, loosened.status) == ("ok", "ok")
    return found, file.parent


@pytest.fixture(scope="session")
def integrate():
    """All rows of a run in one piece."""

    def whole(*of, particles, start):
        run = Integration(*of)
        return recorded(run, *run.advance(particles, run.begin(start), run.rows))

    return whole


def recorded(run, rows, state):
    """The rows of a run with its balance and their interval; the impulse is per area of a cell."""
    return SimpleNamespace(
        at_cells=rows.at_cells,
        at_points=rows.at_points,
        impulse=rows.impulse / run.cell_area,
        balance=run.balance(state),
        interval=run.row_interval,
    )


class Oscillators:
    """A mass on a spring and a dashpot in every cell: Z = iωm (k + iωc)/(k − ω²m + iωc).

    Moved as LIGGGHTS moves its spheres: force from the place at the end of a step and the speed
    of its middle.
    """

    def __init__(self, mass, stiffness, damping, time_step):
        self.mass, self.stiffness, self.damping = mass, stiffness, damping
        self.time_step = time_step
        self.place = np.zeros_like(mass)
        self.speed = np.zeros_like(mass)
        self.force = np.zeros_like(mass)

    def wall_force(self):
        return self.force

    def advance(self, kick, substeps):
        self.speed = self.speed + kick
        before, half = self.speed, self.time_step / 2 / self.mass
        for _ in range(substeps):
            middle = self.speed + half * self.force
            self.place = self.place + self.time_step * middle
            self.force = -self.stiffness * self.place - self.damping * middle
            self.speed = middle + half * self.force
        return self.mass * (self.speed - before)

    def impedance(self, frequency):
        """(nf, k) force of the panel over its velocity [N s/m]."""
        omega = 2 * np.pi * frequency[:, None]
        spring = self.stiffness + 1j * omega * self.damping
        return 1j * omega * self.mass * spring / (spring - omega**2 * self.mass)


def _plate(nx=5, ny=3):
    """Simply supported, 1.0 m × 0.7 m, 4 kg/m², f = 20 (m² + (n/0.7)²) Hz, ζ = 2 %."""
    order = [(m, n) for m in range(1, nx + 1) for n in range(1, ny + 1)]
    frequency = np.array([20.0 * (m**2 + (n / 0.7) ** 2) for m, n in order])

    def shape(x, y):
        rows = [np.sin(m * np.pi * x) * np.sin(n * np.pi * y / 0.7) for m, n in order]
        return np.array(rows).T

    cells = np.array([[x, y] for x in (0.35, 0.45, 0.55, 0.65) for y in (0.3, 0.4)])
    points = np.array([[0.5, 0.35], [0.2, 0.1]])
    modal = ModalBasis(frequency, np.full(len(order), 4.0 * 0.7 / 4), 0.02)

    def stiffness(f):
        omega = 2 * np.pi * f[:, None]
        own = modal.angular_frequency
        return modal.modal_mass * (own**2 - omega**2 + 2j * modal.damping_ratio * own * omega)

    return SimpleNamespace(
        modal=modal,
        recorded=recorded,
        at_cells=shape(*cells.T),
        at_points=shape(*points.T),
        stiffness=stiffness,
        area=np.full(8, 0.01),
        cells=cells,
        shape=shape,
        count=len(order),
    )


@pytest.fixture(scope="session")
def plate():
    return _plate()


@pytest.fixture(scope="session")
def oscillators():
    return Oscillators


@pytest.fixture(scope="session")
def excited(tmp_path_factory):
    """The paper's panel of 12 × 10 elements, with a patch of 8 × 8 and one of 2 × 8."""
    folder = tmp_path_factory.mktemp("excited")
    patches = {
        "middle": Rectangle((0.75, 0.5), (1.0, 0.8)),
        "side": Rectangle((0.125, 0.5), (0.25, 0.8)),
    }
    points = {"centre": (0.75, 0.5), "corner": (0.25, 0.2)}
    mesh = mesh_quadrilaterals(folder / "panel.msh", (1.5, 1.0), (12, 10), patches, points)
    plate = assemble_thin_plate(mesh, ThinSection(bending_stiffness=3273.07, mass_per_area=4.0))
    shapes = panel_shapes(plate, 300.0, residual_tolerance=1.0)
    write_plate(folder / "plate.nc", plate.with_shapes(shapes.vectors), {})
    root = 0.1 * np.random.default_rng(2).standard_normal(2 * [shapes.vectors.shape[1]])
    return ExcitedPanel(
        RunSettings(
            frequency_range=(40.0, 150.0),
            damping_ratio=DampingRatio((0.02,)),
            wave_speed=343.0,
            duration=0.5043,
            settling=0.031,
            stations=4,
            cells=8,
            youngs_modulus=None,
            attributes={"study": "mine"},
        ),
        basis_of(mesh, plate, shapes),
        read_plate(folder / "plate.nc"),
        shapes.vectors,
        ModalForce(lambda f: 2.0 + f / 50, root @ root.T),
        None,
    )
