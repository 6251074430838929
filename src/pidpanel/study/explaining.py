"""The mistakes that pydantic finds, at the keys of the file and in a reader's words."""

from collections.abc import Iterator, Mapping, Sequence

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from pidpanel.study.mistakes import Keys, Mistake, Mistakes, dotted, unknown_key
from pidpanel.study.schema import Place, keys_of, kinds_of, lengths_of, place_of

# Words for the types of mistake that pydantic finds; all others are given in its own.
PYDANTIC_WORDS = {
    "missing": "missing",
    "dict_type": "must be a mapping",
    "model_attributes_type": "must be a mapping with a key kind",
    "tuple_type": "must be a list",
    "string_type": "must be text",
    "path_type": "must be a path",
    "bool_type": "must be true or false",
    "bool_parsing": "must be true or false",
    "literal_error": "must be {expected}",
}


def _values(count: int) -> str:
    return f"{count} value{'' if count == 1 else 's'}"


def in_words(error: ErrorDetails) -> str:
    """Return what pydantic says of a mistake, in the words of a study's reader.

    Examples
    --------
    >>> from pydantic import TypeAdapter, ValidationError
    >>> try:
    ...     TypeAdapter(str).validate_python(3)
    ... except ValidationError as refused:
    ...     in_words(refused.errors()[0])
    'must be text'
    """
    context = error.get("ctx", {})
    if error["type"] in ("too_short", "too_long"):
        extreme, bound = ("least", "min") if error["type"] == "too_short" else ("most", "max")
        count = context[f"{bound}_length"]
        return f"must have at {extreme} {_values(count)}, not {context['actual_length']}"
    if "says" in context:  # of a `Quantity`
        return str(context["says"])
    if error["type"] in PYDANTIC_WORDS:
        return PYDANTIC_WORDS[error["type"]].format(**context)
    message = error["msg"].removeprefix("Value error, ")
    return message.replace("Input should be ", "must be ", 1)


PlacedError = tuple[Place, ErrorDetails]


def mistakes_of(error: ValidationError, model: type[BaseModel]) -> list[Mistake]:
    """Return the mistakes in the values of a model.

    What is said of one key comes from the alternatives of a choice, and is joined.
    """
    errors = [(place_of(item["loc"], model), item) for item in error.errors()]
    errors = list(_of_alternatives_meant(errors))
    of_models: list[Mistake] = []
    messages: dict[Keys, list[str]] = {}
    for place, item in errors:
        refused = item.get("ctx", {}).get("error")
        if isinstance(refused, Mistakes):
            of_models += [mistake.prefix(*place.keys) for mistake in refused.mistakes]
        elif item["type"] == "too_short" and any(_is_inside(inner, place) for inner, _ in errors):
            continue  # pydantic counts the good items only
        else:
            mistake = _mistake_at(place, item, model)
            messages.setdefault(mistake.keys, []).append(mistake.says)
    joined = [Mistake(keys, _joined(words)) for keys, words in messages.items()]
    return [*_likewise(joined), *of_models]


def _likewise(mistakes: Sequence[Mistake]) -> Iterator[Mistake]:
    """Yield mistakes, those of the items of a list that say the same as one."""
    alike: dict[tuple[Keys, str], list[Mistake]] = {}
    for mistake in mistakes:
        # the allowed range is the same, the value in another unit is not
        says = mistake.says.partition(";")[0]
        last = mistake.keys[-1] if mistake.keys else ""
        in_list = isinstance(last, int) and says.startswith("must be")
        alike.setdefault((mistake.keys[:-1] if in_list else mistake.keys, says), []).append(mistake)
    for (keys, _), (first, *repeated) in alike.items():
        places = [dotted(mistake.keys[len(keys) :]) for mistake in repeated]
        remainder = f" and {len(places) - 3} more" if len(places) > 4 else ""
        places = places[:3] if remainder else places
        says = f"{first.says}; likewise {', '.join(places)}{remainder}" if places else first.says
        yield first._replace(says=says)


def _joined(words: Sequence[str]) -> str:
    first, *options = dict.fromkeys(words)
    return " or ".join((first, *(option.removeprefix("must be ") for option in options)))


def _is_inside(place: Place, outer: Place) -> bool:
    return len(place.keys) > len(outer.keys) and place.keys[: len(outer.keys)] == outer.keys


def _mistake_at(place: Place, item: ErrorDetails, model: type[BaseModel]) -> Mistake:
    if item["type"] == "extra_forbidden":
        (section,) = place_of(item["loc"][:-1], model).types
        if place.keys[:-1] and place.keys[-1] in keys_of(model):
            says = f"{place.keys[-1]} is a top-level section; do not indent its line"
            return Mistake(place.keys, f"unknown key; {says}")
        return Mistake(place.keys, unknown_key(str(place.keys[-1]), keys_of(section)))
    if item["type"] == "union_tag_not_found" and not isinstance(item["input"], Mapping):
        return Mistake(place.keys, PYDANTIC_WORDS["model_attributes_type"])
    if item["type"] in ("union_tag_invalid", "union_tag_not_found"):
        kinds = [repr(kind) for annotation in place.types for kind in kinds_of(annotation)]
        missing = "missing; " if item["type"] == "union_tag_not_found" else ""
        allowed = f"{', '.join(kinds[:-1])} or {kinds[-1]}"
        return Mistake((*place.keys, "kind"), f"{missing}must be {allowed}")
    if item["type"] == "model_type":
        keys = ", ".join(keys_of(place.types[0]))
        return Mistake(place.keys, f"must be a mapping with keys {keys}")
    if item["type"] in ("missing", "too_long"):
        *parents, last = item["loc"]
        short = item["type"] == "missing" and isinstance(last, int)
        around = place_of(tuple(parents), model) if short else place
        lengths = lengths_of(around.types)
        if lengths:
            says = f"must have {_values(lengths[0])}, not {len(item['input'])}"
            return Mistake(around.keys, says)
    return Mistake(place.keys, in_words(item))


def _of_alternatives_meant(errors: Sequence[PlacedError]) -> Iterator[PlacedError]:
    """Yield what concerns the alternative of a choice that the writer meant.

    Pydantic lists the mistakes of every alternative. The one that is meant accepts the kind of
    value that is there (a list, a mapping, a number) and, if possible, the kinds within it and its
    number of items, and has the fewest mistakes. Where none accepts it, all say what they would.
    """
    choices: dict[Keys | None, dict[str, list[PlacedError]]] = {}
    for place, item in errors:
        choices.setdefault(place.choice, {}).setdefault(place.alternative, []).append((place, item))
    for choice, alternatives in choices.items():
        fitting = [
            mistakes
            for mistakes in alternatives.values()
            if not any(
                place.keys == choice and _needs_another_kind(item) for place, item in mistakes
            )
        ]
        if fitting:
            yield from min(fitting, key=lambda mistakes: _distance(mistakes, choice))
        else:
            yield from (error for mistakes in alternatives.values() for error in mistakes)


def _distance(errors: Sequence[PlacedError], choice: Keys | None) -> tuple[int, int, int]:
    """Return how far an alternative is from what is there: kinds, then itself, then mistakes."""
    kinds = sum(_needs_another_kind(item) for _, item in errors)
    return kinds, sum(place.keys == choice for place, _ in errors), len(errors)


def _needs_another_kind(item: ErrorDetails) -> bool:
    return item["type"].endswith(("_type", "_parsing")) or item["type"] == "literal_error"
