"""What the models allow at a place of a study."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pydantic import BaseModel

from pidpanel.study.study import Study


def allowed_keys(location: Sequence[Any]) -> list[str]:
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
