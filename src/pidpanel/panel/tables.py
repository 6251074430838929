"""Tables of the modes and of the section of a panel."""

import numpy as np
import pandas as pd

from pidpanel.panel import navier
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.section import SandwichSection, Section, ThinSection


def mode_table(
    basis: PanelBasis, size: tuple[float, float] | None, section: Section | None
) -> pd.DataFrame:
    """Return the modes with their frequencies and the closed form where there is one.

    For a simply supported rectangle of edge lengths ``size`` [m] also m, n, share_of_sine, and
    navier_hz unless its section couples bending and twist.
    """
    count = int(np.sum(~basis.is_residual))
    table = pd.DataFrame(
        {
            "mode": range(1, count + 1),
            "frequency_hz": basis.natural_frequency[:count],
            "modal_mass_kg": basis.modal_mass[:count],
        }
    )
    if size is None or section is None:
        return table
    orders, share = navier.mode_orders(basis, size)
    m, n = orders.T
    table.insert(1, "m", m)
    table.insert(2, "n", n)
    table["share_of_sine"] = share
    if isinstance(section, ThinSection):
        table.insert(4, "navier_hz", navier.thin_plate_frequency(m, n, size, section))
    elif navier.is_aligned(section):
        table.insert(4, "navier_hz", navier.shear_plate_frequency(m, n, size, section))
    return table


def section_table(section: Section | None, area: float, mass: float) -> pd.DataFrame:
    """Return matrices and masses of a section, an area [m²] and a mass [kg], entry by entry.

    Without a section, as of modes from a file, only the masses.
    """
    entries: list[tuple[str, np.ndarray | float, str]] = []
    if isinstance(section, SandwichSection):
        A, B, D = section.abd
        # what rounding leaves of the coupling of symmetric faces is none
        B = np.where(np.abs(B) < 1e-12 * np.sqrt(A.max() * D.max()), 0.0, B)
        entries += [("A", A, "N/m"), ("B", B, "N"), ("D", D, "N m")]
    if section is not None:
        entries.append(("bending", section.bending, "N m"))
        if not isinstance(section, ThinSection):
            entries += [
                ("shear", section.shear, "N/m"),
                ("rotary_inertia", section.rotary_inertia, "kg"),
            ]
    entries += [("mass_per_area", mass / area, "kg/m2"), ("area", area, "m2"), ("mass", mass, "kg")]
    rows = []
    for name, value, unit in entries:
        if isinstance(value, float):
            rows.append((name, 0, 0, value, unit))
        else:
            rows += [(name, i + 1, j + 1, v, unit) for (i, j), v in np.ndenumerate(value)]
    return pd.DataFrame(rows, columns=["quantity", "row", "column", "value", "unit"])
