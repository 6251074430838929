"""Heavy, large and several dampers on a panel, held to all elements and to what must be equal."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import scipy.linalg as la

from pidpanel.arrays import Array
from pidpanel.geometry.polygon import Rectangle
from pidpanel.panel.section import ThinSection
from pidpanel.solve.power import power_balance
from pidpanel.verification import panel_equal
from pidpanel.verification.response_panel import (
    HIGHEST,
    LINES,
    POINTS,
    RAYLEIGH,
    SECTION,
    SIZE,
    TRUNCATION,
    Damper,
    Studied,
    papers_panel,
)
from pidpanel.verification.rows import Row


def damper_rows(folder: Path) -> list[Row]:
    """Return a strong, heavy damper to 2 kHz: shapes, all elements, the power."""
    case = "Panel with a damper in a diffuse field: shapes against all elements"
    patches = {"P": Rectangle((0.75, 0.5), (0.2, 0.2))}
    panel = papers_panel(folder, patches, [], limit=4000.0)
    frequency = np.array([60.0, 300.0, 1000.0, 1600.0, 1900.0, 2000.0])
    force = panel.force(frequency)
    rows = []
    for line, f in enumerate(frequency.tolist()):
        damper = Damper(3000 * np.sqrt(f / 100), 5.0)
        own, field = frequency[line : line + 1], force[line : line + 1]
        found = panel.psd(own, field, {"P": damper})[0]
        full = panel.psd_of_elements(f, {"P": damper})
        rows += [
            Row(
                case, f"displacement PSD {name}, {f:g} Hz", float(one), float(other), "m2/Pa2",
                TRUNCATION, f"{len(panel.ratio)} modes and residual vectors",
                "sparse solve of all coordinates; tolerance: what the documents promise", at=f,
            )
            for name, one, other in zip(POINTS, found, full, strict=True)
        ]  # fmt: skip
        balance = power_balance(
            own, panel.modal, panel.patches(["P"]), np.ones(1), field,
            np.array([[damper.damping]]), np.array([[damper.mass]]),
        )  # fmt: skip
        lost = balance.structure + balance.patches.sum(axis=1)
        rows.append(
            Row(
                case, f"power lost in panel and damper, {f:g} Hz", float(lost[0]),
                float(balance.field[0]), "W/Pa2", 1e-6, "low-rank solve",
                "power put in by the field, dense solve; tolerance: columns of the overlap below "
                "1e-8 are dropped", at=f,
            )
        )  # fmt: skip
    return rows


HEAVY = {
    "1.4 m × 0.85 m": (Rectangle((0.75, 0.475), (1.4, 0.85)), (30.0, 14.0)),
    "1.0 m × 0.7 m": (Rectangle((0.75, 0.5), (1.0, 0.7)), (30.0,)),
    "whole panel": (Rectangle((0.75, 0.5), SIZE), (150.0, 65.0)),
    "0.2 m × 0.2 m": (Rectangle((0.75, 0.5), (0.2, 0.2)), (150.0,)),
}
"""Patches and the mass per area on them [kg/m²], the heaviest first: acrylic, steel, tungsten."""


def heavy_rows(folder: Path) -> list[Row]:
    """Return heavy and large dampers, C_e = 2000 N s/m³, in shapes beside all elements."""
    case = "Heavy and large dampers in a diffuse field: shapes against all elements"
    rows = []
    frequency = np.array(LINES)
    for name, (patch, masses) in HEAVY.items():
        layouts = [{"P": Damper(2000.0, mass)} for mass in masses]
        panel = papers_panel(folder, {"P": patch}, layouts)
        force = panel.force(frequency)
        for mass, dampers in zip((*masses, 0.0), (*layouts, {}), strict=True):
            found = panel.psd(frequency, force, dampers)
            told = f"{name}, {mass:g} kg/m²" if mass else f"basis of {name}, without damper"
            rows += _beside_elements(case, told, panel, dampers, found)
    return rows


def _beside_elements(
    case: str, told: str, panel: Studied, dampers: Mapping[str, Damper], found: Array
) -> list[Row]:
    """Return the worst point of each of `LINES` beside all elements."""
    rows = []
    for f, psd in zip(LINES, found, strict=True):
        full = panel.psd_of_elements(f, dampers)
        worst = int(np.argmax(np.abs(psd / full - 1)))
        rows.append(
            Row(
                case, f"{told}: displacement PSD {list(POINTS)[worst]}, {f:g} Hz",
                float(psd[worst]), float(full[worst]), "m2/Pa2", TRUNCATION,
                f"{len(panel.ratio)} shapes, the worst of {len(full)} points",
                "sparse solve of all coordinates; tolerance: what the documents promise", at=f,
            )
        )  # fmt: skip
    return rows


TOGETHER = {
    "PID-1": (Rectangle((0.75, 0.5), (0.2, 0.2)), Damper(3000.0, 30.0)),
    "PID-2": (Rectangle((0.1, 0.3), (0.2, 0.2)), Damper(800.0, 5.0)),
    "PID-4": (Rectangle((0.7, 0.45), (0.3, 0.3)), Damper(1500.0, 8.0)),
}
"""PID-4 overlaps PID-1."""
HALVES = {
    "left": Rectangle((0.70, 0.5), (0.1, 0.2)),
    "right": Rectangle((0.80, 0.5), (0.1, 0.2)),
}


def together_rows(folder: Path) -> list[Row]:
    """Return several dampers at once beside all elements, and halves beside a whole."""
    case = "Several dampers at once in a diffuse field"
    patches = {name: patch for name, (patch, _) in TOGETHER.items()} | HALVES
    dampers = {name: damper for name, (_, damper) in TOGETHER.items()}
    panel = papers_panel(folder, patches, [dampers])
    frequency = np.array(LINES)
    force = panel.force(frequency)
    rows = []
    for told, names in (
        ("two dampers", ["PID-1", "PID-2"]),
        ("two that overlap, and a third", list(dampers)),
    ):
        on = {name: dampers[name] for name in names}
        rows += _beside_elements(case, told, panel, on, panel.psd(frequency, force, on))
    whole = panel.psd(frequency, force, {"PID-1": dampers["PID-1"]})
    halves = panel.psd(frequency, force, dict.fromkeys(HALVES, dampers["PID-1"]))
    half = Damper(dampers["PID-1"].damping, 0.0)
    other = Damper(0.0, dampers["PID-1"].mass)
    # the same patch twice, once with the damping and once with the mass
    mesh_of_two = papers_panel(
        folder,
        {"damping": TOGETHER["PID-1"][0], "mass": TOGETHER["PID-1"][0]},
        [{"damping": half, "mass": other}],
    )
    force_of_two = mesh_of_two.force(frequency)
    split = mesh_of_two.psd(frequency, force_of_two, {"damping": half, "mass": other})
    joined = mesh_of_two.psd(frequency, force_of_two, {"mass": Damper(half.damping, other.mass)})
    for told, one, reference in (
        ("two halves for one patch", halves, whole),
        ("damping and mass apart for one damper", split, joined),
    ):
        for f, psd, known in zip(LINES, one, reference, strict=True):
            worst = int(np.argmax(np.abs(psd / known - 1)))
            rows.append(
                Row(
                    case, f"{told}: displacement PSD {list(POINTS)[worst]}, {f:g} Hz",
                    float(psd[worst]), float(known[worst]), "m2/Pa2", 1e-6,
                    f"{len(panel.ratio)} shapes", "the one patch with one damper; tolerance: "
                    "columns of the overlap below 1e-8 are dropped", at=f,
                )
            )  # fmt: skip
    return rows


def everywhere_rows(folder: Path) -> list[Row]:
    """Return mass all over the panel beside a panel that is heavier by it.

    M + m_a D = (1 + m_a/m″) M: the modes are the same, their frequencies fall by √(1 + m_a/m″),
    and so does the damping ratio, since C stays.
    """
    case = "Mass on the whole panel: a heavier panel"
    rows = []
    mass = 6.0
    times = 1 + mass / SECTION.mass_per_area
    patch = Rectangle((0.75, 0.5), SIZE)
    # as many modes in both
    loaded = papers_panel(folder, {"P": patch}, [], SECTION, 2 * HIGHEST * np.sqrt(times))
    heavier = ThinSection(SECTION.bending_stiffness, SECTION.mass_per_area * times)
    heavy = papers_panel(folder, {"P": patch}, [], heavier)
    omega = 2 * np.pi * np.sqrt(times) * heavy.basis.natural_frequency
    ratio = (RAYLEIGH[0] / (2 * omega) + RAYLEIGH[1] * omega / 2) / np.sqrt(times)
    heavy = Studied(heavy.plate, heavy.basis, ratio)

    own = loaded.modal.modal_mass * loaded.modal.angular_frequency**2
    total = np.diag(loaded.modal.modal_mass) + mass * loaded.basis.patch_overlap[0]
    found = np.sqrt(la.eigh(np.diag(own), total, eigvals_only=True)) / (2 * np.pi)
    for k in range(8):
        rows.append(
            Row(
                case, f"frequency {k + 1} with 6 kg/m² everywhere", float(found[k]),
                float(heavy.basis.natural_frequency[k]), "Hz", 1e-9, "shapes of the bare panel",
                "panel of 10 kg/m²; tolerance: rounding", at=k + 1,
            )
        )  # fmt: skip
    frequency = np.array(LINES)
    one = loaded.psd(frequency, loaded.force(frequency), {"P": Damper(0.0, mass)})
    other = heavy.psd(frequency, heavy.force(frequency), {"P": Damper(0.0, 0.0)})
    for f, psd, known in zip(LINES, one, other, strict=True):
        worst = int(np.argmax(np.abs(psd / known - 1)))
        rows.append(
            Row(
                case, f"displacement PSD {list(POINTS)[worst]} with 6 kg/m² everywhere, {f:g} Hz",
                float(psd[worst]), float(known[worst]), "m2/Pa2", 1e-6,
                f"{len(loaded.ratio)} shapes of the bare panel",
                "panel of 10 kg/m²; tolerance: columns of the overlap below 1e-8 are dropped", at=f,
            )
        )  # fmt: skip
    return rows


def equal_rows(folder: Path) -> list[Row]:
    """Return panels that are turned, mirrored or from a file, with a damper in a diffuse field."""
    case = "Panels that must be equal, with a damper in a diffuse field"
    frequency = np.array([200.0, 500.0, panel_equal.HIGHEST])
    damper = {"P": Damper(1500.0, 5.0)}
    rows = []
    for panels in (panel_equal.turned_panels, panel_equal.filed_panels):
        known: Array | None = None
        for equal in panels(folder):
            one, other = (Studied.rayleigh(None, basis) for basis in (equal.one, equal.other))
            if known is None:
                known = other.psd(frequency, other.force(frequency), damper)
            found = one.psd(frequency, one.force(frequency), damper)
            for f, psd, reference in zip(frequency.tolist(), found, known, strict=True):
                worst = int(np.argmax(np.abs(psd / reference - 1)))
                rows.append(
                    Row(
                        case, f"{equal.name}: displacement PSD {equal.one.point_names[worst]}, "
                        f"{f:g} Hz", float(psd[worst]), float(reference[worst]), "m2/Pa2", 1e-5,
                        f"{len(one.ratio)} shapes", "the panel as drawn; tolerance: plane waves "
                        "of the field from other directions", at=f,
                    )
                )  # fmt: skip
    return rows


CASES = {
    "damper": damper_rows,
    "equal": equal_rows,
    "heavy": heavy_rows,
    "together": together_rows,
    "everywhere": everywhere_rows,
}
"""Each computes in a folder and returns its rows."""
