"""The names that pydantic gives to alternatives are known for every choice of a study."""

from typing import Annotated, Any, Union, get_args, get_origin

import pytest
from pydantic import BaseModel, TypeAdapter, ValidationError

from pidpanel.study import Study
from pidpanel.study.panel import Panel
from pidpanel.study.schema import keys_of, place_of


def choices_of(annotation, seen):
    """Every choice in a type and in the models that it holds, each as a tuple of types."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        if annotation not in seen:
            seen.add(annotation)
            for field in annotation.model_fields.values():
                yield from choices_of(field.annotation, seen)
        return
    members = get_args(annotation)
    if type(annotation).__name__ in ("UnionType", "Union", "_UnionGenericAlias"):
        choice = tuple(one for one in members if one is not type(None))
        if len(choice) > 1:
            yield choice
    for member in members:
        yield from choices_of(member, seen)


CHOICES = list(dict.fromkeys(choices_of(Study, set())))


def bare(annotation):
    return bare(get_args(annotation)[0]) if get_origin(annotation) is Annotated else annotation


def test_the_choices_of_a_study_are_found():
    # red: `return` in choices_of before its members
    assert len(CHOICES) >= 8


@pytest.mark.parametrize("choice", CHOICES, ids=range(len(CHOICES)))
def test_pydantics_name_of_each_alternative_leads_to_it(choice):
    # red: `alternative == one.__name__` alone in schema._named
    class Holder(BaseModel):
        held: Union[choice]  # noqa: UP007 - of a tuple of types

    with pytest.raises(ValidationError) as caught:
        TypeAdapter(Holder).validate_python({"held": object()})
    names = list(dict.fromkeys(item["loc"][1] for item in caught.value.errors()))
    assert len(names) == len(choice)
    for name, one in zip(names, choice, strict=True):
        (found,) = place_of(("held", name), Holder).types
        if get_origin(bare(one)) is tuple:
            assert get_origin(found) is tuple
        else:
            assert found == bare(one)


@pytest.mark.parametrize("choice", CHOICES, ids=range(len(CHOICES)))
def test_two_lists_of_a_choice_hold_no_choice(choice):
    # their names are not told apart; red: a field `tuple[int | str, ...] | tuple[float, float]`
    lists = [one for one in map(bare, choice) if get_origin(one) is tuple]
    assert len(lists) < 2 or not any(list(choices_of(one, set())) for one in lists)


def test_the_place_of_a_location_has_the_keys_of_the_file():
    # red: `types` of the whole choice in place_of
    place = place_of(
        ("supports", "function-after[_refuse(), SupportsInput]", "points", "[key]"), Panel
    )
    assert place.keys == ("supports", "points", "[key]")
    assert place.choice == ("supports",)
    assert keys_of(place.types[0])[:2] == ["kind", "at_m"]
    assert place_of(("section", "thin", "thickness_mm"), Panel).keys == ("section", "thickness_mm")
    assert place_of(("outline_m", "tuple[a]", 3, 1), Panel).keys == ("outline_m", 3, 1)


def test_what_is_no_model_has_no_keys():
    # red: keys_of without its first branch
    assert keys_of(Any) == []
