"""What all sections of a study are made of."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field


class StudyError(ValueError):
    """A mistake in a study file; the text is one line a user can act on."""


class Model(BaseModel):
    """Frozen, and closed against keys it does not know."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


Positive = Annotated[float, Field(gt=0)]
Fraction = Annotated[float, Field(ge=0, le=1)]
Fill = Annotated[float, Field(ge=0.02, le=1)]
