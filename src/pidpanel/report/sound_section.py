"""The sound on the page: band levels and pressure PSD."""

from __future__ import annotations

import numpy as np
import pandas as pd

from pidpanel.report import style
from pidpanel.report.html import PageSection, Picture
from pidpanel.report.sound_figures import spectrum_figure

SHAPES = {
    "bands": "The PSD is constant in each band and integrates to the band's level.",
    "rows": "The PSD is straight between the rows on logarithmic axes; shown are third octaves.",
}
"""The PSD within a spectrum, by what its table has."""


def sound_section(
    bands: pd.DataFrame,
    spectrum: str,
    rows: str,
    frequency: tuple[float, float],
    *,
    assumed: bool = False,
) -> PageSection:
    """Return the spectrum of the sound, of a table of bands or of rows of PSD."""
    overall = 10 * np.log10(np.sum(10 ** (bands["band_spl_db"] / 10)))
    caption = (
        f"Sound spectrum used: {spectrum}, {overall:.1f} dB overall. {SHAPES[rows]} Grey: "
        "outside the response's frequency range."
    )
    if assumed:
        caption += " Its shape is an assumption: the paper's Fig. 2 is not recoverable."
    picture = Picture("spectrum", style.png(spectrum_figure(bands, *frequency)), caption)
    return PageSection("sound", "Sound", [picture])
