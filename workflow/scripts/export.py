"""PSDs for other programs: CSV per scenario, third octaves, Nastran TABRND1, UFF 58."""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.response.export import Curve, third_octave_rows, write_tabrnd1, write_uff58
from pidpanel.study import load_study

if __name__ == "__main__":
    study_path, psd_nc, folder = sys.argv[1:]
    study = load_study(study_path)
    folder = Path(folder)
    folder.mkdir(exist_ok=True)
    with xr.open_dataset(psd_nc, engine="scipy") as dataset:
        psd = dataset.load()
    frequency = psd["frequency"].to_numpy()
    points = [str(name) for name in psd["point"].to_numpy()]
    bare_of = {s.label: s.bare.label for s in study.all_scenarios()}
    curves, bare = [], {}
    for reading in study.damping.readings:
        for label in bare_of:
            one = psd.sel(reading=reading, scenario=label)
            if np.isnan(one["acceleration_psd"]).any():
                continue  # no steady response
            columns = {"frequency_hz": frequency}
            for node, point in enumerate(points, start=1):
                here = one.sel(point=point)
                acceleration = here["acceleration_psd"].to_numpy()
                under = psd["acceleration_psd"].sel(scenario=bare_of[label], point=point)
                bare[label, point] = under.sel(reading=reading).to_numpy()
                curves.append(Curve(reading, label, point, node, acceleration))
                columns |= {
                    f"acceleration_psd_g2_hz_{point}": acceleration / STANDARD_GRAVITY**2,
                    f"velocity_psd_m2_s2_hz_{point}": here["velocity_psd"].to_numpy(),
                    f"displacement_psd_mm2_hz_{point}": here["displacement_psd"].to_numpy() * 1e6,
                }
            name = f"psd_{reading}_{label}.csv"
            pd.DataFrame(columns).to_csv(folder / name, index=False, float_format="%.7g")
    title = f"pidpanel study {study.name}"
    third_octave_rows(frequency, curves, bare).to_csv(
        folder / "third_octaves.csv", index=False, float_format="%.6g"
    )
    write_tabrnd1(folder / "tabrnd1.bdf", frequency, curves, title)
    write_uff58(folder / "psd.uff", frequency, curves, title)
