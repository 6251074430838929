"""A launch spectrum of one's own: a table of band levels, written here and read by the study."""

import tempfile
from pathlib import Path

import numpy as np

import pidpanel

folder = Path(tempfile.mkdtemp())
bands = {100: 125, 125: 127, 160: 129, 200: 130, 250: 130, 315: 129, 400: 128}
rows = "\n".join(f"{center},{level}" for center, level in bands.items())
(folder / "mine.csv").write_text(f"center_hz,spl_db\n{rows}\n")

model = pidpanel.Model(
    {
        "panel": {
            "outline_m": [0.8, 0.5],
            "section": {"kind": "thin", "mass_per_area_kg_m2": 4, "bending_stiffness_n_m": 800},
            "damping_ratio": 0.01,
            "mesh": {"kind": "quadrilaterals", "elements": [16, 10]},
            "patches": {},
            "points": {"P": [0.4, 0.25]},
        },
        "sound": {"spectrum": "mine.csv", "field": "diffuse", "surroundings": "free"},
        "response": {"frequency_hz": [90, 400]},
    },
    folder,
)
sound = model.sound()
overall = 10 * np.log10((10 ** (sound["band_spl"] / 10)).sum())
print(f"{float(overall):.1f} dB overall")
psd = model.response()["acceleration_psd"].sel(point="P").squeeze("scenario")
print(f"the highest PSD is at {float(psd['frequency'][psd.argmax('frequency')]):.0f} Hz")
