"""Responses by patch: rows of ``layouts.csv``, and the damping of each patch."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from pidpanel.arrays import Array
from pidpanel.response.cases import ResponseScenario, SolvedCase
from pidpanel.response.panel import ResponsePanel
from pidpanel.solve.layout import LayoutResponse

# Columns of ``layouts.csv``.
PATCH_COLUMNS = (
    "reading", "scenario", "patch", "damper", "fill_fraction", "area_m2", "mass_kg",
    "damping_read_at_g", "patch_motion_g", "bare_patch_motion_g", "lowest_element_motion_g",
    "highest_element_motion_g", "outside_run_points_share",
)  # fmt: skip


def patch_rows(
    panel: ResponsePanel, case: SolvedCase, response: LayoutResponse
) -> list[dict[str, Any]]:
    """Return rows of ``layouts.csv`` of a case, one for each filled patch."""
    area = panel.load_area(response)
    masses = case.masses(area)
    rows = []
    for filling in case.scenario.fillings:
        patch = panel.basis.patch_names.index(filling.patch)
        loads = np.array([damper.patch == patch for damper in case.dampers])
        share = area[loads] / area[loads].sum()
        elements = response.cell_acceleration_g[loads]
        if panel.by_element:
            elements = response.patch_acceleration_g[loads]
        rows.append(
            {
                "patch": filling.patch,
                "damper": case.dampers[int(loads.argmax())].source,
                "fill_fraction": filling.fill_fraction,
                "area_m2": area[loads].sum(),
                "mass_kg": masses[loads].sum(),
                "damping_read_at_g": np.sqrt(share @ response.acceleration_g[loads] ** 2),
                "patch_motion_g": np.sqrt(share @ response.patch_acceleration_g[loads] ** 2),
                "bare_patch_motion_g": panel.bare_motion_g(case.bare, patch),
                "lowest_element_motion_g": elements.min(),
                "highest_element_motion_g": elements.max(),
                "outside_run_points_share": 1 - response.inside[loads].all(axis=0).mean(),
            }
        )
    return rows


def only_motion(
    panel: ResponsePanel,
    case: SolvedCase,
    response: LayoutResponse,
    scenarios: Sequence[ResponseScenario],
) -> tuple[float, float]:
    """Return Γ of the damping of a single patch, and of its motion; NaN for several patches.

    Of the bare panel it is the motion of the patch that is filled first in the study.
    """
    rows = patch_rows(panel, case, response)
    if len(rows) == 1:
        return rows[0]["damping_read_at_g"], rows[0]["patch_motion_g"]
    first = next((scenario.patches[0] for scenario in scenarios if scenario.patches), None)
    if rows or first is None:
        return np.nan, np.nan
    return np.nan, panel.bare_motion_g(case.bare, panel.basis.patch_names.index(first))


def damping_on_patches(
    panel: ResponsePanel, case: SolvedCase, response: LayoutResponse
) -> dict[str, Array]:
    """Return the damping of a response by patch of the panel, means over area of its loads.

    C_e, m_a and whether they are within the range of their data (n_patches, nf), by names of
    `tables.PSD_VARIABLES`; 0 where a patch is not filled.
    """
    count = len(panel.basis.patch_names)
    damping, mass = np.zeros((2, count, panel.frequency.size))
    inside = np.ones((count, panel.frequency.size))
    area = panel.load_area(response)
    patches = np.array([damper.patch for damper in case.dampers], dtype=np.int64)
    for patch in dict.fromkeys(patches.tolist()):
        loads = patches == patch
        share = area[loads] / area[loads].sum()
        damping[patch] = share @ response.equivalent_damping[loads]
        mass[patch] = share @ response.apparent_mass[loads]
        inside[patch] = response.inside[loads].all(axis=0)
    return {"equivalent_damping": damping, "apparent_mass": mass, "inside": inside}
