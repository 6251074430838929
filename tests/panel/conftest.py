"""The panel of the paper: 1.5 m x 1.0 m, 30 x 20 elements, three patches, three points."""

from pathlib import Path

import pytest

from pidpanel.geometry.polygon import Rectangle
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.plate import AssembledPlate
from pidpanel.panel.section import ThinSection
from pidpanel.panel.thin import assemble_thin_plate
from tests.panel_basis import panel_basis

SIZE = (1.5, 1.0)
ELEMENTS = (30, 20)
PATCHES = {
    "PID-1": Rectangle((0.75, 0.50), (0.2, 0.2)),
    "PID-2": Rectangle((0.10, 0.30), (0.2, 0.2)),
    "PID-3": Rectangle((0.35, 0.50), (0.2, 0.2)),
}
POINTS = {"326": (0.75, 0.50), "189": (0.10, 0.30), "318": (0.35, 0.50)}
# D / m'' = 818.27 m^4/s^2 is Table 1; m'' = 4 kg/m^2 is an assumption
SECTION = ThinSection(bending_stiffness=3273.07, mass_per_area=4.0)


@pytest.fixture(scope="session")
def paper_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("panel") / "paper.msh"


@pytest.fixture(scope="session")
def paper_mesh(paper_path: Path) -> PanelMesh:
    return mesh_quadrilaterals(paper_path, SIZE, ELEMENTS, PATCHES, POINTS)


@pytest.fixture(scope="session")
def paper_plate(paper_mesh: PanelMesh) -> AssembledPlate:
    return assemble_thin_plate(paper_mesh, SECTION)


@pytest.fixture(scope="session")
def paper_basis(paper_mesh: PanelMesh, paper_plate: AssembledPlate) -> PanelBasis:
    return panel_basis(paper_mesh, paper_plate, frequency_limit=3000.0)
