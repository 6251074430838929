"""A key with alternatives has the mistakes of one of them: that of the form of its value."""

from typing import Annotated, get_args, get_origin

import pytest
from pydantic import BaseModel, Discriminator, TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from pidpanel.study import Study
from pidpanel.study.choice import Choice, keys_of
from pidpanel.study.damping_ratio import DampingRatios
from pidpanel.study.identify import Identification
from pidpanel.study.panel import Panel
from pidpanel.study.stated_number import OrStated
from pidpanel.study.sweep import Range, Sweep


def choices(annotation, metadata=(), seen=None):
    """Every choice in a type and in the models that it holds, with what is said of it."""
    seen = set() if seen is None else seen
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        if annotation not in seen:
            seen.add(annotation)
            for field in annotation.model_fields.values():
                yield from choices(field.annotation, (*field.metadata, field), seen)
        return
    members = get_args(annotation)
    if get_origin(annotation) is Annotated:
        yield from choices(members[0], members[1:], seen)
        return
    if type(annotation).__name__ in ("UnionType", "Union", "_UnionGenericAlias"):
        members = [member for member in members if member is not type(None)]
        if len(members) > 1:
            yield annotation, metadata
        else:
            yield from choices(members[0], metadata, seen)
            return
    for member in members:
        yield from choices(member, (), seen)


def chooses(metadata):
    return any(
        isinstance(one, Choice | Discriminator | OrStated)
        or (isinstance(one, FieldInfo) and one.discriminator is not None)
        for one in metadata
    )


@pytest.mark.parametrize(("model", "count"), [(Study, 10), (Identification, 2)])
def test_every_choice_of_a_study_says_how_it_chooses(model, count):
    found = list(choices(model))
    assert len(found) >= count
    assert [annotation for annotation, metadata in found if not chooses(metadata)] == []


@pytest.mark.parametrize(
    ("value", "at"),
    [
        (0.7, ()),
        ([0.7], (0,)),
        ([[100, 0.7]], (0, 1)),
        ("0.7", ()),
        ("seven", ()),
        ({}, ()),
    ],
)
def test_a_value_has_the_mistake_of_the_alternative_of_its_form(value, at):
    with pytest.raises(ValidationError) as caught:
        TypeAdapter(DampingRatios).validate_python(value)
    # pydantic counts the good items of a list only
    (item,) = (one for one in caught.value.errors() if one["type"] != "too_short")
    assert tuple(part for part in item["loc"] if isinstance(part, int)) == at


def test_a_value_of_no_form_is_told_what_is_allowed():
    with pytest.raises(ValueError, match="must be a mapping with keys from, to, step or a list"):
        Sweep(frequency_hz=5, acceleration_g=[1])


def test_a_key_has_its_name_in_a_study():
    assert keys_of(Range) == ["from", "to", "step"]
    assert "outline_m" in keys_of(Panel)
