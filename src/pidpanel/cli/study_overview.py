"""What an engineer checks before a run: mass, first modes, level, points, cases, time."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from pidpanel.cli.remarks import tables_in_words, unusual
from pidpanel.coupon.from_study import distinct_cases
from pidpanel.geometry.cells import bulk_fraction
from pidpanel.study import CouponStudy, Filling, Scenario, Study
from pidpanel.study.base_motion import BaseMotion
from pidpanel.study.dampers import BedDamper
from pidpanel.study.panel import Panel
from pidpanel.study.scenarios import vector_text
from pidpanel.study.structure import Structure

if TYPE_CHECKING:  # slow to import; a study of the coupon or of the panel alone needs half of it
    from pidpanel.arrays import Array
    from pidpanel.panel.basis import PanelBasis
    from pidpanel.panel.from_study import StudiedPanel
    from pidpanel.panel.mesh import PanelMesh

MODES = 6  # number of natural frequencies listed
# Elements that are solved in about four seconds, by section and kind.
MOST_CELLS: Mapping[str, int] = {"thin triangles": 1100}
MOST_OF_OTHERS = 8000
COARSE = 1.05  # largest frequency of a coarser mesh over that of the study's
COARSER = 2.0  # edge length of a coarser mesh over that of the one before
CORNERS = 20.0  # edge length at re-entrant corners of a coarser mesh over that by default


class PanelEstimate(NamedTuple):
    """The panel meshed and solved for its first modes."""

    mesh: PanelMesh  # of the study
    coordinates: int  # free, scaled by elements to the mesh of the study
    rigid: int  # number of rigid-body modes
    frequency: Array | None  # (n,) first natural frequencies [Hz]; None if nothing was solved
    elements: int  # of the mesh that was solved
    basis: PanelBasis | None = None  # of these modes


def overview(study: CouponStudy, results: Path = Path("results")) -> str:
    """Return what a study is and takes, a line for each thing that is checked first.

    `StudyError` for coupled runs of a panel without modes; see `coupled.from_study.check_modes`.
    """
    lines: list[tuple[str, str]] = []
    if isinstance(study, Study) and isinstance(study.panel, Structure):
        lines += _of_structure(study, study.panel)
    elif isinstance(study, Study) and isinstance(study.panel, Panel):
        lines += _of_panel(study, study.panel, solve(study.panel))
    if times := list(_of_runs(study, results)):
        lines.append(("time", f"{'; '.join(times)} of CPU time in LIGGGHTS"))
    return "\n".join([summary(study), *(f"  {label:8} {text}" for label, text in lines)])


def _of_runs(study: CouponStudy, results: Path) -> Iterator[str]:
    """Yield how long the LIGGGHTS runs take that are not in a folder ``results``."""
    cases, folder = list(distinct_cases(study).values()), results / "coupon"
    left = [case for case in cases if not case.outcome_file(folder).exists()]
    if left:
        from pidpanel.coupon.estimate import PLAN, cpu_seconds

        time = _duration(PLAN + cpu_seconds(left, folder))
        yield f"{len(left)} of {len(cases)} coupon cases {time}"
    if isinstance(study, Study) and study.is_coupled:
        # two seconds of imports that other studies do not need
        from pidpanel.coupled.from_study import estimated_cpu_seconds

        yield f"coupled runs {_duration(estimated_cpu_seconds(study))} or more"


def summary(study: CouponStudy) -> str:
    """Return how many cases, runs and scenarios a study has."""
    cases = distinct_cases(study).values()
    text = f"{study.name}: {len(cases)} coupon cases, {sum(len(c.runs) for c in cases)} runs"
    if isinstance(study, Study):
        if not study.scenarios:
            return f"{text}; the bare panel alone"
        models = dict.fromkeys(
            text.source for case in study.all_scenarios() for text in study.model_texts(case)
        )
        text += f"; {len(study.all_scenarios())} scenarios, damping: {', '.join(models)}"
        if study.is_coupled:
            text += f"; panel and particles together in {len(study.coupled_scenarios())}"
        unused = [name for name in study.dampers if name not in study.used_dampers]
        if unused:
            text += f"; not used: dampers {', '.join(unused)}"
    return text


def solve(panel: Panel) -> PanelEstimate:
    """Mesh a panel and find its first natural frequencies, on a coarser mesh if it is large."""
    from pidpanel.panel.basis import basis_of
    from pidpanel.panel.from_study import StudiedPanel
    from pidpanel.panel.modes import first_modes
    from pidpanel.panel.shapes import Shapes

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "panel.msh"
        studied = StudiedPanel(panel)
        study_mesh = mesh = studied.mesh(file)
        cells_max = MOST_CELLS.get(f"{panel.section.kind} {mesh.cell_kind}", MOST_OF_OTHERS)
        while len(mesh.cells) > cells_max and panel.mesh.kind == "triangles":
            size = COARSER * panel.mesh.size_m
            if size > 30:
                break
            corner = min(size, CORNERS * 2e-3 * size)
            coarse = panel.mesh.model_copy(update={"size_m": size, "corner_size_m": corner})
            panel = panel.model_copy(update={"mesh": coarse})
            studied = StudiedPanel(panel)
            mesh = studied.mesh(file)
        if len(mesh.cells) > 2 * cells_max:
            return PanelEstimate(study_mesh, 9 * len(study_mesh.cells), 0, None, 0)
        # of the attachments only the masses are included here
        plate = studied.plate(replace(mesh, patch_cells={}))
    rigid, frequency, vectors = first_modes(plate, MODES + 3)
    coordinates = round(plate.stiffness.shape[0] * len(study_mesh.cells) / len(mesh.cells))
    first = Shapes(frequency[:MODES], frequency[:0], vectors[:, :MODES])
    elements, basis = len(mesh.cells), basis_of(mesh, plate, first)
    return PanelEstimate(study_mesh, coordinates, rigid, first.frequency, elements, basis)


def _of_panel(study: Study, panel: Panel, estimate: PanelEstimate) -> Iterator[tuple[str, str]]:
    """Yield what is checked first of a panel, each with its label."""
    from pidpanel.geometry.plane_mesh import cell_areas
    from pidpanel.panel.from_study import StudiedPanel

    mesh, studied = estimate.mesh, StudiedPanel(panel)
    area = abs(cell_areas(mesh.vertices, mesh.cells))
    mass = studied.section.mass_per_area * float(area.sum())
    attached = sum(item.mass_kg for item in panel.masses.values())
    carried = f", plus {attached:.3g} kg attached" if attached else ""
    yield "panel", f"{area.sum():.4g} m², {mass:.3g} kg{carried}"
    size = f"{len(mesh.cells)} elements, {len(mesh.vertices)} nodes"
    yield "mesh", f"{size}, about {estimate.coordinates} coordinates"
    if remarks := studied.remarks:
        yield "file", "; ".join(remarks)
    yield from (("mesh", text) for text in _of_coarse_mesh(study, studied))
    if study.is_coupled and estimate.frequency is not None and estimate.frequency.size:
        from pidpanel.coupled.from_study import check_modes

        lower = 1.0 if estimate.elements == len(mesh.cells) else COARSE
        check_modes(study, 0.0 if estimate.rigid else float(estimate.frequency[0]) / lower)
    yield "modes", _of_modes(study, estimate)
    if names := panel.single_points:
        remedy = "where frequencies depend on the mesh; state radius_m, of a mass from_m and to_m"
        yield "supports", f"{', '.join(names)} at single points, {remedy}"
    if study.sound is not None:
        yield "stretch", _of_stretching(studied)
    patch_area = {name: float(area[cells].sum()) for name, cells in mesh.patch_cells.items()}
    yield "points", "; ".join(_of_points(mesh, studied))
    yield from _of_inputs(study, patch_area, mass + attached)
    if study.sound is not None:
        yield from (("sound", text) for text in _of_sound(study, estimate.basis) if text)


def _of_structure(study: Study, section: Structure) -> Iterator[tuple[str, str]]:
    """Yield what is checked first of a structure, each with its label."""
    from pidpanel.structure.any_structure import MOST_TANGENTIAL, WIDE_PATCH
    from pidpanel.structure.from_study import structure_of

    structure = structure_of(section)
    area, cells = structure.surface.area, structure.surface.cells
    mass = structure.section.mass_per_area * float(area.sum())
    yield "surface", f"{area.sum():.4g} m², {mass:.3g} kg"
    yield "mesh", f"{len(cells)} elements, {len(structure.surface.vertices)} nodes"
    if remarks := structure.remarks:
        yield "file", "; ".join(remarks)
    yield "modes", f"{', '.join(f'{f:.4g}' for f in structure.first_frequency[:MODES])} Hz"
    patch_area = {name: float(area[inside].sum()) for name, inside in structure.patches.items()}
    shares = structure.tangential_shares(*structure.first_motion)
    for name, value in patch_area.items():
        text = f"{name} {value:.4g} m², {100 * shares[name]:.0f} % of the motion along the surface"
        if (spread := structure.normal_spread(name)) > WIDE_PATCH:
            text += f"; its normals are up to {spread:.0f}° off their mean, which gravity refers to"
        if shares[name] > MOST_TANGENTIAL:
            text += ", which its dampers neither feel nor damp"
        yield "patches", text
    yield from _of_inputs(study, patch_area, mass)
    if study.sound is not None:
        yield from (("sound", text) for text in _of_sound(study, None) if text)


def _of_inputs(
    study: Study, patch_area: Mapping[str, float], mass: float
) -> Iterator[tuple[str, str]]:
    """Yield what is checked first of dampers, tables, limits and the motion of supports."""
    for label, weights in _damper_masses(study, patch_area).items():
        shares = [100 * weight / mass for weight in weights]
        yield "dampers", f"{label}: about {_range(weights)} kg ({_range(shares)} % of the panel)"
    yield from (("data", text) for text in tables_in_words(study))
    yield from (("limit", f"{p} at most {x.text}") for p, x in study.limits.items())
    if study.update is not None:
        yield "update", f"of the margin by {study.update.text}"
    yield from (("gravity", text) for text in _of_gravities(study))
    for name, key in study.massless_dampers.items():
        yield "mass", f"the particles of {name} have no mass in the computation; {key}"
    yield from (("cells", text) for text in study.differing_cells)
    yield from (("unusual", text) for text in unusual(study))
    if study.base is not None:
        yield "base", "; ".join(_of_base(study.base))


def _of_coarse_mesh(study: Study, panel: StudiedPanel) -> Iterator[str]:
    """Yield that results will not be trusted, where the error of the mesh is estimated as such."""
    from pidpanel.response.trust import COARSE_MESH
    from pidpanel.solve.mesh_error import ALLOWED_DB

    high, ratio = study.response.frequency_hz[1], study.panel.modal_damping
    regions = panel.regions(high, study.damper_masses(with_rows=True))
    error = panel.elements.line_error_db(regions, high, ratio.smallest(0.0, high), **panel.rough)
    if error > ALLOWED_DB:
        places = {"feet": " at the rims of feet", "ends": " at the ends of supported parts"}
        where = places.get(panel.cause_of_shift(regions[0].longest_edge, high), "")
        yield (
            f"PSDs will be off by about {error:.1f} dB, above {ALLOWED_DB:g} dB: results are marked"
            f" '{COARSE_MESH}'; elements{where} must be shorter"
        )


def _of_modes(study: Study, estimate: PanelEstimate) -> str:
    if estimate.frequency is None:
        return "not computed here: the mesh is too large for a quick look"
    text = f"{estimate.rigid} rigid-body modes, then " if estimate.rigid else ""
    text += f"{', '.join(f'{f:.4g}' for f in estimate.frequency)} Hz on "
    is_coarser = estimate.elements != len(estimate.mesh.cells)
    text += f"a coarser mesh of {estimate.elements} elements" if is_coarser else "the study's mesh"
    high = study.response.frequency_hz[1]
    if estimate.frequency.size and estimate.frequency[0] > high:
        text += f"; none below {high:g} Hz, where the response is quasi-static"
    return text


def _of_stretching(studied: StudiedPanel) -> str:
    """Return from which displacement a panel stretches, and what is assumed there."""
    from pidpanel.panel.stretching import in_plane_stiffness
    from pidpanel.response.stretching import LINEAR

    panel = studied.panel
    opening = f"counts from {LINEAR * panel.section.thickness_mm:.3g} mm rms on"
    if in_plane_stiffness(studied.section) is None:
        return f"{opening}; not computed, since the section is not symmetric"
    return f"{opening}; edges are {panel.in_plane_edges} in the plane (panel.in_plane_edges)"


def _of_gravities(study: Study) -> Iterator[str]:
    """Yield the beds whose gravity with steady acceleration is not 1 g along the motion."""
    beds = {
        study.damper_name(scenario, patch): damper
        for scenario in study.all_scenarios()
        for patch in scenario.patches
        if isinstance(damper := study.damper_in(scenario, patch), BedDamper)
    }
    for name, bed in beds.items():
        if (vector := bed.apparent_gravity_g) != (0.0, 0.0, -1.0):
            text = f"{name} feels {vector_text(vector)} g along x, y and the motion z"
            yield f"{text}, {bed.gravity_angle_deg:.0f}° to the motion"


def _of_points(mesh: PanelMesh, studied: StudiedPanel) -> Iterator[str]:
    """Yield each response point with the patches that it lies on, or the support."""
    import shapely

    from pidpanel.panel.supports import held_vertices

    supports = studied.supports
    edges = [mesh.vertices[list(edge)] for edge in held_vertices(mesh, supports)[1]]
    for name, (x, y) in mesh.points.items():
        patches = mesh.patches_at((x, y))
        fixed = [
            f", on {label}, where it does not move"
            for label, support in supports.points.items()
            if math.dist((x, y), support.position) <= max(support.radius, 1e-6)
        ]
        if shapely.MultiLineString(edges).dwithin(shapely.Point(x, y), 1e-6):
            fixed.append(", on a supported edge, where it does not move")
        yield f"{name} on {' and '.join(patches) or 'no patch'}{''.join(fixed)}"


def _damper_masses(study: Study, area: Mapping[str, float]) -> dict[str, list[float]]:
    """Return the masses [kg] by patches and dampers, of all fills; none where they are not known.

    What a law of the paper weighs is not known, nor is a table without that column.
    """
    groups: dict[tuple[tuple[str, str], ...], list[Scenario]] = {}
    for scenario in study.all_scenarios():
        if not scenario.is_bare:
            key = tuple((patch, str(f.damper)) for patch, f in scenario.fillings.items())
            groups.setdefault(key, []).append(scenario)
    # dampers that differ in the model alone have the same fills and masses
    names: dict[tuple[tuple[str, ...], str, tuple[float, ...]], list[tuple[str, ...]]] = {}
    for key, scenarios in groups.items():
        fillings = list({tuple(s.fillings.items()): s.fillings for s in scenarios}.values())
        masses = [sum(area[p] * _mass_per_area(study, f) for p, f in x.items()) for x in fillings]
        finite = tuple(mass for mass in masses if not math.isnan(mass))
        r = [f.fill_fraction for x in fillings for f in x.values() if f.fill_fraction is not None]
        fill = f", r = {_range(r)}" if r else ""
        patches, beds = zip(*key, strict=True)
        if finite:
            names.setdefault((patches, fill, finite), []).append(beds)
    totals = {}
    for (patches, fill, finite), rows in names.items():
        dampers = [", ".join(dict.fromkeys(name)) for name in zip(*rows, strict=True)]
        label = " + ".join(map(" ".join, zip(patches, dampers, strict=True))) + fill
        totals[label] = list(finite)
    return totals


def _range(values: Sequence[float]) -> str:
    """Return the least and the greatest of some values, or the only one.

    Examples
    --------
    >>> _range([0.3, 0.1]), _range([2.0]), _range([56.1, 168.7])
    ('0.1 to 0.3', '2', '56 to 170')
    """
    low, high = (f"{float(f'{value:.2g}'):g}" for value in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"


def _mass_per_area(study: Study, filling: Filling) -> float:
    """Return about what a damper weighs [kg/m²]; NaN where it is not known."""
    from pidpanel.damping.from_study import damper_model

    fill = math.nan if filling.fill_fraction is None else filling.fill_fraction
    damper = study.damper_of(filling)
    if not isinstance(damper, BedDamper):
        return float(damper_model(damper).mass_per_area(fill))
    diameter = damper.diameters[0]
    bulk = bulk_fraction(diameter, damper.cell.across_flats)
    return bulk * damper.particles.effective_density(diameter) * damper.cell.depth * fill


def _of_sound(study: Study, basis: PanelBasis | None) -> Iterator[str]:
    """Yield the levels overall, in the range and as tabulated; the surroundings, and others."""
    from pidpanel.sound.from_study import spectrum_of
    from pidpanel.sound.spectrum import REFERENCE_PRESSURE
    from pidpanel.sound.table import read_pressure
    from pidpanel.surroundings.from_study import surroundings_text

    sound, (low, high) = study.acoustics, study.response.frequency_hz
    spectrum = spectrum_of(sound)
    in_range = 10 * math.log10(spectrum.points.mean_square(low, high) / REFERENCE_PRESSURE**2)
    extra = sorted({s.oaspl_db for s in study.all_scenarios() if s.oaspl_db is not None})
    extra = [level for level in extra if level != sound.oaspl_db]
    scenarios = f"; scenarios at {', '.join(f'{level:g}' for level in extra)} dB" if extra else ""
    tables = "; ".join(read_pressure(file)[1] for file in sound.spectra) or spectrum.source
    yield (
        f"OASPL {spectrum.oaspl:.1f} dB, {in_range:.1f} dB in {low:g} to {high:g} Hz; as tabulated "
        f"{tables}{scenarios}"
    )
    yield study.setting
    if basis is not None:
        yield surroundings_text(study, basis, basis.natural_frequency, basis.modal_mass)


def _of_base(base: BaseMotion) -> Iterator[str]:
    from pidpanel.spectra.acceleration_table import read_acceleration

    if base.random is not None:
        yield f"random, as tabulated {read_acceleration(base.random.spectrum)[1]}"
    if base.sine is not None:
        low, high = base.sine.frequency_hz
        yield f"sine {base.sine.acceleration_g:g} g from {low:g} to {high:g} Hz, up and down"
    yield "the panel in vacuum: without mass and damping of the air"


def _duration(seconds: float) -> str:
    """Return a time in words.

    Examples
    --------
    >>> _duration(42), _duration(1260), _duration(9000)
    ('42 s', '21 min', '2.5 h')
    """
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"
