"""The JSON schema of a study: what editors complete and check with."""

import copy

import jsonschema
import pytest
import yaml
from pydantic import BaseModel

from pidpanel.paths import PROJECT
from pidpanel.study import Study, StudyError, load_any_study
from pidpanel.study.document import Document
from pidpanel.study.json_schema import DRAFT, docstrings, study_schema

STUDIES = sorted((PROJECT / "workflow" / "studies").glob("*.yaml"))
SCHEMA = PROJECT / "workflow" / "schemas" / "study.schema.json"

COUPON = {"coupon": {"sweep": {"frequency_hz": [100], "acceleration_g": [10]}}}


@pytest.fixture(scope="module")
def validator():
    return jsonschema.Draft202012Validator(study_schema())


def models_below(model, found=None):
    """Every model that a study can hold."""
    found = {} if found is None else found
    if isinstance(model, type) and issubclass(model, BaseModel):
        if model not in found:
            found[model] = None
            for field in model.model_fields.values():
                models_below(field.annotation, found)
    else:
        for one in getattr(model, "__args__", ()):
            models_below(one, found)
    return list(found)


def test_every_key_of_every_model_is_told():
    models = models_below(Study)
    assert len(models) > 25
    untold = [
        f"{model.__name__}.{name}"
        for model in models
        for name, field in model.model_fields.items()
        if not docstrings(model).get(field.alias or name, "").rstrip().endswith(".")
    ]
    assert untold == []


def test_the_schema_is_one_of_its_draft():
    assert study_schema()["$schema"] == DRAFT
    jsonschema.Draft202012Validator.check_schema(study_schema())


def test_the_schema_has_every_model_and_key():
    schema = study_schema()
    told = {name: set(one["properties"]) for name, one in schema["$defs"].items()}
    told["Study"] = set(schema["properties"]) - {"structure"}  # which stands for a panel
    told["Structure"].add("kind")
    for model in models_below(Study):
        keys = {field.alias or name for name, field in model.model_fields.items()}
        assert told[model.__name__] == keys


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_every_shipped_study_validates_and_names_the_schema(validator, path):
    assert [one.message for one in validator.iter_errors(Document(path).data)] == []
    first, _, schema = path.read_text(encoding="utf-8").partition("\n")[0].partition("$schema=")
    assert first == "# yaml-language-server: "
    assert (path.parent / schema).resolve() == SCHEMA


def _of_law(way, value):
    def change(values):
        *path, last = way
        for key in path:
            values = values[key]
        values[last] = value
        return values

    return change


def _without(*way):
    def change(values):
        *path, last = way
        for key in path:
            values = values[key]
        del values[last]

    return change


SPRING = {"outline": "free", "points": {"a": {"kind": "rope", "at_m": [0, 0]}}}
WRONG = {
    "an unknown section": _of_law(["pannel"], {}),
    "an unknown key": _of_law(["panel", "mesh", "element"], [2, 2]),
    "text for a number": _of_law(["panel", "damping_ratio"], "one per cent"),
    "a number beyond its range": _of_law(["panel", "damping_ratio"], 0.7),
    "a number at an open end": _of_law(["panel", "damping_ratio"], 0),
    "a position of three": _of_law(["panel", "points", "centre"], [0.1, 0.2, 0.3]),
    "no points": _of_law(["panel", "points"], {}),
    "an unknown kind of a section": _of_law(["panel", "section", "kind"], "thick"),
    "a key of another kind of section": _of_law(["panel", "section", "density_kg_m3"], 1),
    "an unknown kind of a support": _of_law(["panel", "supports"], SPRING),
    "a law that there is not": _of_law(["dampers", "paper", "law"], "papre"),
    "fills in percent": _of_law(["scenarios", "fill", "fill_fraction"], [30, 80]),
    "a family and a layout in one": _of_law(["scenarios", "fill", "layout"], {"PID-1": {}}),
    "a panel without sound": _without("sound"),
    "a panel without points": _without("panel", "points"),
    "a panel missing": _without("panel"),
    "a range without an end": _of_law(
        ["coupon"], {"sweep": {"frequency_hz": {"from": 1, "step": 1}, "acceleration_g": [1]}}
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_a_study_must_not_have_the_schema_refuses_too(
    validator, law_values, write_study, tmp_path, name
):
    values = law_values()
    assert validator.is_valid(values)
    WRONG[name](values)
    assert not validator.is_valid(values)
    with pytest.raises(StudyError):
        load_any_study(write_study(tmp_path, "wrong", values))


def _with_group(values):
    values["panel"]["patches"]["PID-1"] = {"group": 2}


RIGHT = {
    "a coupon alone": (lambda values: (values.clear(), values.update(copy.deepcopy(COUPON)))),
    "a thin section without its kind": _without("panel", "section", "kind"),
    "a group that is a number": _with_group,
    "one level for a family of patches": _of_law(["scenarios", "place", "oaspl_db"], 145),
    "no name": lambda values: values.pop("name", None),
}


@pytest.mark.parametrize("name", RIGHT)
def test_what_a_study_may_have_the_schema_allows(validator, law_values, name):
    values = law_values()
    RIGHT[name](values)
    assert [one.message for one in validator.iter_errors(values)] == []


def test_a_study_of_nothing_is_refused(validator):
    assert not validator.is_valid({"title": "Nothing"})
    assert validator.is_valid(yaml.safe_load(yaml.safe_dump(COUPON)))
