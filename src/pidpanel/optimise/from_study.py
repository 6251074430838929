"""Proposed layouts of a study: the only module of the stage that reads it."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from pidpanel.arrays import Index
from pidpanel.base.from_study import shakers_of
from pidpanel.damping.from_study import dampers_of
from pidpanel.damping.models import FilledDamper
from pidpanel.geometry.plane_mesh import cell_areas
from pidpanel.optimise.excitations import ExcitedPanel, ShakerExcitedPanel, SoundExcitedPanel
from pidpanel.optimise.fidelity import (
    AGREED,
    DETAILED,
    FIDELITIES,
    Fidelity,
    first_fidelity,
    reduced,
)
from pidpanel.optimise.objectives import (
    Objective,
    accelerations,
    oscillators,
    spread_vertices,
    stresses,
)
from pidpanel.optimise.options import frozen_options
from pidpanel.optimise.places import (
    NoPlace,
    PlacedPanel,
    Places,
    listed_places,
    place_areas,
    place_name,
    place_plate,
    places_on,
    plate_with_points,
    with_points,
)
from pidpanel.optimise.proposal import EXCITATIONS, Proposals, layouts_to_confirm, search_table
from pidpanel.optimise.reduced_panel import JointPanel
from pidpanel.optimise.search import (
    Layout,
    Problem,
    Proof,
    Sampling,
    branch_and_bound,
    greedy,
    largest_difference,
    sample_submodularity,
)
from pidpanel.optimise.variants import damped_by_layer, reductions, thicker_faces
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.files import read_basis, read_plate
from pidpanel.panel.matrices import StoredPlate
from pidpanel.provenance.files import Files
from pidpanel.response.cases import ResponseScenario
from pidpanel.response.from_study import StudySound, read_panel_mass, read_response_panel
from pidpanel.response.results import write_csv
from pidpanel.severity.oscillators import natural_frequencies
from pidpanel.solve.model import ModalBasis
from pidpanel.solve.stress import distinct_layers
from pidpanel.structure.any_structure import AnyStructure
from pidpanel.structure.from_study import AnyPanel, read_moved_panel, studied
from pidpanel.study import Study
from pidpanel.study.mistakes import Mistake, not_among
from pidpanel.study.optimise import Optimise
from pidpanel.study.panel import MOST_CARRIED

NODES = 200  # layouts whose further dampers branch and bound evaluates at most


def section_of(study: Study) -> Optimise:
    """Return the section ``optimise``; `ValueError` without one."""
    if study.optimise is None:
        raise ValueError(f"{study.name}: no section optimise")
    return study.optimise


def places_of(study: Study) -> Places:
    """Return the places of a study, of a structure in its view; `NoPlace` without any."""
    section, panel = section_of(study), studied(study.panel)
    if section.patch_size_m is None or section.spacing is None:
        raise ValueError("places of a search among patches are those of the basis")
    forbidden = [area.shape for area in section.forbidden.values()]
    obstacles = [shapely.Polygon(shape.corners) for shape in forbidden if shape is not None]
    axes = panel.view[1] if isinstance(panel, AnyStructure) and panel.plane is None else None
    return places_on(
        _drawn_area(panel),
        section.patch_size_m,
        section.spacing,
        [*panel.obstacles, *obstacles],
        axes,
    )


def _drawn_area(panel: AnyPanel) -> BaseGeometry:
    """Return the area of a panel, or of a structure in its view [m]."""
    return panel.outline if isinstance(panel, AnyStructure) else panel.area


def fillings_of(study: Study, folder: Path | None) -> list[FilledDamper]:
    """Return every damper at every fill fraction, with a folder of the surfaces.

    On a structure they stand along its view: a curved one is not told place by place.
    """
    section, stated = section_of(study), study.damping.level.acceleration_g
    if isinstance(panel := studied(study.panel), AnyStructure):
        x, y, z = np.cross(*panel.view[1].T).tolist()
        turned = {name: damper.in_frame((x, y, z)) for name, damper in study.dampers.items()}
        study = study.model_copy(update={"dampers": turned})
    models = dampers_of(study, folder)
    return [
        FilledDamper(name, models[name], fill, stated)
        for name in study.placed_dampers
        for fill in (section.fill_fraction if study.dampers[name].needs_fill else (None,))
    ]


def mistakes_of_search(study: Study) -> Iterator[Mistake]:
    """Yield limits that no layout meets, places that are not there, dampers without a mass."""
    section, panel = section_of(study), studied(study.panel)
    area, patches = _drawn_area(panel), study.panel.patches
    for name in section.patches:
        if name not in patches:
            yield Mistake(("optimise", "patches"), not_among("patches", name, list(patches)))
            return
    for name, forbidden in section.forbidden.items():
        shape = forbidden.shape
        if shape is not None and not shapely.Polygon(shape.corners).intersects(area):
            yield Mistake(("optimise", "forbidden", name), "lies off the panel")
    try:
        least = _least_area(study, panel)
    except NoPlace as error:
        yield Mistake(("optimise", "patch_size_m"), str(error))
        return
    if set(study.coupons) & set(study.placed_dampers):
        return  # their mass is known once they are filled
    heaviest = MOST_CARRIED * panel.section.mass_per_area * panel.area.area
    if section.mass_kg > heaviest:
        message = f"must be at most {heaviest:.3g}, {MOST_CARRIED} times the mass of the panel"
        yield Mistake(("optimise", "mass_kg"), message)
    lightest = np.inf
    for filling in fillings_of(study, None):
        mass = filling.mass_per_area * least
        if not mass > 0:
            message = f"the mass of {filling.name} is not known, so no budget limits it"
            yield Mistake(("optimise", "dampers"), message)
            return
        lightest = min(lightest, mass)
    if lightest > section.mass_kg:
        message = f"the lightest patch weighs {lightest:.3g} kg; a larger budget, or smaller "
        yield Mistake(("optimise", "mass_kg"), f"{message}patches")


def _least_area(study: Study, panel: AnyPanel) -> float:
    """Return the area of the smallest place [m²]."""
    names = section_of(study).patches
    if not names:
        return float(places_of(study).area.min())
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "panel.msh"
        mesh = panel.mesh(path) if isinstance(panel, AnyStructure) else panel.mesh(path, {})
    area = cell_areas(mesh.vertices, mesh.cells)
    return min(float(area[mesh.patch_cells[name]].sum()) for name in names)


def _alternatives(
    study: Study, panels: Sequence[PlacedPanel], objective: Objective
) -> Callable[[float], tuple[float, float]]:
    """Return what a mass [kg] on the panel itself reduces [dB]; see `variants`."""
    layer, area = section_of(study).damping_layer, studied(study.panel).area.area

    def value(panel: PlacedPanel, modal: ModalBasis) -> float:
        coarse = FIDELITIES[0]._replace(rank=1)
        return float(reduced(panel, objective, coarse, modal=modal).bare.max())

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
        return stresses(counted, layers, 3 + layers.stress.shape[2])
    if section.objective == "oscillators" and section.band_hz is not None:
        return oscillators(counted, natural_frequencies(*section.band_hz), section.quality)
    if section.objective == "panel":
        return accelerations(np.arange(len(basis.point_names)))
    return accelerations(counted, is_largest=section.objective == "largest")


def _scenario(
    problem: Problem, fillings: Sequence[FilledDamper], number: int, layout: Layout
) -> ResponseScenario:
    """Return a layout as a scenario, labelled by its number."""
    options = problem.options
    filled: dict[str, FilledDamper] = {}
    for option in layout:
        filling, place = fillings[options.filling[option]], int(options.place[option])
        filled[place_name(place)] = replace(filling, stated_acceleration_g=None)
    return ResponseScenario(str(number), "bare", np.nan, 1.0, filled)


def counted_excitations(study: Study) -> list[str]:
    """Return the excitations of the search: sound, base or both, by default all of the study."""
    stated = section_of(study).excitation
    has = {"sound": study.sound is not None, "base": study.base and study.base.random is not None}
    return [name for name in EXCITATIONS if has[name] and stated in (None, name, "both")]


def excited_panels(study: Study, files: Files) -> dict[str, ExcitedPanel]:
    """Return the panel under each excitation of the search."""
    section = section_of(study)
    panels: dict[str, ExcitedPanel] = {}
    with_strains, basis = section.objective == "stress", read_basis(files.modes)
    further = _further_points(section, basis)
    basis = with_points(basis, further)
    for name in counted_excitations(study):
        if name == "sound":
            start = read_response_panel(study, files)
            start = replace(start, basis=basis, point_refinement_error=0.0)
            panels[name] = SoundExcitedPanel(start, StudySound(study), with_strains)
        else:
            shaker, mass = shakers_of(study)["random"], read_panel_mass(study, files.section)
            translation = read_moved_panel(study, files)[2].with_points(further)
            panels[name] = ShakerExcitedPanel(basis, shaker, mass, with_strains, translation)
    return panels


def _further_points(section: Optimise, basis: PanelBasis) -> Index:
    """Return the vertices that represent the panel if its whole response is minimised."""
    is_whole = section.objective == "panel"
    return spread_vertices(basis.vertex_position) if is_whole else np.zeros(0, np.int64)


class _Search(NamedTuple):
    """Places of a study and what may fill them."""

    section: Optimise
    excited: Mapping[str, ExcitedPanel]
    plate: StoredPlate
    places: Places
    fillings: Sequence[FilledDamper]
    objective: Objective

    @property
    def mass(self) -> float:
        """Largest mass of all dampers of a layout [kg]."""
        heaviest = max(filling.mass_per_area for filling in self.fillings)
        heaviest *= float(place_areas(self.plate).max())
        return min(self.section.mass_kg, self.section.patches_at_most * heaviest)

    def panels(self, static_tolerance: float) -> list[PlacedPanel]:
        """Return the panel with the places under each excitation."""
        entries = self.excited.values()
        return [entry.panel(self.plate, self.places, static_tolerance) for entry in entries]

    def joint(self, panels: Sequence[PlacedPanel], fidelity: Fidelity) -> JointPanel:
        """Return the panel of the search."""
        terms = self.objective, fidelity, self.fillings, self.mass
        return JointPanel(tuple(reduced(panel, *terms) for panel in panels))

    def problem(self, panels: Sequence[PlacedPanel], fidelity: Fidelity) -> Problem:
        """Return the problem with the damping frozen."""
        joint, section = self.joint(panels, fidelity), self.section
        lines, options = joint.frequency.size, frozen_options(joint, self.fillings)
        shapes = max(panel.modal.natural_frequency.size for panel in panels)
        print(
            f"search: {options.mass.size} dampers on {len(self.places.lower)} places, "
            f"{lines} lines, {shapes} shapes, {fidelity.rank} motions of each place",
            file=sys.stderr, flush=True,
        )  # fmt: skip
        return Problem(joint, options, self.places, section.mass_kg, section.patches_at_most)

    def on_places(self, plate: StoredPlate, used: Index) -> tuple[_Search, list[PlacedPanel]]:
        """Return the search on some places, and its panels with the static response to them."""
        places = self.places.subset(used)
        with_subset, _ = place_plate(plate, places, used.tolist())
        subset = self._replace(plate=with_subset, places=places)
        return subset, subset.panels(DETAILED.static_tolerance)


class _Result(NamedTuple):
    """A search, and its best layouts on their places alone with all details."""

    problem: Problem
    sampling: Sampling
    proof: Proof
    layouts: Sequence[Layout]
    subset: _Search
    details: Sequence[PlacedPanel]
    subproblem: Problem
    subset_layouts: Sequence[Layout]


def _searched(search: _Search, plate: StoredPlate) -> _Result:
    """Return the search at the first fidelity that agrees with the details of its layouts."""
    panels = search.panels(1.0)
    for level in range(first_fidelity(panels, search.fillings, search.mass), len(FIDELITIES)):
        fidelity = FIDELITIES[level]
        if fidelity.static_tolerance < 1:
            panels = search.panels(fidelity.static_tolerance)
        problem = search.problem(panels, fidelity)
        best, sampling = greedy(problem), sample_submodularity(problem)
        text = f"submodularity: {sampling.violations} of {sampling.checks} checks violated, at most"
        print(f"{text} by {sampling.largest:.2g} of the bare mean square", file=sys.stderr)
        proof = branch_and_bound(problem, best, sampling, NODES)
        layouts = layouts_to_confirm(problem, proof.layout)
        used = np.unique([problem.options.place[o] for layout in layouts for o in layout])
        subset, details = search.on_places(plate, used)
        subproblem, subset_layouts = problem.on_places(used, layouts)
        joint = subset.joint(details, DETAILED)
        options = frozen_options(joint, search.fillings)
        subproblem = replace(subproblem, panel=joint, options=options)
        error = largest_difference(problem, layouts, subproblem, subset_layouts)
        print(
            f"the search differs by up to {error:.2f} dB from all details of its layouts",
            file=sys.stderr, flush=True,
        )  # fmt: skip
        for part in (*problem.panel.parts, *joint.parts):
            part.clear()  # the confirmation needs the memory
        if error <= AGREED:
            break
    return _Result(problem, sampling, proof, layouts, subset, details, subproblem, subset_layouts)


def write_proposal(study: Study, files: Files, damping: Path | None, output: Files) -> None:
    """Write the proposed layouts of a study; ``damping`` is the folder of the surfaces."""
    section = section_of(study)
    fillings, excited = fillings_of(study, damping), excited_panels(study, files)
    basis = next(iter(excited.values())).basis
    names = section.patches
    places = listed_places(basis, names) if names else places_of(study)
    plate = read_moved_panel(study, files)[1] if "base" in excited else read_plate(files.plate)
    plate = plate_with_points(plate, _further_points(section, basis))
    with_places, area_error = place_plate(plate, places, range(len(places.lower)))
    points = list(basis.point_names[: len(study.panel.points)])
    counted = np.array([points.index(name) for name in section.points or points])
    objective = objective_of(section, basis, counted)
    search = _Search(section, excited, with_places, places, fillings, objective)
    result = _searched(search, plate)
    problem, layouts, subset = result.problem, result.layouts, result.subset
    scenarios = [_scenario(problem, fillings, *entry) for entry in enumerate(layouts)]
    finalists = {
        name: entry.confirm(panel, subset.plate, subset.places, scenarios)
        for (name, entry), panel in zip(excited.items(), result.details, strict=True)
    }

    def panel_with(factor: float) -> JointPanel:
        ratio = study.panel.modal_damping.times(factor)
        panels = [
            replace(panel, settings=replace(panel.settings, damping_ratio=ratio))
            for panel in result.details
        ]
        return subset.joint(panels, DETAILED)

    variants = reductions(result.subproblem, fillings, result.subset_layouts, panel_with)
    alternatives = _alternatives(study, subset.panels(1.0), objective)
    proposals = Proposals(
        problem, fillings, layouts, finalists, counted, objective, variants, alternatives
    )
    front = proposals.front_table()
    facts = search_table(problem, fillings, result.proof, result.sampling, front, area_error)
    write_csv(output.psd, proposals.psd_table(front, points), 5)
    write_csv(output.layouts, proposals.patch_table(front))
    write_csv(output.summary, proposals.point_table(front, points))
    write_csv(output.front, front.drop(columns="confirmed"))
    write_csv(output.search, facts, 8)
