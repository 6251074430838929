"""From cases.csv to damping/surface.nc."""

import sys
from pathlib import Path

import pandas as pd

from pidpanel.damping.surface import DampingTable
from pidpanel.stamp import stamp
from pidpanel.study import load_study

if __name__ == "__main__":
    study_path, cases, output = sys.argv[1:]
    study = load_study(study_path)
    table = DampingTable.from_frame(pd.read_csv(Path(cases), keep_default_na=True))
    table.to_dataset().assign_attrs(stamp(study)).to_netcdf(output, engine="scipy")
