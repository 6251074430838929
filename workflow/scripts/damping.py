"""From cases.csv to the surface: damping/surface.nc, damping/surface.csv."""

import sys
from pathlib import Path

import pandas as pd

from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.tables import to_frame
from pidpanel.stamp import stamp
from pidpanel.study import load_study

if __name__ == "__main__":
    study_path, cases, surface_nc, surface_csv = sys.argv[1:]
    study = load_study(study_path)
    surface = DampingSurface.from_frame(
        pd.read_csv(Path(cases), keep_default_na=True), onset_g=study.coupon.gravity_g
    )
    surface.to_dataset().assign_attrs(stamp(study)).to_netcdf(surface_nc, engine="scipy")
    to_frame(surface).to_csv(surface_csv, index=False, float_format="%.6g")
