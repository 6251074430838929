"""Made-up results of the stage ``response``, as its files hold them."""

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.solve.stress import QUANTITIES


def responses(study, scale, read_at=np.nan, inside=1.0, error_db=np.nan):
    """Summary and PSDs: flat, ``scale`` (dB against bare) by label.

    ``error_db`` is the standard error of every level but those of the bare panel.
    Dampers of the name `printed` have no response.
    """
    frequency = np.geomspace(100, 400, 200)
    labels = [s.label for s in study.all_scenarios()]
    points = list(study.panel.points)
    shape = (len(labels), len(frequency))
    acceleration = np.full((*shape, len(points)), np.nan)
    rows = []
    for j, scenario in enumerate(study.all_scenarios()):
        level = 10 ** ((scenario.oaspl_db - 150) / 10)
        for k, point in enumerate(points):
            lowered = scale.get((scenario.label, point), 0.0)
            row = {"scenario": scenario.label, "point": point, "damping_source": "a law"}
            if "printed" in scenario.dampers:
                rows.append({**row, "status": "unstable"})
                continue
            acceleration[j, :, k] = 1e4 * level * 10 ** (-lowered / 10)
            rms = np.sqrt(300 * acceleration[j, 0, k])
            rows.append(
                {
                    **row,
                    "status": "ok",
                    "acceleration_rms_g": rms / 9.80665,
                    "displacement_rms_mm": 1.0,
                    "acceleration_rms_error_g": rms / 9.80665 * np.log(10) / 20 * error_db,
                    "oaspl_db": scenario.oaspl_db,
                    "reduction_db": lowered,
                    "reduction_error_db": np.nan if scenario.is_bare else error_db,
                    "damping_read_at_g": np.nan if scenario.patch is None else read_at,
                    "outside_run_points_share": 0.0 if scenario.patch is None else 1 - inside,
                    "extrapolated_share": 0.0 if scenario.patch is None else 1 - inside,
                    "between_share": 0.0,
                    "data_missing": "" if scenario.patch is None else "dem to 61 g",
                    "levels": 1,
                    "doubts": "",
                    "beyond_linear_plate": False,
                    "power_balance_error": 1e-9,
                    "basis_error": 1e-3,
                    "mesh_error": 1e-2,
                    "mesh_error_rms": 1e-4,
                    "point_error_rms": 0.0,
                    "motion_residual": 0.0,
                    "added_mass_kg": 0.0 if scenario.is_bare else np.nan,
                    "added_mass_percent": 0.0 if scenario.is_bare else np.nan,
                    "dead_weight_acceleration_rms_g": np.nan,
                    "dead_weight_reduction_db": 0.0 if scenario.is_bare else np.nan,
                }
            )
    dims = ("scenario", "frequency")
    on_run_points = np.full(shape, 1.0)
    patches = list(study.panel.patches)
    by_patch = ("scenario", "patch", "frequency")
    on_run_points[:, : round((1 - inside) * len(frequency))] = 0.0
    psd = xr.Dataset(
        {
            "acceleration_psd": ((*dims, "point"), acceleration),
            "dead_weight_acceleration_psd": ((*dims, "point"), np.full_like(acceleration, np.nan)),
            "equivalent_damping": (by_patch, _on_every(patches, np.full(shape, 100.0))),
            "apparent_mass": (by_patch, _on_every(patches, np.zeros(shape))),
            "inside": (by_patch, _on_every(patches, on_run_points)),
            "acceleration_psd_log_error": (
                (*dims, "point"),
                np.full_like(acceleration, error_db * np.log(10) / 10),
            ),
        },
        coords={
            "frequency": frequency, "scenario": labels, "point": points, "patch": patches,
        },
    )  # fmt: skip
    return pd.DataFrame(rows), psd


def _on_every(patches, values):
    return np.repeat(values[:, None], len(patches), axis=1)


def rows_of_patches(summary):
    """``response/layouts.csv`` as far as the report asks it, from the summary."""
    of = summary[~summary["scenario"].str.startswith("bare")].drop_duplicates("scenario")
    of = of[["scenario", "damping_read_at_g", "outside_run_points_share"]]
    return of.assign(damper="law")


def strains(study):
    """``response/stress.csv`` of one layer, every rms value 1 in its unit."""
    shown = {q: "MPa" if unit == "Pa" else "microstrain" for q, unit in QUANTITIES.items()}
    return pd.DataFrame(
        [
            {
                "scenario": scenario.label,
                "layer": "top and bottom",
                "point": point,
                "quantity": quantity,
                "unit": unit,
                "rms": 1.0,
                "three_sigma": 3.0,
            }
            for scenario in study.all_scenarios()
            for point in study.panel.points
            for quantity, unit in shown.items()
        ]
    )
