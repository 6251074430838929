"""Base of all sections of a study: the model, its mistakes, ranges of numbers, files."""

import stat
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    ValidationError,
    ValidationInfo,
    model_validator,
)

from pidpanel.study.mistakes import Mistake, Mistakes, listed, mistakes_of
from pidpanel.study.quantity import Quantity, inside


class StudyError(ValueError):
    """Mistakes in a study file; each is one line that a user can act on."""


class SectionModel(BaseModel):
    """A frozen section of a study that refuses unknown keys."""

    # docstrings of keys are for the schema, which reads them itself: pydantic does at each import
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, defer_build=True)

    removed_keys: ClassVar[Mapping[str, str]] = {}  # keys of earlier versions, a message for each
    forms: ClassVar[tuple[tuple[str, ...], ...]] = ()  # keys that go together; one form is required
    needed: ClassVar[tuple[str, ...]] = ()  # keys of which at least one is required

    @model_validator(mode="wrap")
    @classmethod
    def _refuse(cls, values: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Return the section, or refuse it with all its mistakes."""
        present = values if isinstance(values, Mapping) else {}
        mistakes = [Mistake((key,), w) for key, w in cls.removed_keys.items() if key in present]
        if not mistakes:
            try:
                section = handler(values)
                mistakes = list(section._mistakes_of_keys()) or list(section.mistakes())
            except ValidationError as error:
                mistakes = list(mistakes_of(error, cls))
        if mistakes:
            raise Mistakes(mistakes, cls)
        return section

    def _mistakes_of_keys(self) -> Iterator[Mistake]:
        keys = {key for key in self.model_fields_set if getattr(self, key) is not None}
        present = keys.intersection(key for form in self.forms for key in form)
        if self.forms and present not in map(set, self.forms):
            forms = ", or ".join(map(listed, self.forms))
            yield Mistake((), f"must have either {forms}")
        if self.needed and not keys.intersection(self.needed):
            first, *alternatives = self.needed
            message = f"missing; required unless {' or '.join(alternatives)} is given"
            yield Mistake((first,), message)

    def mistakes(self) -> Iterator[Mistake]:
        """Yield what of the keys does not fit together; each is good on its own."""
        yield from ()


def _as_written(value: Any) -> Any:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return getattr(value, "written", repr(value)) if is_number else value


T = TypeVar("T")
# Text; a number in a file is the text that was written.
Text = Annotated[str, BeforeValidator(_as_written, json_schema_input_type=str | float)]
Fraction = Annotated[float, Quantity(0, 1, unit="percent")]
# Number of particles over that of a full cell, r = N/N_full.
Fill = Annotated[float, Quantity(0.02, 1, unit="percent")]
RelativeError = Annotated[float, inside(0, 1)]
PoissonsRatio = Annotated[float, inside(-1, 0.5)]
OVERALL = Quantity(60, 200, unit="level")
Level = Annotated[float, OVERALL]  # overall sound pressure level [dB re 20 µPa]
Coordinate = Annotated[float, Quantity(-100, 100, unit="metres")]  # x or y [m]
Size = Annotated[float, Quantity(1e-4, 30, unit="metres")]  # of anything on a panel [m]
# Steady acceleration along x, y and z of the panel [g].
_AlongAxis = Annotated[float, Quantity(-20, 20)]
Vector = tuple[float, float, float]
Acceleration = tuple[_AlongAxis, _AlongAxis, _AlongAxis]
# Density of a solid [kg/m³]: expanded foam to osmium.
Density = Annotated[float, Quantity(5, 25000, unit="density")]


def by_kind(default: str | None = None) -> tuple[Any, ...]:
    """Return the metadata of a key with alternatives: their ``kind`` tells them apart."""

    def with_kind(values: Any) -> Any:
        return {"kind": default, **values} if default and isinstance(values, Mapping) else values

    return Field(discriminator="kind"), BeforeValidator(with_kind)


def as_tuple(value: T | tuple[T, ...]) -> tuple[T, ...]:
    """Return one value or several as several.

    Examples
    --------
    >>> as_tuple(0.5), as_tuple((0.1, 0.9))
    ((0.5,), (0.1, 0.9))
    """
    return value if isinstance(value, tuple) else (value,)


def file_in(shipped: Path | None = None) -> AfterValidator:
    """Make a path one of a file that is there, where the folder of the study is known."""

    def find(name: Path, info: ValidationInfo) -> Path:
        context: dict[str, Any] = info.context or {}
        return found_file(name, context["folder"], shipped) if "folder" in context else name

    return AfterValidator(find)


def found_file(name: Path, folder: Path, shipped: Path | None) -> Path:
    """Return the path of a file that a study in a folder names.

    Raises
    ------
    ValueError
        If there is no such file; the files that come with pidpanel are listed.
    """
    for base in (folder, Path.cwd(), shipped):
        if base is None:
            continue
        try:
            mode = (base / name).stat().st_mode
        except (OSError, ValueError):  # not there, a name that is too long, a NUL in it
            continue
        if stat.S_ISDIR(mode):
            raise ValueError("is a folder; must be a file")
        if not stat.S_ISREG(mode):
            raise ValueError("must be a file")
        return base / name
    names = sorted(path.name for path in shipped.glob("*.*")) if shipped else []
    raise ValueError(
        "no such file; must be a path relative to the study"
        + (f", or one of {', '.join(names)}" if names else "")
    )
