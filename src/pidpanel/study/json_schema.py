"""The JSON schema of a study (draft 2020-12), made from the models.

Editors complete and check a study with it. It has keys, types, ranges and required keys.
`pidpanel check` also checks keys against each other and the files that they name.
"""

import ast
import inspect
import json
import re
from itertools import pairwise
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema

from pidpanel.study.coupon_study import CouponStudy
from pidpanel.study.structure import KEY
from pidpanel.study.study import Study

DRAFT = "https://json-schema.org/draft/2020-12/schema"


class _Plain(GenerateJsonSchema):
    """Without titles of keys, which only repeat their names, and with their docstrings."""

    def field_title_should_be_set(self, schema: Any) -> bool:
        return False

    def tagged_union_schema(self, schema: Any) -> Any:
        described = super().tagged_union_schema(schema)
        described.pop("discriminator", None)  # no JSON schema has it
        return described

    def model_schema(self, schema: Any) -> Any:
        described = super().model_schema(schema)
        if "description" in described:
            described["description"] = _sentences(described["description"])
        for key, text in docstrings(schema["cls"]).items():
            described["properties"][key].setdefault("description", _sentences(text))
        return described


def docstrings(model: type[BaseModel]) -> dict[str, str]:
    """Return the docstrings of the keys of a model, those that it inherits too."""
    texts: dict[str, str] = {}
    for base in reversed(model.__mro__):
        if not issubclass(base, BaseModel) or base is BaseModel:
            continue
        (statement,) = ast.parse(inspect.getsource(base)).body
        for key, text in pairwise(getattr(statement, "body", ())):
            match key, text:
                case (
                    ast.AnnAssign(target=ast.Name(id=name)),
                    ast.Expr(value=ast.Constant(value=str(words))),
                ) if name in model.model_fields:
                    texts[model.model_fields[name].alias or name] = inspect.cleandoc(words)
    return texts


def study_schema() -> dict[str, Any]:
    """Return the schema of a study file.

    A file with ``coupon`` and nothing of a panel is a study of the coupon alone; ``name`` is that
    of the file unless it is given.

    Examples
    --------
    >>> study_schema()["then"]["anyOf"]
    [{'required': ['sound']}, {'required': ['base']}]
    """
    schema = Study.model_json_schema(schema_generator=_Plain)
    panel, structure = schema["properties"]["panel"].pop("oneOf")
    schema["properties"]["panel"] |= panel
    meaning = {"description": "A structure of any shape in place of the panel."}
    schema["properties"][KEY] = structure | meaning
    schema["$defs"]["Structure"]["properties"].pop("kind")
    panel_keys = [key for key in Study.model_fields if key not in CouponStudy.model_fields]
    panel_keys.append(KEY)
    schema.pop("required")
    either = {"oneOf": [{"required": ["panel"]}, {"required": [KEY]}]}
    return {
        "$schema": DRAFT,
        **schema,
        "title": "A study of pidpanel",
        "if": {"anyOf": [{"required": [key]} for key in panel_keys]},
        "then": {"allOf": [either], "anyOf": [{"required": ["sound"]}, {"required": ["base"]}]},
        "else": {"required": ["coupon"]},
    }


def schema_text() -> str:
    """Return the schema as the text of its file."""
    return json.dumps(study_schema(), indent=1, ensure_ascii=False) + "\n"


def _sentences(text: str) -> str:
    r"""Return a docstring as running text.

    Examples
    --------
    >>> _sentences("Wall thickness of\nhollow ``particles``.\n\nNotes\n-----\nNone.")
    'Wall thickness of hollow `particles`.'
    """
    text = re.split(r"\n\s*\n\w+\n-+\n", text)[0]
    return " ".join(text.replace("``", "`").split())
