"""The draft of a study: what is known of a panel, as a commented YAML file that can be run."""

import json
import os
import textwrap
from collections.abc import Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import jinja2
import numpy as np
import yaml

from pidpanel.cli.mesh_draft import MeshDraft
from pidpanel.cli.shell_draft import is_flat, shell_draft
from pidpanel.cli.structure_draft import DECKS, StructureDraft, modes_draft
from pidpanel.columns import read_rows
from pidpanel.damping.laws import FREQUENCY_RANGE
from pidpanel.paths import DATA, TEMPLATES, WORKFLOW
from pidpanel.sound.table import read_spectrum
from pidpanel.structure.any_structure import StructureRefused
from pidpanel.structure.from_study import studied
from pidpanel.study import StudyError, load_study
from pidpanel.study.base import found_file
from pidpanel.study.requirements import DEPTH, WIDTH
from pidpanel.study.scenarios import level_suffix
from pidpanel.study.section import core_cell_width_mm
from pidpanel.study.stated_dampers import TableDamper

LOWEST, HIGHEST = 30.0, 2000.0  # of a response, where the spectrum goes that far [Hz]
DEPTH_MM = 12.0  # least depth of cells that stand on a panel
FILLS = (0.3, 0.5, 0.7, 0.9)

# Most reductions of the element size by 0.8 until the mesh resolves the waves, and the last one by
# 0.48: resonances are 1 % and then 0.05 % too high, which is 0.2 dB next to one with ζ = 1 %.
# Patches, whose elements follow their dampers, add about 0.4 dB.
FINER, SHORTER, SHARP = 20, 0.8, 0.48
COARSE = "too coarse for"  # of a refusal that a lower frequency mends
REFINED = 4  # largest panel.mesh.refine that is tried; elements of a file do not follow dampers


class Draft(SimpleNamespace):
    """The options of `pidpanel new`, and what follows from them."""

    @property
    def edges(self) -> str:
        """Supports of the edges; free on hold-downs."""
        if self.structure is not None:
            return ""
        if self.deck is not None and not self.supports:
            return str(self.deck.supports["outline"])
        return self.supports or ("free" if self.hold_downs else "simply_supported")

    @cached_property
    def structure(self) -> StructureDraft | None:
        """What a file of modes gives, or a deck that is not flat; None without one."""
        options = self.unit_m, self.groups, self.written
        try:
            if self.modes is not None:
                scale = {"is_normalised": self.mass_normalised, "uniform_kg": self.uniform_kg}
                return modes_draft(self.modes, self.mesh, *options, **scale)
            if self.mesh is None or self.mesh.suffix.lower() not in DECKS:
                return None
            return None if is_flat(self.mesh, self.groups) else shell_draft(self.mesh, *options)
        except ValueError as error:
            raise StudyError(str(error)) from None

    def written(self, path: Path) -> str:
        """Return the path of a file as the study states it."""
        return _relative_path(str(path), self.file)

    @cached_property
    def deck(self) -> MeshDraft | None:
        """What a mesh file gives; None without one."""
        if self.mesh is None or self.structure is not None:
            return None
        try:
            kind = self.section if self.is_section_stated else None
            return MeshDraft.of_file(self.mesh, self.unit_m, self.groups, kind)
        except ValueError as error:
            place = "" if str(error).startswith(str(self.mesh)) else f"{self.mesh}: "
            raise StudyError(f"{place}{error}") from None

    @property
    def laminate(self) -> Mapping[str, Any]:
        """Section of the deck; empty where it has none that is read, or the options state it."""
        return self.deck.section if self.deck else {}

    @property
    def thickness(self) -> float:
        """Thickness of a solid or thin section [mm]."""
        return self.thickness_mm or (5.0 if self.section == "solid" else 25.0)

    @property
    def depth_mm(self) -> float:
        """Depth of the cells: that of the core, or of the panel."""
        return self.core_mm if self.section == "sandwich" else self.thickness

    @property
    def width_mm(self) -> float:
        """Width of the cells: that of the core, or usual."""
        of_core = core_cell_width_mm(self.core_grade) if self.section == "sandwich" else None
        return self.cell_mm or of_core or 6.35

    @property
    def is_simulated(self) -> bool:
        """Whether patches are filled with particles."""
        return not self.table and self.bead != "none"

    @property
    def is_in_atlas(self) -> bool:
        """Whether the atlas has cells of this width and depth."""
        sizes = {WIDTH: self.width_mm, DEPTH: self.depth_mm}
        return all(low <= mm / self.bead_mm <= high for (low, high), mm in sizes.items())

    @property
    def has_law(self) -> bool:
        """Whether damping is that of the paper's law."""
        return not self.table and not self.is_simulated

    @property
    def model(self) -> str:
        """Damping model of particles; a search and base motion need damping from single tones."""
        if self.is_in_atlas:
            return "atlas"
        return "tones" if self.budget_kg is not None or self.shaker else "coupled"


def write(draft: Draft, file: Path, *, force: bool = False) -> None:
    """Write a study that can be run: its elements are as small as its waves ask for.

    Raises
    ------
    StudyError
        If the file exists, or the requested values cannot be computed; nothing is written then.
    """
    if file.exists() and not force:
        raise StudyError(f"{file}: exists; --force overwrites it")
    if file.suffix not in (".yaml", ".yml"):
        raise StudyError(f"{file}: must end in .yaml")
    backup = file.read_bytes() if file.exists() else None
    file.parent.mkdir(parents=True, exist_ok=True)
    try:
        if draft.structure is not None:
            values = _values(draft, file)
            while not _is_fine(file, values):
                values["high"] = _rounded(SHORTER * values["high"])
            return
        _write_panel(draft, file, _values(draft, file))
    except BaseException:
        if backup is None:
            file.unlink(missing_ok=True)
        else:
            file.write_bytes(backup)
        raise


def _write_panel(draft: Draft, file: Path, values: dict[str, Any]) -> None:
    """Write a panel with elements that resolve its waves; of a deck, waves that they resolve."""
    last = FINER if draft.deck is None else REFINED
    for step in range(last + FINER * (draft.deck is not None) + 1):
        length = max(draft.size) / 8 * SHORTER**step
        if step > last:
            values["high"] = _rounded(SHORTER * values["high"])
        _write_text(file, {**values, "refine": min(step, last)}, length)
        study = load_study(file)
        try:
            masses = study.damper_masses() if draft.deck else {}
            studied(study.panel).check(study.response.frequency_hz[1], masses)
        except ValueError as error:
            is_coarse = draft.deck is not None and COARSE in str(error)
            if step >= last and not (is_coarse and SHORTER * values["high"] > 2 * values["low"]):
                raise StudyError(f"{file}: panel: {error}") from None
        else:
            if draft.deck is None:
                _write_text(file, values, SHARP * length)
            return


def _is_fine(file: Path, values: Mapping[str, Any]) -> bool:
    """Write a structure; return whether its elements resolve the waves, refuse other mistakes."""
    _write_text(file, values, 0.0)
    study = load_study(file)
    try:
        studied(study.panel).check(study.response.frequency_hz[1], study.damper_masses())
    except StructureRefused as refused:
        if refused.keys == ("shell", "size_m") and SHORTER * values["high"] > 2 * values["low"]:
            return False
        raise StudyError(f"structure.{'.'.join(refused.keys)}: {refused}") from None
    return True


def _write_text(file: Path, values: Mapping[str, Any], element: float) -> None:
    """Write the study with elements of about a length [m]."""
    file.write_text(_text({**values, "element": _rounded(element)}), encoding="utf-8")


def _refuse(draft: Draft) -> None:
    """Refuse options that do not go together."""
    for kind in ("hold_downs", "holes", "points") if draft.structure is None else ():
        for x, y, *_ in getattr(draft, kind):
            if not (0 <= x <= draft.size[0] and 0 <= y <= draft.size[1]):
                option = f"--{kind[:-1].replace('_', '-')} {x:g},{y:g}"
                raise StudyError(f"{option}: lies off the panel, {draft.size[0]}x{draft.size[1]} m")
    if draft.budget_kg is not None and draft.has_law:
        raise StudyError(f"--budget-kg {draft.budget_kg:g}: needs particles or a table with masses")
    if draft.steady_g is not None and not draft.is_simulated:
        raise StudyError("--steady-g: needs particles; other damping does not know it")
    if draft.uncertain and (draft.structure is not None or draft.model == "coupled"):
        raise StudyError("--uncertain: needs a panel, and damping of the atlas, a table or the law")
    if draft.wall_m is not None and draft.surroundings == "baffle":
        raise StudyError(f"--wall-m {draft.wall_m:g}: not allowed with --surroundings baffle")


def _range(draft: Draft, file: Path, spectrum: str) -> tuple[float, float]:
    """Return the lowest and the highest frequency of the response [Hz]."""
    try:
        table = found_file(Path(spectrum), file.parent, DATA / "spl")
        edges = read_spectrum(table).reach
    except ValueError as error:
        raise StudyError(f"--spectrum {draft.spectrum}: {error}") from None
    low, high = max(LOWEST, float(edges[0])), min(HIGHEST, float(edges[-1]))
    if draft.has_law:
        low, high = max(low, FREQUENCY_RANGE[0]), min(high, FREQUENCY_RANGE[1])
    if draft.structure is not None:
        if (highest := draft.structure.highest) < high:
            step = 10.0 ** np.floor(np.log10(highest) - 1)
            high = float(step * np.floor(highest / step))
        if high <= low:
            last = draft.structure.highest
            raise StudyError(f"--modes {draft.modes}: end too low, for a response to {last:.4g} Hz")
    return low, high


def _values(draft: Draft, file: Path) -> dict[str, Any]:
    """Return the variables of the template."""
    _refuse(draft)
    spectrum = _relative_path(draft.spectrum, file)
    low, high = _range(draft, file, spectrum)
    if draft.structure is not None:
        draft.section, draft.thickness_mm = "structure", DEPTH_MM
        if not draft.structure.has_free_edges:
            draft.surroundings = "baffle"
    fills = _fills(Path(draft.table)) if draft.table else FILLS
    if draft.deck is not None:
        draft.size = draft.deck.size
        if draft.laminate:
            draft.core_grade, draft.section = "", draft.laminate["kind"]
            draft.cell_mm = draft.cell_mm or draft.width_mm
            if draft.section == "sandwich":
                draft.core_mm = draft.laminate["core"]["thickness_mm"]
            else:  # cells stand on it
                draft.thickness_mm = max(draft.laminate["thickness_mm"], DEPTH_MM)
    a, b = draft.size
    second = "quarter" if draft.structure is None else draft.structure.second
    patch = _rounded(0.2 * min(a, b))
    return {
        **vars(draft),
        "draft": draft,
        "limits": _limits(draft, file),
        "judged": f"centre_r{min(fills, key=lambda fill: abs(fill - 0.5)):g}"
        + level_suffix(draft.oaspl),
        "laminate": draft.laminate,
        "second": second,
        "remarks": (draft.structure or draft.deck or SimpleNamespace(remarks=())).remarks,
        "refine": 0,
        "mesh": _relative_path(str(draft.mesh), file) if draft.mesh else "",
        "title": draft.title or file.stem,
        "name": file.stem,
        "spectrum": spectrum,
        "table": _relative_path(draft.table, file) if draft.table else "",
        "mass_key": _mass_key(Path(draft.table)) if draft.table else "",
        "shaker": _relative_path(draft.shaker, file) if draft.shaker else "",
        "atlas": (WIDTH, DEPTH),
        "fills": fills,
        "fill": min(fills, key=lambda fill: abs(fill - 0.5)),
        "patch": patch,
        "centre": (a / 2, b / 2),
        "corner": (_rounded(a / 4), _rounded(b / 4)),
        "low": low if low == LOWEST else round(low + 0.05, 1),
        "high": high if high == HIGHEST or draft.structure else round(high - 0.05, 1),
        "schema": (WORKFLOW / "schemas" / "study.schema.json").as_uri(),
    }


def _limits(draft: Draft, file: Path) -> dict[str, dict[str, Any]]:
    """Return the section ``limits``: numbers [g rms] and tables of PSDs by point."""
    names = [f"P{number}" for number in range(1, 3 + len(draft.points))]
    names += ["corner"] if draft.edges == "free" else []
    limits: dict[str, dict[str, Any]] = {}
    for text in draft.limits:
        point, _, value = text.rpartition("=")
        try:
            limit: dict[str, Any] = {"rms_g": float(value)}
        except ValueError:
            limit = {"psd": _relative_path(value, file)}
        for name in [point] if point else names:
            limits[name] = {**limits.get(name, {}), **limit}
    return limits


def _fills(table: Path) -> Sequence[float]:
    """Return fill fractions that a table has; what is wrong with it, the check reports."""
    try:
        rows = read_rows(found_file(table, Path(), DATA / "damping"))
        place = rows.header.index("fill_fraction")
        fractions = sorted({float(cells[place]) for _, cells in rows.rows})
    except (ValueError, IndexError):  # such as a table without fill fractions
        return FILLS
    inside = [fill for fill in FILLS if fractions[0] <= fill <= fractions[-1]]
    return inside if len(inside) > 1 else fractions[:4]


def _mass_key(table: Path) -> str:
    """Return the key that gives particles a mass if their table has their mass alone."""
    try:
        file = found_file(table, Path(), DATA / "damping")
    except ValueError:  # the check reports it
        return ""
    return ", apparent_mass: particles" if TableDamper(table=file).is_massless else ""


def _relative_path(name: str, file: Path) -> str:
    """Return a file's path relative to the folder of the study; a name that comes with pidpanel."""
    path = Path(name)
    return os.path.relpath(path, file.parent) if path.is_file() else name


def _rounded(length: float) -> float:
    """Return a length to two significant digits [m]."""
    return float(f"{length:.2g}")


def _text(values: Mapping[str, Any]) -> str:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES / "study"),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        finalize=lambda value: f"{value:.12g}" if isinstance(value, float) else value,
        autoescape=False,
    )
    environment.filters["quoted"] = partial(json.dumps, ensure_ascii=False)
    environment.filters["block"] = lambda values, width: textwrap.indent(
        yaml.safe_dump(values, sort_keys=False, default_flow_style=None, width=96), width * " "
    )
    return environment.get_template("new.yaml.j2").render(values)
