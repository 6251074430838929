"""Proposed layouts of a study: the only module of the stage that reads it."""

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import shapely

from pidpanel.arrays import Array, Flags, Index
from pidpanel.base.from_study import shakers_of
from pidpanel.damping.from_study import atlas_model, damper_model
from pidpanel.damping.models import DampingModel
from pidpanel.optimise.excitations import ExcitedPanel, ShakerExcitedPanel, SoundExcitedPanel
from pidpanel.optimise.objectives import (
    Objective,
    accelerations,
    oscillators,
    spread_vertices,
    stresses,
)
from pidpanel.optimise.options import FilledDamper, frozen_options
from pidpanel.optimise.places import (
    NoPlace,
    PlacedPanel,
    Places,
    place_name,
    place_plate,
    places_on,
    with_points,
)
from pidpanel.optimise.proposal import EXCITATIONS, Proposals, layouts_to_confirm, search_table
from pidpanel.optimise.reduced_panel import JointPanel, ReducedPanel
from pidpanel.optimise.search import Layout, Problem, branch_and_bound, greedy, sample_submodularity
from pidpanel.optimise.variants import damped_by_layer, reductions, thicker_faces
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.files import read_basis, read_plate
from pidpanel.panel.from_study import StudiedPanel
from pidpanel.paths import of_damper
from pidpanel.provenance.job import Files
from pidpanel.response.cases import ResponseScenario
from pidpanel.response.dampers import DampingModels, PatchDamper, PatchFilling
from pidpanel.response.from_study import StudySound, read_panel_mass, read_response_panel
from pidpanel.response.results import write_csv
from pidpanel.severity.oscillators import natural_frequencies
from pidpanel.solve.base_motion import BaseExcitation
from pidpanel.solve.layout import DampingOfMotion
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.model import ModalBasis
from pidpanel.solve.stress import distinct_layers
from pidpanel.study import Study
from pidpanel.study.mistakes import Mistake
from pidpanel.study.optimise import Optimise
from pidpanel.study.panel import MOST_CARRIED

LINES_PER_BANDWIDTH = 2.0  # of the search: g rms within 0.2 %

RANK = 4  # motions of each place in the search: g rms within 0.2 %

NODES = 200  # layouts whose further dampers branch and bound evaluates at most


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


def models_of(study: Study, folder: Path | None) -> dict[str, DampingModel]:
    """Return the damping models of the dampers to choose from, with a folder of the surfaces."""
    models = {}
    for name in section_of(study).dampers or study.all_dampers:
        surface = None if folder is None else of_damper(folder, name, "surface.nc")
        coupon = study.atlas_coupons.get(name)
        if coupon is not None and name not in study.surfaces:
            model: DampingModel = atlas_model(coupon, is_broadband=True)
        else:
            model = damper_model(study.all_dampers[name], surface, study.damping.prior)
        models[name] = model if study.response.damper_mass else model.without_mass()
    return models


def fillings_of(study: Study, models: Mapping[str, DampingModel]) -> list[FilledDamper]:
    """Return every damper at every fill fraction."""
    section, stated = section_of(study), study.damping.level.acceleration_g
    fillings = []
    for name, model in models.items():
        has_fill = study.all_dampers[name].is_of_a_fill
        for fill in section.fill_fraction if has_fill else (None,):
            damper = PatchDamper(0, 0, name, model, 1.0 if fill is None else fill)
            load = damper.attached
            damping, follows = load.damping, load.depends_on_acceleration
            if stated is not None:
                damping, follows = _damping_at(damper, stated), False
            fillings.append(FilledDamper(name, fill, damping, follows, damper.mass_per_area))
    return fillings


def _damping_at(damper: PatchDamper, gamma: float) -> DampingOfMotion:
    """Return the damping at a stated Γ."""

    def damping(frequency: Array, _: float) -> tuple[Array, Array, Flags]:
        return damper.attached.damping(frequency, gamma)

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
    simulated = set(names) - set(study.atlas_coupons)
    if any(study.all_dampers[name].coupon is not None for name in simulated):
        return  # their mass is known once they are filled
    heaviest = MOST_CARRIED * StudiedPanel(study.panel).section.mass_per_area * area.area
    if section.mass_kg > heaviest:
        message = f"must be at most {heaviest:.3g}, {MOST_CARRIED} times the mass of the panel"
        yield Mistake(("optimise", "mass_kg"), message)
    lightest = np.inf
    for filling in fillings_of(study, models_of(study, None)):
        mass = filling.mass_per_area * places.area
        if not mass > 0:
            message = f"the mass of {filling.damper} is not known, so no budget limits it"
            yield Mistake(("optimise", "dampers"), message)
            return
        lightest = min(lightest, mass)
    if lightest > section.mass_kg:
        message = f"the lightest patch weighs {lightest:.3g} kg; a larger budget, or smaller "
        yield Mistake(("optimise", "mass_kg"), f"{message}patches")


def _joint(panels: Iterable[PlacedPanel], objective: Objective) -> JointPanel:
    return JointPanel(tuple(_reduced(panel, objective, panel.modal) for panel in panels))


def _reduced(
    panel: PlacedPanel, objective: Objective, modal: ModalBasis, rank: int = RANK
) -> ReducedPanel:
    """Return the panel of a search with some modes, and the outputs of its objective."""
    settings, excitation = panel.settings, panel.excitation
    if isinstance(excitation, BaseExcitation):
        ratio = modal.modal_mass / panel.modal.modal_mass  # forces of inertia go with the masses
        excitation = replace(excitation, force=ratio * excitation.force)
    lines = frequency_grid(
        *settings.frequency_range,
        settings.damping_ratio.smallest(*settings.frequency_range),
        jumps=settings.jumps,
        lines_per_bandwidth=LINES_PER_BANDWIDTH,
    )
    return ReducedPanel(
        lines, modal, panel.patches, objective.rows(panel.motion_at_points),
        excitation, panel.air, outputs=objective.outputs(lines), rank=rank,
    )  # fmt: skip


def _alternatives(
    study: Study, panels: Sequence[PlacedPanel], objective: Objective
) -> Callable[[float], tuple[float, float]]:
    """Return what a mass [kg] on the panel itself reduces [dB]; see `variants`."""
    layer, area = section_of(study).damping_layer, StudiedPanel(study.panel).area.area

    def value(panel: PlacedPanel, modal: ModalBasis) -> float:
        return float(_reduced(panel, objective, modal, rank=1).bare.max())

    def reduction(changed: Callable[[ModalBasis], ModalBasis]) -> float:
        ratios = [value(each, each.modal) / value(each, changed(each.modal)) for each in panels]
        return float(10 * np.log10(min(ratios)))

    def alternatives(mass: float) -> tuple[float, float]:
        faces, damped = np.nan, np.nan
        share = mass / area / panels[0].mass_per_area
        if study.panel.section.kind == "thin":
            faces = reduction(lambda modal: thicker_faces(modal, share))
        if layer is not None:
            loss_factor = layer.loss_factor * mass / area / layer.mass_per_area_kg_m2
            damped = reduction(lambda modal: damped_by_layer(modal, share, loss_factor))
        return faces, damped

    return alternatives


def objective_of(section: Optimise, basis: PanelBasis, counted: Index) -> Objective:
    """Return the objective of a study at some response points (n,).

    The points of the basis that represent the panel come last.
    """
    if section.objective == "stress":
        layers = distinct_layers(basis.layer_names, basis.layer_strain, basis.layer_stress)
        return stresses(counted, layers, 6)
    if section.objective == "oscillators" and section.band_hz is not None:
        return oscillators(counted, natural_frequencies(*section.band_hz), section.quality)
    if section.objective == "panel":
        return accelerations(np.arange(len(basis.point_names)))
    return accelerations(counted, is_largest=section.objective == "largest")


def _scenario(
    problem: Problem, fillings: Sequence[FilledDamper], number: int, layout: Layout
) -> ResponseScenario:
    """Return a layout as a scenario, labelled by its number."""
    options, filled = problem.options, []
    for option in layout:
        filling, place = fillings[options.filling[option]], int(options.place[option])
        filled.append(PatchFilling(place_name(place), filling.damper, filling.fill_fraction))
    return ResponseScenario(str(number), "bare", np.nan, 1.0, tuple(filled), None, np.nan)


def counted_excitations(study: Study) -> list[str]:
    """Return the excitations of the search: sound, base or both, by default all of the study."""
    stated = section_of(study).excitation
    has = {"sound": study.sound is not None, "base": study.base and study.base.random is not None}
    return [name for name in EXCITATIONS if has[name] and stated in (None, name, "both")]


def excited_panels(study: Study, files: Files) -> dict[str, ExcitedPanel]:
    """Return the panel under each excitation of the search."""
    section = section_of(study)
    panels: dict[str, ExcitedPanel] = {}
    with_strains = section.objective == "stress"
    for name in counted_excitations(study):
        if name == "sound":
            start = read_response_panel(study, files, study.response.radiation)
            basis = _with_vertices(section, start.basis)
            start = replace(start, basis=basis, point_refinement_error=0.0)
            panels[name] = SoundExcitedPanel(start, StudySound(study), with_strains)
        else:
            basis = _with_vertices(section, read_basis(files.modes))
            shaker, mass = shakers_of(study)["random"], read_panel_mass(study, files.section)
            panels[name] = ShakerExcitedPanel(basis, shaker, mass, with_strains)
    return panels


def _with_vertices(section: Optimise, basis: PanelBasis) -> PanelBasis:
    """Return a basis with points that represent the panel if its whole response is minimised."""
    if section.objective != "panel":
        return basis
    return with_points(basis, spread_vertices(basis.vertex_position))


def write_proposal(study: Study, files: Files, damping: Path | None, output: Files) -> None:
    """Write the proposed layouts of a study; ``damping`` is the folder of the surfaces."""
    section, places, models = section_of(study), places_of(study), models_of(study, damping)
    fillings, excited = fillings_of(study, models), excited_panels(study, files)
    plate = read_plate(files.plate)
    with_places, area_error = place_plate(plate, places, range(len(places.lower)))
    panels = [entry.panel(with_places, places) for entry in excited.values()]
    points = list(panels[0].basis.point_names[: len(study.panel.points)])
    counted = np.array([points.index(name) for name in section.points or points])
    objective = objective_of(section, panels[0].basis, counted)
    joint = _joint(panels, objective)
    problem = Problem(
        joint, frozen_options(joint, fillings), places, section.mass_kg, section.patches_at_most
    )
    best, sampling = greedy(problem), sample_submodularity(problem)
    proof = branch_and_bound(problem, best, sampling, NODES)
    layouts = layouts_to_confirm(problem, proof.layout)
    used = np.unique([problem.options.place[option] for layout in layouts for option in layout])
    scenarios = [_scenario(problem, fillings, *entry) for entry in enumerate(layouts)]
    stated = DampingModels(("stated",), {}, {"stated": models})
    few_places = places.subset(used)
    with_few, _ = place_plate(plate, few_places, used.tolist())
    finalists = {
        name: entry.confirm(with_few, few_places, scenarios, stated)
        for name, entry in excited.items()
    }
    few_panels = [entry.panel(with_few, few_places) for entry in excited.values()]
    subproblem, layouts_of_few = problem.on_places(used, layouts)

    def panel_with(factor: float) -> JointPanel:
        ratio = study.panel.modal_damping.times(factor)
        panels = [
            replace(panel, settings=replace(panel.settings, damping_ratio=ratio))
            for panel in few_panels
        ]
        return _joint(panels, objective)

    subproblem = replace(subproblem, panel=panel_with(1.0))
    variants = reductions(subproblem, fillings, layouts_of_few, panel_with)
    alternatives = _alternatives(study, few_panels, objective)
    proposals = Proposals(
        problem, fillings, layouts, finalists, counted, objective, variants, alternatives
    )
    front = proposals.front_table()
    facts = search_table(problem, fillings, proof, sampling, front, area_error)
    text = f"submodularity: {sampling.violations} of {sampling.checks} checks violated, at most by "
    print(f"{text}{sampling.largest:.2g} of the bare mean square", file=sys.stderr)
    write_csv(output.psd, proposals.psd_table(front, points), 5)
    write_csv(output.layouts, proposals.patch_table(front))
    write_csv(output.summary, proposals.point_table(front, points))
    write_csv(output.front, front.drop(columns="confirmed"))
    write_csv(output.search, facts, 8)
