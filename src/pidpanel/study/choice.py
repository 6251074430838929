"""A key with alternatives, such as a number or a list: the form of its value chooses one of them.

Pydantic alone would try all of them, and report the mistakes of each.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import BaseModel, GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

from pidpanel.columns import NUMBER

TAG = "\0"  # how alternatives begin in the locations of pydantic, as no key of a file does


def keys_of(model: type[BaseModel]) -> list[str]:
    """Return the keys of a model as a study writes them."""
    return [field.alias or name for name, field in model.model_fields.items()]


def kinds_of(model: type[BaseModel] | None) -> tuple[str, ...]:
    """Return the values of ``kind`` of a model."""
    field = model.model_fields.get("kind") if model else None
    return get_args(field.annotation) if field else ()


class Choice:
    """For the annotation of a key: ``Annotated[float | tuple[float, ...], Choice()]``.

    A path is the alternative of texts that are no numbers; a tuple of tuples is that of nested
    lists.
    """

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Return the schema for the choice in pydantic."""
        options = {f"{TAG}{number}": option for number, option in enumerate(get_args(source))}
        alternatives = {tag: _alternative(_bare(option)) for tag, option in options.items()}
        tags = {form: tag for tag, (forms, _) in alternatives.items() for form in forms}

        def tag_of(value: Any) -> str | None:
            return tags.get(_form_of(value))

        message = f"must be {' or '.join(words for _, words in alternatives.values())}"

        def schema_of(option: Any) -> CoreSchema:
            schema = handler(option)
            if get_origin(_bare(option)) is not Literal:
                return schema
            # an unknown word gets the message that lists all forms
            return core_schema.custom_error_schema(schema, "choice", custom_error_message=message)

        return core_schema.tagged_union_schema(
            {tag: schema_of(option) for tag, option in options.items()},
            tag_of,
            custom_error_type="choice",
            custom_error_message=message,
        )


def _form_of(value: Any) -> str:
    if isinstance(value, Mapping | BaseModel):
        return "mapping"
    if isinstance(value, list | tuple):
        return "nested list" if value and isinstance(value[0], list | tuple) else "list"
    is_number = not isinstance(value, str | Path) or bool(NUMBER.fullmatch(str(value)))
    return "number" if is_number else "text"


def _alternative(option: Any) -> tuple[tuple[str, ...], str]:
    """Return the forms of values that an alternative takes, and its words."""
    if get_origin(option) is tuple:
        is_nested = get_origin(_bare(get_args(option)[0])) is tuple
        return ("nested list" if is_nested else "list",), "a list"
    if isinstance(option, type) and issubclass(option, BaseModel):
        return ("mapping",), f"a mapping with keys {', '.join(keys_of(option))}"
    if get_origin(option) is Literal:
        return ("text", "number"), ", ".join(map(repr, get_args(option)))
    if option is Path:
        return ("text",), "a path"
    return ("text", "number"), "text" if option is str else "a number"


def _bare(annotation: Any) -> Any:
    """Return a type without its metadata."""
    return get_args(annotation)[0] if get_origin(annotation) is Annotated else annotation
