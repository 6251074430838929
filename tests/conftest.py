"""What holds for all tests, and small studies that need no LIGGGHTS."""

import copy
import sys
from pathlib import Path

import pytest
import yaml
from hypothesis import HealthCheck, settings

# otherwise every worker compiles all tests and the package anew, ten seconds
sys.dont_write_bytecode = False

# no test depends on how fast the machine is or on a draw of its own
settings.register_profile(
    "any machine", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("any machine")

TESTS = Path(__file__).parent
SHARED = {"coupled", "docs", "report", "response"}
"""Folders whose tests share what took long to make."""


@pytest.hookimpl(tryfirst=True)  # before the groups are read
def pytest_collection_modifyitems(items):
    """Long groups first, and together what shares results: two processes end together."""
    items.sort(key=_group_rank)  # keeps the order otherwise
    for item in items:
        folder = item.path.relative_to(TESTS).parts[0]
        group = folder if folder in SHARED else str(item.path)
        item.add_marker(pytest.mark.xdist_group(group))


def _group_rank(item):
    """0 of whole workflows, 1 of folders that share results, 2 of all others."""
    folder = item.path.relative_to(TESTS).parts[0]
    return 0 if folder == "workflow" else 1 if folder in SHARED else 2


LAWS = ["paper", "printed"]
LAW = {
    "title": "A small panel with the paper's law",
    "dampers": {"paper": {"law": "paper_corrected"}, "printed": {"law": "paper_printed"}},
    "panel": {
        "outline_m": [1.5, 1.0],
        "section": {
            "kind": "thin",
            "mass_per_area_kg_m2": 4.0,
            "bending_stiffness_n_m": 3273.07,
            "thickness_mm": 25,
        },
        "supports": "simply_supported",
        "damping_ratio": 0.02,
        "mesh": {"kind": "quadrilaterals", "elements": [10, 8]},
        "patches": {
            "PID-1": {"centre_m": [0.75, 0.5], "size_m": [0.3, 0.25]},
            "Left wing": {"centre_m": [0.3, 0.5], "size_m": [0.3, 0.25]},
        },
        "points": {"centre": [0.75, 0.5], "Edge": [0.15, 0.25]},
    },
    "sound": {
        "spectrum": "smc_s_016_2014_min_third.csv",
        "oaspl_db": 150,
        "field": "diffuse",
        "speed_m_s": 343,
    },
    "response": {"frequency_hz": [40, 150]},
    "scenarios": {
        "fill": {"patch": "PID-1", "damper": LAWS, "fill_fraction": [0.3, 0.8]},
        "place": {"patch": ["PID-1", "Left wing"], "damper": LAWS, "fill_fraction": 0.5},
        "level": {"patch": "PID-1", "damper": LAWS, "fill_fraction": 0.5, "oaspl_db": [140, 150]},
    },
}
"""As YAML holds it. No case has a label twice; the printed law feeds the panel."""

TABLE_ROWS = [
    "fill_fraction,frequency_hz,acceleration_g,equivalent_damping_n_s_m3,"
    "equivalent_damping_error_n_s_m3,apparent_mass_kg_m2,apparent_mass_error_kg_m2,"
    "particle_mass_per_area_kg_m2"
] + [
    f"{r},{f},{g},{r * f * (20 / g) ** 0.5:.4f},{0.03 * r * f:.4f},{4 * r / g**0.2:.4f},0.02,{12 * r}"
    for r in (0.3, 0.5, 0.8)
    for f in (40, 80, 150)
    for g in (3, 30, 300)
]


@pytest.fixture(scope="session")
def law_values():
    """The values of a study with the paper's law, to be changed freely."""
    return lambda: copy.deepcopy(LAW)


def _written(folder: Path, name: str, values) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "lab.csv").write_text("\n".join(TABLE_ROWS) + "\n")
    (folder / "limit.csv").write_text("frequency_hz,acceleration_psd_g2_hz\n40,0.5\n150,0.5\n")
    (folder / "test.csv").write_text(
        "frequency_hz,acceleration_psd_g2_hz\n30,0.01\n60,2\n140,0.5\n"
    )
    path = folder / f"{name}.yaml"
    path.write_text(yaml.safe_dump(values, sort_keys=False))
    return path


@pytest.fixture(scope="session")
def write_study():
    """(folder, name, values) → the file of a study, ``lab.csv`` with a table beside it."""
    return _written


@pytest.fixture(scope="session")
def table_values(law_values):
    """The values of the same study with a table of measured damping, ``lab.csv``."""

    def values():
        found = law_values()
        found["dampers"] = {"lab": {"table": "lab.csv"}}
        for scenario in found["scenarios"].values():
            del scenario["damper"]
        strength = dict.fromkeys(("tension_1", "compression_1", "tension_2", "compression_2"), 300)
        found["severity"] = {
            "fatigue": {"stress_mpa": 100, "exponent": 6},
            "strength": {
                "layers": {f"{key}_mpa": value for key, value in {**strength, "shear": 170}.items()}
            },
        }
        found["limits"] = {"centre": {"psd": "limit.csv", "rms_g": 20}}
        found["measurements"] = {"shaker 7": {"file": "test.csv", "point": "centre"}}
        return found

    return values
