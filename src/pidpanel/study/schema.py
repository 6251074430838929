"""What the models allow at a place of a study, and how pydantic names that place.

Where a model offers a choice (``Range | tuple[float, ...]``), the location of a mistake in
pydantic holds one part that nobody wrote: the name of the alternative that was tried. It can look
like any key of the user's, so it is found from the types, never from its spelling.
"""

from collections.abc import Mapping
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin

from pydantic import BaseModel

from pidpanel.study.mistakes import Keys


class Place(NamedTuple):
    """A place of a study."""

    keys: Keys  # way to it in the file
    types: tuple[Any, ...]  # several where there is a choice
    choice: Keys | None = None  # way to the last choice
    alternative: str = ""  # name that pydantic gives to the alternative it tried


def place_of(location: Keys, model: type[BaseModel]) -> Place:
    """Return the place of a pydantic location in a model.

    Examples
    --------
    >>> from pidpanel.study.panel import Panel
    >>> place_of(("points", "Node", "function-after[_refuse(), Node]", "grid"), Panel).keys
    ('points', 'Node', 'grid')
    """
    place = Place((), (model,))
    for part in location:
        if len(place.types) > 1:
            types = _alternatives(_named(place.types, str(part)))
            place = Place(place.keys, types, place.keys, str(part))
        else:
            types = _alternatives(_inside(place.types[0], part))
            place = place._replace(keys=(*place.keys, part), types=types)
    return place


def keys_of(model: Any) -> list[str]:
    """Return the keys of a model as a study writes them; none of any other type."""
    if not _is_model(model):
        return []
    return [field.alias or name for name, field in model.model_fields.items()]


def kinds_of(model: Any) -> tuple[str, ...]:
    """Return the values of ``kind`` that a model stands for."""
    field = model.model_fields.get("kind") if _is_model(model) else None
    return get_args(field.annotation) if field and get_origin(field.annotation) is Literal else ()


def lengths_of(types: tuple[Any, ...]) -> list[int]:
    """Return the numbers of values of the tuples of a set length among types."""
    arguments = [get_args(member) for member in types if get_origin(_bare(member)) is tuple]
    return [len(items) for items in arguments if ... not in items]


def _is_model(annotation: Any) -> bool:
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)


def _bare(annotation: Any) -> Any:
    """Return a type without its metadata and without ``None``, which is no choice."""
    if get_origin(annotation) is Annotated:
        return _bare(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        members = [member for member in get_args(annotation) if member is not NoneType]
        if len(members) == 1:
            return _bare(members[0])
    return annotation


def _alternatives(annotation: Any) -> tuple[Any, ...]:
    """Return the types between which a type chooses; itself if there is no choice."""
    bare = _bare(annotation)
    if get_origin(bare) in (Union, UnionType):
        return tuple(_bare(member) for member in get_args(bare) if member is not NoneType)
    return (bare,)


def _named(types: tuple[Any, ...], alternative: str) -> Any:
    """Return the type for which pydantic's name of an alternative stands.

    The name of a model is its class, with the validators round it, or the value of its ``kind``;
    that of a tuple begins with ``tuple``. No two tuples of a choice hold a choice themselves.
    """
    for option in types:
        if _is_model(option) and (
            alternative == option.__name__
            or alternative.endswith(f" {option.__name__}]")
            or alternative in kinds_of(option)
        ):
            return option
    plain = [option for option in types if not _is_model(option)]
    tuples = [option for option in plain if get_origin(option) is tuple]
    if "Path" in alternative:
        return next(option for option in plain if option is Path)
    return (tuples if "tuple[" in alternative else plain or types)[0]


def _inside(annotation: Any, part: str | int) -> Any:
    """Return the type at a key or an index of a type."""
    if _is_model(annotation):
        for name, field in annotation.model_fields.items():
            if part in (name, field.alias):
                return field.annotation
    arguments = get_args(annotation)
    if get_origin(annotation) is tuple and isinstance(part, int):
        return arguments[0] if ... in arguments else arguments[min(part, len(arguments) - 1)]
    if get_origin(annotation) is Mapping:
        return arguments[1]
    return Any
