"""The modes of a panel as a file."""

import pytest

from pidpanel import Model
from tests.structures import COMMON, NORMAL, PANEL, grid_of, in_space


@pytest.fixture(scope="session")
def panel_model():
    return Model({"name": "flat", "panel": PANEL, **COMMON})


@pytest.fixture(scope="session")
def modes_file(panel_model, tmp_path_factory):
    path = tmp_path_factory.mktemp("modes") / "modes.vtu"
    grid_of(panel_model, 2000.0).save(path)
    return path


@pytest.fixture
def structure(modes_file):
    """The section ``structure`` of the same panel."""
    return {
        "modes": {"file": str(modes_file), "unit_m": 1},
        "mass_kg": 6,
        "outward": NORMAL.tolist(),
        "patches": {
            "P": {
                "corners_m": in_space([[0.4, 0.4], [0.6, 0.4], [0.6, 0.6], [0.4, 0.6]]).tolist(),
                "along": NORMAL.tolist(),
            }
        },
        "points": {
            "mid": {"at_m": in_space([0.75, 0.5]).tolist()},
            "off": {"at_m": in_space([0.5, 0.4]).tolist()},
        },
    }
