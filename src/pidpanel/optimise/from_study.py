"""Proposed layouts of a study: the only module of the stage that reads it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import shapely

from pidpanel.arrays import Array, Flags, Index
from pidpanel.damping.from_study import reading_of_damper
from pidpanel.damping.readings import DampingReading
from pidpanel.optimise.alternatives import damped_by_layer, thicker_faces
from pidpanel.optimise.finalists import confirm
from pidpanel.optimise.objectives import (
    Objective,
    accelerations,
    oscillators,
    spread_vertices,
    stresses,
)
from pidpanel.optimise.options import FilledDamper, frozen_options
from pidpanel.optimise.placed import PlacedPanel, placed, with_points
from pidpanel.optimise.places import NoPlace, Places, places_on
from pidpanel.optimise.proposal import Proposals, layouts_to_confirm, search_table
from pidpanel.optimise.reduced import ReducedPanel, reduced_panel
from pidpanel.optimise.search import Problem, branch_and_bound, greedy, sample_property
from pidpanel.optimise.variants import reductions
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.from_study import StudiedPanel
from pidpanel.panel.plate_files import read_plate
from pidpanel.paths import of_damper
from pidpanel.response.dampers import PatchDamper, PatchFilling
from pidpanel.response.from_study import PanelFiles, read_response_panel
from pidpanel.severity.oscillators import natural_frequencies
from pidpanel.solve.layout import DampingOfMotion
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.model import ModalBasis
from pidpanel.solve.stress import distinct_layers
from pidpanel.study import Study
from pidpanel.study.mistakes import Mistake
from pidpanel.study.optimise import Optimise

LINES_PER_BANDWIDTH = 2.0
"""Of the search: g rms within 0.5 %, differences of layouts within 0.3 %."""

RANK = 4
"""Motions of each place in the search: g rms within 0.2 %."""

NODES = 200
"""Layouts whose further dampers branch and bound evaluates at most."""


class ProposalFiles(NamedTuple):
    """The files of the stage."""

    layouts_csv: Path
    front_csv: Path
    summary_csv: Path
    search_csv: Path
    psd_csv: Path


def section_of(study: Study) -> Optimise:
    """Return the section ``optimise``; `ValueError` without one."""
    if study.optimise is None:
        raise ValueError(f"{study.name}: no section optimise")
    return study.optimise


def places_of(study: Study) -> Places:
    """Return the places of a study; `NoPlace` without any."""
    section, panel = section_of(study), StudiedPanel(study.panel)
    forbidden = [area.shape for area in section.forbidden.values()]
    obstacles = [shapely.Polygon(shape.corners) for shape in forbidden if shape is not None]
    return places_on(
        panel.area, section.patch_size_m, section.spacing, [*panel.obstacles, *obstacles]
    )


def models_of(study: Study, folder: Path | None) -> dict[str, DampingReading]:
    """Return the damping models of the dampers to choose from.

    Parameters
    ----------
    folder
        Of the surfaces, ``results/<study>/damping``; None for a study without any.
    """
    models = {}
    for name in section_of(study).dampers or study.all_dampers:
        surface = None if folder is None else of_damper(folder, name, "surface.nc")
        model = reading_of_damper(study.all_dampers[name], surface)
        models[name] = model if study.response.damper_mass else model.without_mass()
    return models


def fillings_of(study: Study, models: Mapping[str, DampingReading]) -> list[FilledDamper]:
    """Return every damper at every fill fraction."""
    section, stated = section_of(study), study.damping.level.acceleration_g
    fillings = []
    for name, model in models.items():
        has_fill = study.all_dampers[name].is_of_a_fill
        for fill in section.fill_fraction if has_fill else (None,):
            damper = PatchDamper(0, 0, name, model, 1.0 if fill is None else fill)
            load = damper.load
            damping, follows = load.damping, load.depends_on_acceleration
            if stated is not None:
                damping, follows = _at(damper, stated), False
            fillings.append(FilledDamper(name, fill, damping, follows, damper.mass_per_area))
    return fillings


def _at(damper: PatchDamper, gamma: float) -> DampingOfMotion:
    """Return the damping at a stated Γ."""

    def damping(frequency: Array, _: float) -> tuple[Array, Array, Flags]:
        return damper.load.damping(frequency, gamma)

    return damping


def mistakes_of_search(study: Study) -> Iterator[Mistake]:
    """Yield limits that no layout meets, places that are not there, dampers without a mass."""
    section, area = section_of(study), StudiedPanel(study.panel).area
    for name, forbidden in section.forbidden.items():
        shape = forbidden.shape
        if shape is not None and not shapely.Polygon(shape.corners).intersects(area):
            yield Mistake(("optimise", "forbidden", name), "lies off the panel")
    try:
        places = places_of(study)
    except NoPlace as error:
        yield Mistake(("optimise", "patch_size_m"), str(error))
        return
    names = section.dampers or study.all_dampers
    if any(study.all_dampers[name].coupon is not None for name in names):
        return  # their mass is known once they are filled
    lightest = np.inf
    for filling in fillings_of(study, models_of(study, None)):
        mass = filling.mass_per_area * places.area
        if not mass > 0:
            says = f"the mass of {filling.damper} is not known, so no budget limits it"
            yield Mistake(("optimise", "dampers"), says)
            return
        lightest = min(lightest, mass)
    if lightest > section.mass_kg:
        says = f"the lightest patch weighs {lightest:.3g} kg; a larger budget, or smaller patches"
        yield Mistake(("optimise", "mass_kg"), says)


def _reduced(
    panel: PlacedPanel, objective: Objective, modal: ModalBasis | None = None, rank: int = RANK
) -> ReducedPanel:
    """Return the panel of a search, with what counts; with other modes where given."""
    settings = panel.settings
    lines = frequency_grid(
        *settings.frequency_range,
        settings.damping_ratio.least(*settings.frequency_range),
        lines_per_bandwidth=LINES_PER_BANDWIDTH,
    )
    return reduced_panel(
        lines, modal or panel.modal, panel.patches, objective.rows(panel.motion_at_points),
        panel.excitation, panel.air, outputs=objective.outputs(lines), rank=rank,
    )  # fmt: skip


def _alternatives(
    study: Study, panel: PlacedPanel, objective: Objective, problem: Problem
) -> Callable[[float], tuple[float, float]]:
    """Return what a mass [kg] on the panel itself reduces [dB]; see `alternatives`."""
    layer, area = section_of(study).damping_layer, StudiedPanel(study.panel).area.area

    def reduction(modal: ModalBasis) -> float:
        bare, other = (
            float(problem.objective(_reduced(panel, objective, basis, rank=1).bare))
            for basis in (None, modal)
        )
        return float(10 * np.log10(bare / other))

    def alternatives(mass: float) -> tuple[float, float]:
        faces, damped = np.nan, np.nan
        share = mass / area / panel.mass_per_area
        if study.panel.section.kind == "thin":
            faces = reduction(thicker_faces(panel.modal, share))
        if layer is not None:
            loss_factor = layer.loss_factor * mass / area / layer.mass_per_area_kg_m2
            damped = reduction(damped_by_layer(panel.modal, share, loss_factor))
        return faces, damped

    return alternatives


def objective_of(section: Optimise, basis: PanelBasis, counted: Index) -> Objective:
    """Return what a study makes small.

    Parameters
    ----------
    basis
        With all points; those that stand for the panel come last.
    counted
        (n,) response points that count.
    """
    if section.objective == "stress":
        layers = distinct_layers(basis.layer_names, basis.layer_strain, basis.layer_stress)
        return stresses(counted, layers, 6)
    if section.objective == "oscillators" and section.band_hz is not None:
        return oscillators(counted, natural_frequencies(*section.band_hz), section.quality)
    if section.objective == "panel":
        return accelerations(np.arange(len(basis.point_names)))
    return accelerations(counted, is_largest=section.objective == "largest")


def _name(place: int) -> str:
    return f"place {place}"


def _filled(problem: Problem, fillings: Sequence[FilledDamper], option: int) -> PatchFilling:
    filling = fillings[problem.options.filling[option]]
    name = _name(int(problem.options.place[option]))
    return PatchFilling(name, filling.damper, filling.fill_fraction)


def write_proposal(
    study: Study, files: PanelFiles, plate_nc: Path, damping: Path | None, output: ProposalFiles
) -> None:
    """Write the proposed layouts of a study.

    Parameters
    ----------
    files, plate_nc
        Of the panel and sound stages.
    damping
        Folder of the surfaces; None for a study without any.
    """
    section, places, models = section_of(study), places_of(study), models_of(study, damping)
    fillings = fillings_of(study, models)
    start = read_response_panel(study, files, study.response.radiation)
    plate = read_plate(plate_nc)
    points, with_strains = list(start.basis.point_names), section.objective == "stress"
    if section.objective == "panel":
        vertices = spread_vertices(start.basis.vertex_position)
        start = replace(start, basis=with_points(start.basis, vertices))
    names = [_name(index) for index in range(len(places.lower))]
    panel, _, area_error = placed(start, plate, places, names, with_strains=with_strains)
    counted = np.array([points.index(name) for name in section.points or points])
    objective = objective_of(section, panel.basis, counted)
    reduced = _reduced(panel, objective)
    problem = Problem(
        reduced, frozen_options(reduced, fillings), places,
        section.mass_kg, section.patches_at_most, objective.is_largest,
    )  # fmt: skip
    best, sampling = greedy(problem), sample_property(problem)
    proof = branch_and_bound(problem, best, sampling.ratio, NODES)
    layouts = layouts_to_confirm(problem, proof.layout)
    used = np.unique([problem.options.place[option] for layout in layouts for option in layout])
    patches = [[_filled(problem, fillings, option) for option in layout] for layout in layouts]
    of_finalists, elements, _ = placed(
        start, plate, places.subset(used), [names[place] for place in used.tolist()],
        with_strains=with_strains,
    )  # fmt: skip
    finalists = confirm(of_finalists, elements, patches, models)
    few, layouts_of_few = problem.on_places(used, layouts)

    def panel_with(factor: float) -> ReducedPanel:
        ratio = study.panel.modal_damping.times(factor)
        varied = replace(of_finalists, settings=replace(start.settings, damping_ratio=ratio))
        return _reduced(varied, objective)

    few = replace(few, panel=panel_with(1.0))
    variants = reductions(few, fillings, layouts_of_few, panel_with)
    others = _alternatives(study, of_finalists, objective, problem)
    proposals = Proposals(
        problem, fillings, layouts, finalists, counted, objective, variants, others
    )
    front = proposals.front_table()
    proposals.psd_table(front, points).to_csv(output.psd_csv, index=False, float_format="%.5g")
    facts = search_table(problem, fillings, proof, sampling, front, area_error)
    print(
        f"submodularity: {sampling.violations} of {sampling.checks} checks violated, at most by "
        f"{sampling.largest:.2g} of the bare mean square",
        file=sys.stderr,
    )
    proposals.patch_table(front).to_csv(output.layouts_csv, index=False, float_format="%.6g")
    proposals.point_table(front, points).to_csv(
        output.summary_csv, index=False, float_format="%.6g"
    )
    front.drop(columns="confirmed").to_csv(output.front_csv, index=False, float_format="%.6g")
    facts.to_csv(output.search_csv, index=False, float_format="%.8g")
