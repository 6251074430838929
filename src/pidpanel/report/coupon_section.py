"""The coupon on the page: its spheres, how steady the runs are, what came out of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from pidpanel.coupon.geometry import cell_centres
from pidpanel.coupon.shapes import SHAPES
from pidpanel.damping.laws import paper_corrected
from pidpanel.report import figures, pictures, style, tables
from pidpanel.report.evidence import Beads
from pidpanel.report.html import Block, Paragraph, Picture, Section
from pidpanel.report.inputs import Coupon
from pidpanel.report.losses import losses_picture
from pidpanel.study import Study

CELLS_SHOWN = 5
"""Cells of a picture at the most: more would be too small to see a sphere."""


def coupon_section(study: Study, coupon: Coupon) -> Section:
    """The spheres, how steady the runs are, and what came out of them."""
    cases = coupon.cases
    good = cases[cases["status"] == "ok"].copy()
    mass = good["particle_mass_per_area_kg_m2"]
    good["apparent_mass_share"] = good["apparent_mass_kg_m2"] / mass
    good["apparent_mass_share_error"] = good["apparent_mass_error_kg_m2"] / mass
    relative = good["equivalent_damping_error_n_s_m3"] / good["equivalent_damping_n_s_m3"].abs()
    law = paper_corrected if "paper_corrected" in study.damping.readings else None
    law_text = (
        " Dashed: the paper's law, corrected (|a₁|, f in Hz), which knows no Γ." if law else ""
    )
    bound_text = (
        " Dotted: C_e = 4 m″ω/π, the most that a perfectly inelastic bed of this mass without "
        "gravity can give."
    )
    bars = (
        "Bars: one standard error, from the scatter of the cycles and between seeds. Cases that "
        "are not ok are left out."
    )
    F, G = figures.FREQUENCY, figures.LEVEL
    drawn: list[tuple[str, Any, str]] = [
        (
            "damping_over_frequency",
            figures.sweep_figure(
                good, F, figures.EQUIVALENT_DAMPING, G, law=law, bound="bound_n_s_m3"
            ),
            f"Equivalent damping per area over frequency at constant Γ. {bars}{law_text}"
            f"{bound_text}",
        ),
        (
            "damping_over_level",
            figures.sweep_figure(
                good, G, figures.EQUIVALENT_DAMPING, F, law=law, bound="bound_n_s_m3"
            ),
            f"The same over the acceleration amplitude at constant frequency. {bars}{law_text}"
            f"{bound_text}",
        ),
        (
            "loss_factor",
            figures.sweep_figure(good, G, figures.LOSS_FACTOR, F),
            "Loss factor η = E_d/(π m″(ωW)²) over the acceleration amplitude; the inelastic bound "
            f"is 4/π = 1.27. {bars}",
        ),
        (
            "apparent_mass",
            figures.sweep_figure(good, G, figures.MASS_SHARE, F),
            "Share of the spheres' mass that moves in phase with the cell (apparent mass over "
            f"mass, both per area). {bars}",
        ),
    ]
    blocks: list[Block] = [
        Paragraph(
            f"{len(cases)} cases, {len(good)} of them ok; the median standard error of C_e is "
            f"{relative.median():.1%}, the largest {relative.max():.0%}."
        ),
        beads_block(coupon.beads),
        Picture(
            "steadiness",
            style.png(figures.steadiness_figure(coupon.records)),
            "Energy dissipated per cycle and area in a few runs, cycle by cycle. Dotted: end of "
            "the transient, found from the data (marginal standard error); band: mean of the "
            "cycles after it ± one standard error (blocking; where 60 cycles and more follow, "
            "without what the bed stores in one cycle and gives back in the next).",
        ),
        *(Picture(name, style.png(figure), caption) for name, figure, caption in drawn),
        *([losses] if (losses := losses_picture(good)) else []),
        tables.case_table(cases),
    ]
    return Section("coupon", "Coupon", blocks)


def beads_block(beads: Beads) -> Picture:
    """Picture of the spheres of one run in its first cells."""
    packing = beads.run.packing
    shown = min(packing.count, CELLS_SHOWN)
    centres = cell_centres(packing.across_flats, packing.count)
    own = np.linalg.norm(beads.positions[:, None, :2] - centres, axis=2).argmin(axis=1)
    inside = own < shown
    places = beads.positions[inside]
    # from the grid of all cells to the grid of those shown
    places[:, :2] += (cell_centres(packing.across_flats, shown) - centres[:shown])[own[inside]]
    side = "set side by side for the picture"
    if shown < packing.count:
        side = f"{shown} of them {side}"
    limits = (0.0, float(beads.speed.max()))
    shape = SHAPES[packing.shape].word
    where = (
        f"{len(beads.positions)} spheres of {packing.diameter * 1e3:g} mm in {packing.count} "
        f"{shape} cells of {packing.across_flats * 1e3:g} mm × {packing.depth * 1e3:g} mm "
        f"({side}), r = {beads.run.fill_fraction:g}, "
        f"{beads.run.drive.frequency:g} Hz, "
        f"Γ = {beads.run.drive.gamma:.4g} ({beads.label})."
    )
    caption = f"{where} State after {beads.cycles} cycles; colour: speed relative to the cell."
    image = pictures.beads_picture(
        places,
        beads.diameters[inside],
        beads.speed[inside],
        limits,
        outline=packing.outline,
        across_flats=packing.across_flats,
        depth=packing.depth,
        count=shown,
    )
    figure = figures.pictures_figure(
        [image],
        [""],
        columns=1,
        colormap="plasma",
        limits=limits,
        label="speed relative to the cell, m/s",
        width=6.0,
    )
    return Picture("beads", style.png(figure), caption)
