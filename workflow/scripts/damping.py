"""From cases.csv to the surface (.nc, .csv), the constants of the law, and the forms compared."""

import sys
from pathlib import Path

import numpy as np
import pandas as pd

from pidpanel.damping import fit, forms
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.tables import to_frame
from pidpanel.stamp import stamp
from pidpanel.study import load_study


def surface_of(study, cases):
    """Surface of the cases of a study; only gravity along the motion holds the bed down."""
    *_, along = np.array(study.coupon.gravity_direction) / np.hypot.reduce(
        study.coupon.gravity_direction
    )
    return DampingSurface.from_frame(cases, onset_g=study.coupon.gravity_g * abs(along))


if __name__ == "__main__":
    study_path, cases, surface_nc, surface_csv, law_csv, forms_csv = sys.argv[1:]
    study = load_study(study_path)
    surface = surface_of(study, pd.read_csv(Path(cases), keep_default_na=True))
    surface.to_dataset().assign_attrs(stamp(study)).to_netcdf(surface_nc, engine="scipy")
    to_frame(surface).to_csv(surface_csv, index=False, float_format="%.6g")
    law = fit.fit_levels(surface.cases).assign(form="paper")
    comparison, fits = forms.compare(surface, study.coupon.cell.depth)
    constants = [
        {"form": found.form.name, "constant": name, "value": value, "low": low, "high": high,
         "scatter": found.rms, "points": len(surface.cases)}
        for found in fits if found.form.name == "two_regimes"
        for name, value, low, high in zip(
            found.form.constants, found.constants, found.low, found.high, strict=True
        )
    ]  # fmt: skip
    pd.concat([law, pd.DataFrame(constants)]).to_csv(law_csv, index=False, float_format="%.6g")
    comparison.to_csv(forms_csv, index=False, float_format="%.5g")
