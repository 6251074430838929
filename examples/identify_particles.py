"""A damper measured on a shaker: restitution, friction and fill fraction of its particles."""

import tempfile
from pathlib import Path

import pandas as pd

from pidpanel.cli import main

folder = Path(tempfile.mkdtemp())
# C_e and m_a at tones of a shaker, here of LIGGGHTS with e = 0.8, μ = 0.3 and r = 0.5
(folder / "tones.csv").write_text("""\
frequency_hz,acceleration_g,equivalent_damping_n_s_m3,apparent_mass_kg_m2
30,20,1478.7,4.456
80,4,1577.7,0.476
80,20,413.3,-0.165
250,4,3952.4,1.13
250,20,1374.2,-0.128
""")
(folder / "lab.yaml").write_text("""\
coupon:
  cell: {across_flats_mm: 6.35, depth_mm: 25}
  particles: {diameter_mm: 2, density_kg_m3: 1190}
fill_fraction: 0.5
measured: {file: tones.csv, relative_error: 0.03}
""")
main(["identify", str(folder / "lab.yaml"), "--directory", str(folder)])
results = folder / "results" / "lab" / "identify"
print(pd.read_csv(results / "summary.csv"))
print((results / "identified.yaml").read_text())
