"""What all sections of a study are made of: the model, its mistakes, ranges of numbers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, model_validator

from pidpanel.study.mistakes import Mistake, Mistakes


class StudyError(ValueError):
    """Mistakes in a study file; each is one line that a user can act on."""


class Model(BaseModel):
    """A frozen section of a study that refuses unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def mistakes(self) -> Iterator[Mistake]:
        """Yield what of the keys does not fit together; each is good on its own."""
        yield from ()

    @model_validator(mode="after")
    def _refuse(self) -> Self:
        found = tuple(self.mistakes())
        if found:
            raise Mistakes(found)
        return self


T = TypeVar("T")
Positive = Annotated[float, Field(gt=0)]
Fraction = Annotated[float, Field(ge=0, le=1)]
Fill = Annotated[float, Field(ge=0.02, le=1)]
"""Number of particles over that of a full cell, r = N/N_full."""


def as_tuple(value: T | tuple[T, ...]) -> tuple[T, ...]:
    """Return one value or several as several.

    Examples
    --------
    >>> as_tuple(0.5), as_tuple((0.1, 0.9))
    ((0.5,), (0.1, 0.9))
    """
    return value if isinstance(value, tuple) else (value,)
