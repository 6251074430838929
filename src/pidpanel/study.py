"""A study: one YAML file, checked, frozen, and turned to SI here and nowhere else.

Every key carries its unit in its name (``depth_mm``); the property without the suffix
(``depth``) is the same quantity in SI. Unknown keys are refused with the nearest right one
named; a mistake is answered by one line with the file, the line, the key, the value and
what is allowed (`StudyError`).
"""

from __future__ import annotations

import difflib
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import yaml
from pydantic import (
    BaseModel,
    Field,
    ValidationError,
    model_validator,
)

from pidpanel.study_base import Fill, Model, Positive
from pidpanel.study_coupon import Coupon
from pidpanel.study_panel import Panel


class StudyError(ValueError):
    """A mistake in a study file; the text is one line a user can act on."""


# --------------------------------------------------------------------------- damping

Reading = Literal["dem", "paper_corrected", "paper_printed", "table"]


class Level(Model):
    """The motion at which C_e(r, f, Γ) is read: a stated Γ, or the patch's own."""

    kind: Literal["patch", "stated"] = "patch"
    acceleration_g: Positive | None = None
    outside: Literal["mark", "refuse"] = "mark"

    @model_validator(mode="after")
    def _stated(self) -> Level:
        if (self.kind == "stated") != (self.acceleration_g is not None):
            raise ValueError("acceleration_g goes with kind: stated, and only with it")
        return self


class Target(Model):
    """Run no more of ``coupon.sweep`` than is needed to know every rms acceleration so well.

    The sweep is then what may be run. ``start`` cases spread over it come first; rounds of
    ``batch`` follow, each of the cases that narrow the rms values most, until the relative
    standard error of all of them is below ``relative_error`` or ``max_cases`` have been run.
    """

    relative_error: Annotated[float, Field(gt=0, lt=1)]
    start: Annotated[int, Field(ge=4)] = 10
    batch: Annotated[int, Field(ge=1)] = 4
    max_cases: Annotated[int, Field(ge=4)] = 2000

    @model_validator(mode="after")
    def _start_is_allowed(self) -> Target:
        if self.start > self.max_cases:
            raise ValueError(f"start = {self.start}: at most max_cases = {self.max_cases}")
        return self


class Damping(Model):
    """Where C_e and m_a come from. Each reading is carried through to the PSDs."""

    readings: Annotated[tuple[Reading, ...], Field(min_length=1)] = ("dem",)
    level: Level = Level()
    table: Path | None = None
    target: Target | None = None
    """Left out, the whole of ``coupon.sweep`` is run."""

    @model_validator(mode="after")
    def _target(self) -> Damping:
        if self.target is not None and "dem" not in self.readings:
            raise ValueError("target: goes with the reading 'dem'")
        return self

    @model_validator(mode="after")
    def _table(self) -> Damping:
        if len(set(self.readings)) != len(self.readings):
            raise ValueError(f"readings = {list(self.readings)}: each one once")
        if ("table" in self.readings) != (self.table is not None):
            raise ValueError("table: a CSV file, given together with the reading 'table'")
        return self


# --------------------------------------------------------------------------- sound, response


class Sound(Model):
    """The acoustic field: a band spectrum, its level, its coherence, where it was measured."""

    spectrum: Path
    oaspl_db: Annotated[float, Field(ge=60, le=200)] | None = None
    """Overall level the spectrum is shifted to; left out, the table's own."""
    shift_db: Annotated[float, Field(ge=-60, le=60)] = 0.0
    """Every band higher by so much, such as +3 dB for protoqualification; not with oaspl_db."""
    field: Literal["diffuse", "uncorrelated", "uniform", "plane_wave", "progressive_wave"] = (
        "diffuse"
    )
    """progressive_wave: a plane wave that grazes the panel, as in a progressive-wave tube."""
    incidence_deg: Annotated[float, Field(ge=0, le=90)] | None = None
    """Angle from the panel's normal at which a plane wave comes."""
    azimuth_deg: Annotated[float, Field(ge=-180, le=360)] | None = None
    """Direction in the plane of the panel, from x, in which a wave runs."""
    loaded_sides: Literal[1, 2] = 1
    """2: independent fields of that level on both faces, twice the PSD."""
    pressure_reference: Literal["surface", "room", "incident"] = "surface"
    speed_m_s: Positive = 343.0
    air_density_kg_m3: Positive = 1.2

    @property
    def incidence(self) -> float:
        """rad; a right angle for a progressive wave."""
        return math.radians(90.0 if self.incidence_deg is None else self.incidence_deg)

    @property
    def azimuth(self) -> float:
        """rad."""
        return math.radians(self.azimuth_deg or 0.0)

    @model_validator(mode="after")
    def _one_level_one_wave(self) -> Sound:
        if self.oaspl_db is not None and self.shift_db != 0:
            raise ValueError(
                f"oaspl_db = {self.oaspl_db:g} and shift_db = {self.shift_db:g}: one of the two"
            )
        if (self.field == "plane_wave") != (self.incidence_deg is not None):
            raise ValueError("incidence_deg goes with field: plane_wave, and only with it")
        if self.azimuth_deg is not None and not self.field.endswith("_wave"):
            raise ValueError("azimuth_deg goes with field: plane_wave or progressive_wave only")
        return self


Radiation = Literal["none", "one_side", "two_sides"]


class Response(Model):
    """The frequencies looked at, and what the patches do besides damping."""

    frequency_hz: tuple[Positive, Positive] = (20.0, 2000.0)
    damper_mass: bool = True
    modal_damping: Literal["full", "diagonal"] = "full"
    """full: the whole modal damping matrix; diagonal: the paper's Eq. 9–12."""
    radiation: Radiation = "none"
    """Sides of a baffled panel that radiate into the air and carry its mass; the paper has none."""
    radiation_beside: Radiation = "none"
    """Everything once more with this radiation, shown in a table beside."""
    maps: tuple[str, ...] = ()
    """Scenarios, by their names in summary.csv, to map over the panel; left out, the first bare."""

    @model_validator(mode="after")
    def _air(self) -> Response:
        if self.radiation_beside == self.radiation != "none":
            raise ValueError(
                f"radiation_beside = {self.radiation_beside}: another than radiation, or none"
            )
        if self.modal_damping == "diagonal" and {self.radiation, self.radiation_beside} != {"none"}:
            raise ValueError("modal_damping: diagonal is the paper's form: radiation must be none")
        return self

    @model_validator(mode="after")
    def _rises(self) -> Response:
        if self.frequency_hz[1] <= self.frequency_hz[0]:
            raise ValueError(
                f"frequency_hz = {list(self.frequency_hz)}: two values, the second above the first"
            )
        return self


class Family(Model):
    """One comparison: exactly one of patch, fill_fraction and oaspl_db is a list."""

    patch: str | tuple[str, ...]
    fill_fraction: Fill | tuple[Fill, ...]
    oaspl_db: float | tuple[float, ...] | None = None
    title: str = ""

    @model_validator(mode="after")
    def _one_list(self) -> Family:
        lists = [
            key
            for key in ("patch", "fill_fraction", "oaspl_db")
            if isinstance(getattr(self, key), tuple)
        ]
        if len(lists) != 1:
            raise ValueError(
                f"{len(lists)} of patch, fill_fraction and oaspl_db are lists: exactly one may be"
            )
        return self

    @property
    def varied(self) -> str:
        for key in ("patch", "fill_fraction", "oaspl_db"):
            if isinstance(getattr(self, key), tuple):
                return key
        raise StudyError("a family without a list")  # held off by the validator


class Scenario(Model):
    """One response: a patch with its fill (or none, the bare panel) at one level."""

    patch: str | None
    fill_fraction: float
    oaspl_db: float | None

    @property
    def label(self) -> str:
        level = "" if self.oaspl_db is None else f"_{self.oaspl_db:g}dB"
        if self.patch is None:
            return f"bare{level}"
        return f"{self.patch}_r{self.fill_fraction:g}{level}"

    @property
    def bare(self) -> Scenario:
        return Scenario(patch=None, fill_fraction=0.0, oaspl_db=self.oaspl_db)


# --------------------------------------------------------------------------- study


class CouponStudy(Model):
    """A study of the coupon alone: what the spheres dissipate, and on what it depends."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]*$")]
    title: str = ""
    assumptions: tuple[str, ...] = ()
    """What the source leaves out and this study assumes; printed in the report."""
    coupon: Coupon | None = None

    @model_validator(mode="after")
    def _coupon(self) -> CouponStudy:
        if self.coupon is None and type(self) is CouponStudy:
            raise ValueError("neither a coupon nor a panel: at least one of them")
        return self


class Study(CouponStudy):
    """All that a run of the whole workflow depends on."""

    damping: Damping = Damping()
    panel: Panel
    sound: Sound
    response: Response = Response()
    scenarios: Annotated[Mapping[str, Family], Field(min_length=1)]

    @model_validator(mode="after")
    def _hangs_together(self) -> Study:
        if "dem" in self.damping.readings:
            if self.coupon is None:
                raise ValueError("damping.readings names 'dem': the section 'coupon' must be there")
            if self.coupon.vary:
                raise ValueError(
                    "coupon.vary: for a study of the coupon alone; one panel takes one damping"
                )
        for name, family in self.scenarios.items():
            patches = (family.patch,) if isinstance(family.patch, str) else family.patch
            for patch in patches:
                if patch not in self.panel.patches:
                    raise ValueError(
                        f"scenarios.{name}.patch = {patch}: one of panel.patches, "
                        f"{', '.join(self.panel.patches) or 'of which there are none'}"
                    )
            fills = _as_tuple(family.fill_fraction)
            if "dem" in self.damping.readings and self.coupon is not None:
                run = self.coupon.sweep.fill_fraction
                for fill in fills:
                    if not min(run) <= fill <= max(run):
                        raise ValueError(
                            f"scenarios.{name}.fill_fraction = {fill:g}: within the fills of "
                            f"coupon.sweep, {min(run):g} to {max(run):g}"
                        )
        labels = [s.label for s in self.all_scenarios()]
        for label in self.response.maps:
            if label not in labels:
                raise ValueError(f"response.maps: {label}: one of {', '.join(labels)}")
        return self

    def family_scenarios(self, name: str) -> tuple[Scenario, ...]:
        """The scenarios of one family, in the order of its list."""
        family = self.scenarios[name]
        levels = _as_tuple(family.oaspl_db if family.oaspl_db is not None else self.sound.oaspl_db)
        return tuple(
            Scenario(patch=patch, fill_fraction=fill, oaspl_db=level)
            for patch, fill, level in itertools.product(
                _as_tuple(family.patch), _as_tuple(family.fill_fraction), levels
            )
        )

    def all_scenarios(self) -> tuple[Scenario, ...]:
        """Every scenario once, each level's bare panel first."""
        families = [s for name in self.scenarios for s in self.family_scenarios(name)]
        ordered = dict.fromkeys([s.bare for s in families] + families)
        return tuple(ordered)

    def mapped_scenarios(self) -> tuple[Scenario, ...]:
        """The scenarios of ``response.maps``."""
        labels = self.response.maps or (self.all_scenarios()[0].label,)
        return tuple(s for s in self.all_scenarios() if s.label in labels)


def _as_tuple(value: Any) -> tuple[Any, ...]:
    return tuple(value) if isinstance(value, tuple | list) else (value,)


# --------------------------------------------------------------------------- reading


class _Loader(yaml.SafeLoader):
    """Safe YAML that refuses a key that stands twice."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen: set[Any] = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if key in seen:
                raise StudyError(
                    f"{self.name}:{key_node.start_mark.line + 1}: {key}: "
                    "stands twice; each key once"
                )
            seen.add(key)
        return super().construct_mapping(node, deep)


def load_study(path: str | Path) -> Study:
    """Read and check the file of a study that has a panel; see `load_any_study`."""
    study = load_any_study(path)
    if not isinstance(study, Study):
        raise StudyError(f"{path}: panel: missing; this is a study of the coupon alone")
    return study


def load_any_study(path: str | Path) -> Study | CouponStudy:
    """Read and check a study file: a `CouponStudy` if it says nothing of a panel.

    Parameters
    ----------
    path
        YAML file. Paths in it are taken from the file's own folder, then from
        ``workflow/data`` of the project.

    Raises
    ------
    StudyError
        One line: file, line, key, value, what is allowed.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise StudyError(f"{path}: cannot be read ({error.strerror}); a YAML file") from None
    try:
        loader = _Loader(text)
        loader.name = str(path)
        data = loader.get_single_data()
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 0
        raise StudyError(f"{path}:{line}: not YAML: {error.problem}") from None
    if not isinstance(data, dict):
        raise StudyError(f"{path}: empty; a mapping with the keys {', '.join(Study.model_fields)}")
    data.setdefault("name", path.stem)
    alone = "coupon" in data and not set(data) - set(CouponStudy.model_fields)
    model = CouponStudy if alone else Study
    try:
        study = model.model_validate(data)
    except ValidationError as error:
        raise StudyError("\n".join(_explain(path, text, error))) from None
    return _with_found_files(study, path)


def _with_found_files(study: Study | CouponStudy, path: Path) -> Study | CouponStudy:
    """Replace the files a study names by their paths; refuse those that are not there."""

    def find(key: str, name: Path, folder: str) -> Path:
        shipped = Path(__file__).resolve().parents[2] / folder
        for base in (path.parent, Path.cwd(), shipped):
            if (base / name).is_file():
                return base / name
        known = ", ".join(sorted(p.name for p in shipped.glob("*.*")))
        raise StudyError(
            f"{path}: {key} = {name}: no such file; a file beside the study"
            + (f" or one of {known}" if known else "")
        )

    coupon = study.coupon
    if coupon is not None:
        if coupon.deck is not None:
            deck = find("coupon.deck", coupon.deck, "templates")
            coupon = coupon.model_copy(update={"deck": deck})
        if "deck" in coupon.vary:
            decks = tuple(
                name if name is None else find("coupon.vary.deck", Path(name), "templates")
                for name in coupon.vary["deck"]
            )
            coupon = coupon.model_copy(update={"vary": {**coupon.vary, "deck": decks}})
        study = study.model_copy(update={"coupon": coupon})
    if not isinstance(study, Study):
        return study
    sound = study.sound.model_copy(
        update={"spectrum": find("sound.spectrum", study.sound.spectrum, "workflow/data/spl")}
    )
    damping = study.damping
    if damping.table is not None:
        damping = damping.model_copy(
            update={"table": find("damping.table", damping.table, "workflow/data/damping")}
        )
    panel = study.panel
    if panel.mesh.file is not None:
        file = path.parent / panel.mesh.file
        if not file.is_file():
            raise StudyError(f"{path}: panel.mesh.file = {panel.mesh.file}: no such file")
        panel = panel.model_copy(update={"mesh": panel.mesh.model_copy(update={"file": file})})
    return study.model_copy(update={"sound": sound, "damping": damping, "panel": panel})


def _explain(path: Path, text: str, error: ValidationError) -> Iterator[str]:
    """One line for each mistake pydantic found, in the order of the file."""
    root = yaml.compose(text)
    best: dict[tuple[Any, ...], str] = {}
    for item in error.errors():
        location = _written_location(root, item["loc"])
        line, value = _line_and_value(root, location)
        key = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in location).lstrip(".")
        if item["type"] == "extra_forbidden":
            allowed = _allowed_keys(location[:-1])
            near = difflib.get_close_matches(str(location[-1]), allowed, n=1, cutoff=0.5)
            message = "unknown key" + (
                f"; did you mean {near[0]}?" if near else f"; allowed are {', '.join(allowed)}"
            )
        elif item["type"] == "missing":
            message = "missing; it must be given"
        else:
            message = item["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
        shown = "" if value is None else f" = {value}"
        where = f"{path}:{line}: " if line else f"{path}: "
        best.setdefault(location, f"{where}{key + shown + ': ' if key else ''}{message}")
    for location, line_of_text in best.items():
        # a list of which no item is good is also reported as too short: once is enough
        if not any(len(o) > len(location) and o[: len(location)] == location for o in best):
            yield line_of_text


def _written_location(root: yaml.Node | None, location: Sequence[Any]) -> tuple[Any, ...]:
    """Location as the user wrote it: without pydantic's names of union members."""
    written: list[Any] = []
    for part in location:
        if isinstance(part, str) and not part.startswith("PID"):
            if part[:1].isupper() or "[" in part or part in ("float", "str", "none"):
                continue
            # the member that ``kind`` chose
            if _line_and_value(root, [*written, "kind"])[1] == part:
                continue
        written.append(part)
    return tuple(written)


def _line_and_value(node: yaml.Node | None, location: Sequence[Any]) -> tuple[int, str | None]:
    line = 0
    for part in location:
        if isinstance(node, yaml.MappingNode):
            for key, value in node.value:
                if str(key.value) == str(part):
                    line, node = key.start_mark.line + 1, value
                    break
            else:
                return line, None
        elif (
            isinstance(node, yaml.SequenceNode) and isinstance(part, int) and part < len(node.value)
        ):
            node = node.value[part]
            line = node.start_mark.line + 1
        else:
            return line, None
    return line, node.value if isinstance(node, yaml.ScalarNode) else None


def _allowed_keys(location: Sequence[Any]) -> list[str]:
    """Keys of the model, or of the models of a choice, at a place of the study."""
    models: list[type[BaseModel]] = [Study]
    for part in location:
        fields = [m.model_fields[str(part)] for m in models if str(part) in m.model_fields]
        if fields:
            models = [model for field in fields for model in _models_in(field.annotation)]
    return [f.alias or name for model in models for name, f in model.model_fields.items()]


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    """The models inside ``X | Y``, ``Mapping[str, X]``, ``Annotated[X, …]``."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    inner = getattr(annotation, "__args__", ())
    return [model for argument in inner for model in _models_in(argument)]
