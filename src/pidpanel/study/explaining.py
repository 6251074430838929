"""The mistakes that pydantic finds, at the keys of the file and in a reader's words."""

from collections.abc import Iterator, Mapping
from typing import get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from pidpanel.study.choice import TAG, keys_of, kinds_of
from pidpanel.study.mistakes import Keys, Mistake, Mistakes, unknown_key

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
        values = f"{count} value{'' if count == 1 else 's'}"
        return f"must have at {extreme} {values}, not {context['actual_length']}"
    if "says" in context:  # of a `Quantity`
        return str(context["says"])
    if error["type"] in PYDANTIC_WORDS:
        return PYDANTIC_WORDS[error["type"]].format(**context)
    message = error["msg"].removeprefix("Value error, ")
    return message.replace("Input should be ", "must be ", 1)


def mistakes_of(error: ValidationError, model: type[BaseModel]) -> Iterator[Mistake]:
    """Yield the mistakes in the values of a model, those that its sections have found too."""
    items = {_keys_of(item): item for item in error.errors(include_url=False)}
    reported: set[tuple[Keys, str]] = set()
    for keys, item in items.items():
        refused = item.get("ctx", {}).get("error")
        if isinstance(refused, Mistakes):
            yield from (mistake.prefix(*keys) for mistake in refused.mistakes)
        elif item["type"] == "too_short" and any(
            len(inner) > len(keys) and inner[: len(keys)] == keys for inner in items
        ):
            continue  # pydantic counts the good items only
        else:
            mistake = _mistake_at(keys, item, model)
            # of the items of a list with the same mistake the first stands for all
            around = keys[:-1] if keys and isinstance(keys[-1], int) else keys
            if (alike := (around, mistake.says.partition(";")[0])) not in reported:
                yield mistake
            reported.add(alike)


def _keys_of(item: ErrorDetails) -> Keys:
    """Return the way to a mistake, without the names of alternatives; a short list as a whole."""
    keys = tuple(part for part in item["loc"] if not str(part).startswith(TAG))
    refused = item.get("ctx", {}).get("error")
    # a section that is chosen by its kind has that after its key
    is_kind = isinstance(refused, Mistakes) and kinds_of(refused.model) == keys[-1:]
    is_short = item["type"] == "missing" and isinstance(keys[-1], int)
    return keys[:-1] if is_kind or is_short else keys


def _mistake_at(keys: Keys, item: ErrorDetails, model: type[BaseModel]) -> Mistake:
    kind = item["type"]
    if kind == "extra_forbidden":
        return Mistake(keys, unknown_key(str(keys[-1]), keys_of(model)))
    if kind == "model_type":
        return Mistake(keys, f"must be a mapping with keys {', '.join(keys_of(model))}")
    if kind == "union_tag_not_found" and not isinstance(item["input"], Mapping):
        return Mistake(keys, PYDANTIC_WORDS["model_attributes_type"])
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        options = get_args(model.model_fields[str(keys[0])].annotation)
        *kinds, last = [repr(name) for option in options for name in kinds_of(option)]
        missing = "missing; " if kind == "union_tag_not_found" else ""
        return Mistake((*keys, "kind"), f"{missing}must be {', '.join(kinds)} or {last}")
    if kind == "missing" and isinstance(item["loc"][-1], int):
        length, count = item["loc"][-1] + 1, len(item["input"])
        return Mistake(keys, f"must have at least {length} values, not {count}")
    return Mistake(keys, in_words(item))
