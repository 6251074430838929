"""Pages and the JSON schema that are made from the code and checked in; `make reference`.

`study.md` comes from the models of a study, `files.md` from `files.yaml`, `commands.md` from the
commands.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import pandas as pd
import xarray as xr
import yaml

from pidpanel.cli.commands import EPILOG, pidpanel
from pidpanel.study.coupon import Coupon
from pidpanel.study.json_schema import schema_text, study_schema

DOCS = Path(__file__).parent
FILES = DOCS / "reference" / "files.yaml"
SCHEMA = DOCS.parent / "workflow" / "schemas" / "study.schema.json"

VARIED = "<key of vary>"
"""Column of a key that a study varies."""

UNITS = {
    "_n_s_m3": "N s/m³", "_kg_m2": "kg/m²", "_kg_m3": "kg/m³", "_j_m2": "J/m²", "_m_s": "m/s",
    "_n_m": "N/m", "_pa2_hz": "Pa²/Hz", "_g2_hz": "g²/Hz", "_m2_s2_hz": "m²/s²/Hz",
    "_mm2_hz": "mm²/Hz", "_mpa": "MPa", "_gpa": "GPa", "_percent": "%", "_deg": "°", "_hz": "Hz",
    "_mm": "mm", "_db": "dB", "_kg": "kg", "_m2": "m²", "_g": "g", "_m": "m", "_s": "s",
    "_n2_hz": "N²/Hz", "_n": "N", "g_rms": "g", "g_rms_error": "g",
}  # fmt: skip
"""Units by the ends of names."""
UNIT_OF = {"bending_stiffness_n_m": "N m"}
"""Where the end of a name says something else."""


def unit_of(name: str) -> str:
    """Return the unit that the name of a key or column holds; empty for none."""
    name = re.sub(r"_?<.*>$", "", name)
    if name in UNIT_OF:
        return UNIT_OF[name]
    ends = [end for end in UNITS if name.endswith(end)]
    return UNITS[max(ends, key=len)].replace(" ", "\N{NO-BREAK SPACE}") if ends else ""


# ------------------------------------------------------------------------- keys of a study


def study_page() -> str:
    """Return the page of every key of a study."""
    schema = study_schema()
    models = {"Study": schema, **schema["$defs"]}
    lines = [
        "<!-- made by `make reference` from src/pidpanel/study: change it there -->",
        "",
        "# Every key of a study",
        "",
        "A study is one YAML file. Units are in the names of the keys. Unknown keys and values "
        "outside the allowed range are refused; one line names key, value and range (`pidpanel "
        "check`). *Required* marks keys without a default. A section whose keys all have defaults "
        "may be omitted.",
        "",
        "Editors with JSON schema support complete and check a study. Its first line is "
        "`# yaml-language-server: $schema=` and the path of "
        "[study.schema.json](../../workflow/schemas/study.schema.json).",
        "",
    ]
    titles = {name: _title(name, ways, models[name]) for name, ways in _ways(models).items()}
    anchors = {name: _slug(title) for name, title in titles.items()}
    for name, title in titles.items():
        with_panel = ["panel"] if name == "Study" else []
        lines += _section(name, title, models[name], anchors, with_panel)
    return "\n".join(lines).rstrip() + "\n"


def _ways(models: dict[str, Any]) -> dict[str, list[str]]:
    """Return where each model stands in a study, models in the order of the file."""
    found: dict[str, list[str]] = {}

    def walk(name: str, way: str) -> None:
        found.setdefault(name, []).append(way)
        for key, node in models[name]["properties"].items():
            for other, below in _models_in(node):
                if name != "Damper" or other != "Coupon":  # its keys are those of `coupon`
                    walk(other, f"{way}.{key}{below}".removeprefix("."))

    walk("Study", "")
    return found


def _models_in(node: Any, below: str = "") -> Iterator[tuple[str, str]]:
    """Yield the models of a node and how they lie below it."""
    if "$ref" in node:
        yield node["$ref"].rsplit("/", 1)[-1], below
    for one in [*node.get("anyOf", ()), *node.get("oneOf", ())]:
        yield from _models_in(one, below)
    if isinstance(node.get("items"), dict):
        yield from _models_in(node["items"], f"{below}[]")
    if isinstance(node.get("additionalProperties"), dict):
        yield from _models_in(node["additionalProperties"], f"{below}.<name>")


def _title(name: str, ways: list[str], model: dict[str, Any]) -> str:
    """Return the heading of a model, which no other has."""
    title = " and ".join(f"`{way}`" for way in dict.fromkeys(ways) if way) or "The file"
    kind = model["properties"].get("kind", {}).get("const")
    if kind:
        return f"{title}, kind `{kind}`"
    return f"{title}, a {name.lower()}" if name in ("Family", "Layout") else title


def _slug(title: str) -> str:
    """Return the anchor of a heading, as GitHub and MyST make it."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def _section(
    name: str, title: str, model: dict[str, Any], anchors: dict[str, str], with_panel: list[str]
) -> Iterator[str]:
    yield f"## {title}"
    yield ""
    if name != "Study":
        yield model["description"]
        yield ""
    if name == "Coupon":
        yield "The coupon of a damper, `dampers.<name>.coupon`, has the same keys except `vary` and"
        yield "`cases`."
        yield ""
    yield "| key | type, allowed | default | meaning |"
    yield "|---|---|---|---|"
    required = model.get("required", [])
    for key, node in model["properties"].items():
        kind = _type(node, anchors) + (f" [{unit_of(key)}]" if unit_of(key) else "")
        cells = [
            f"`{key}`",
            "; ".join(dict.fromkeys([kind, *_allowed(node)])),
            _default(key, node, key in required, key in with_panel),
            node["description"],
        ]
        yield "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
    yield ""


def _type(node: dict[str, Any], anchors: dict[str, str]) -> str:
    """Return in words what may stand at a key."""
    if "$ref" in node:
        name = node["$ref"].rsplit("/", 1)[-1]
        return f"[section](#{anchors[name]})"
    choices = [
        one for one in [*node.get("anyOf", ()), *node.get("oneOf", ())] if one.get("type") != "null"
    ]
    if choices:
        if all("$ref" in one for one in choices):
            names = (one["$ref"].rsplit("/", 1)[-1] for one in choices)
            return "section: " + " or ".join(f"[{_short(n)}](#{anchors[n]})" for n in names)
        return " or ".join(dict.fromkeys(_type(one, anchors) for one in choices))
    if "const" in node:
        return f"`{node['const']}`"
    if "enum" in node:
        return "one of " + ", ".join(f"`{one}`" for one in node["enum"])
    kind = node.get("type")
    if kind == "array":
        if "prefixItems" in node:
            inside = list(dict.fromkeys(_type(one, anchors) for one in node["prefixItems"]))
            return f"{len(node['prefixItems'])} × {' or '.join(inside)}"
        return f"list of {_type(node['items'], anchors) if node.get('items') else 'values'}"
    if kind == "object":
        return f"mapping of names to {_type(node['additionalProperties'], anchors)}"
    if node.get("format") == "path":
        return "path"
    words = {"number": "number", "integer": "whole number", "boolean": "true or false"}
    return words.get(str(kind), "text" if kind == "string" else "any value")


def _short(name: str) -> str:
    return re.sub(
        r"(?<!^)([A-Z])", r" \1", name.removesuffix("Input").removesuffix("Section")
    ).lower()


def _allowed(node: dict[str, Any]) -> Iterator[str]:
    """Yield the ranges of a key and of what it holds."""
    bounds = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}
    found = [
        f"{sign}\N{NO-BREAK SPACE}{_number(node[bound])}"
        for bound, sign in bounds.items()
        if bound in node
    ]
    if found:
        yield " and ".join(found)
    if "prefixItems" not in node and node.get("minItems"):
        yield f"at least {node['minItems']}"
    if node.get("minProperties"):
        yield f"at least {node['minProperties']}"
    below = [*node.get("anyOf", ()), *node.get("oneOf", ()), *node.get("prefixItems", ())]
    below += [node[key] for key in ("items", "additionalProperties") if node.get(key)]
    for one in below:
        if isinstance(one, dict) and "$ref" not in one:
            yield from _allowed(one)


def _number(value: float) -> str:
    text = str(int(value)) if value == int(value) else f"{value:g}"
    return text.replace("-", "−")


def _default(key: str, node: dict[str, Any], required: bool, with_panel: bool) -> str:
    if with_panel:
        return "*required* with a panel"
    if required:
        return "*required*"
    if key == "name":
        return "the name of the file"
    value = node.get("default")
    if isinstance(value, dict) and value:
        return "see section"
    if value in (None, "", [], {}):
        return "–"
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    return f"`{value}`"


# -------------------------------------------------------------------------- files of results


def files_page() -> str:
    """Return the page of every column and variable of the results."""
    lines = [
        "<!-- made by `make reference` from files.yaml: change it there -->",
        "",
        "# Every column of every file",
        "",
        "Files are in `results/<study>/`. Tables are CSV with a header line; an empty cell is a "
        "missing value. NetCDF files have units in the attribute `units`. They carry the name and "
        "hash of the study and the versions of pidpanel and LIGGGHTS. PSDs are one-sided, per Hz. "
        "If a study has several coupons, each except `coupon` has a folder named after its damper "
        "(`coupon/<damper>/cases.csv`).",
        "",
    ]
    for one in yaml.safe_load(FILES.read_text(encoding="utf-8")):
        columns, variables = one.get("columns", {}), one.get("variables", {})
        lines += [
            f"## `{one['file']}`",
            "",
            one["of"],
            "",
            "| name | unit | meaning |",
            "|---|---|---|",
        ]
        lines += [f"| `{name}` | {unit_of(name)} | {text} |" for name, text in columns.items()]
        lines += [
            f"| `{name}` | {_plain(unit)} | {text} |" for name, (unit, text) in variables.items()
        ]
        lines.append("")
    return "\n".join(lines).rstrip() + "\n"


def _plain(unit: str) -> str:
    return "" if unit == "1" else unit


# -------------------------------------------------------------------------- command line


def commands_page() -> str:
    """Return the page of the commands."""
    lines = [
        "<!-- made by `make reference` from src/pidpanel/cli: change it there -->",
        "",
        "# Commands",
        "",
        "Commands in the order of use; `pidpanel <command> --help` prints the same text.",
        "",
        "```text",
        EPILOG,
        "```",
        "",
    ]
    for name, command in pidpanel.commands.items():
        if command.hidden:
            continue
        text = inspect.cleandoc(command.help or "").replace("$", "\\$")
        lines += [f"## `pidpanel {name}`", "", text, "", "| argument | meaning |", "|---|---|"]
        context = click.Context(command, info_name=name)
        for parameter in command.params:
            if record := parameter.get_help_record(context):
                shown, words = (" ".join(part.split()).replace("|", "\\|") for part in record)
                lines += [f"| `{shown}` | {words} |"] if shown else []
        lines.append("")
    return "\n".join(lines).rstrip() + "\n"


def untold(results: Path, way: str = "") -> tuple[list[str], list[str]]:
    """Compare the files of a study with their description.

    Parameters
    ----------
    results
        Its folder, or that of all coupons.
    way
        From the folder of a study to that folder.

    Returns
    -------
    untold
        Files, columns and variables that are not described, or with another unit.
    stale
        Columns and variables that are described and not there; some are there in some studies
        only.
    """
    described = yaml.safe_load(FILES.read_text(encoding="utf-8"))
    missing, stale = [], []
    for path in sorted(results.rglob("*.[cn][s,c]*")):
        if path.suffix not in (".csv", ".nc"):
            continue
        name = way + path.relative_to(results).as_posix()
        entries = [one for one in described if _matches(name, one["file"])]
        if not entries:
            missing.append(name)
            continue
        (entry,) = entries
        found = _units_in(path)
        for key, unit in found.items():
            told = [one for one in _told(entry) if _matches(key, one)]
            if not told:
                missing.append(f"{name}: {key}")
            elif path.suffix == ".nc" and entry["variables"][told[0]][0] != unit:
                missing.append(f"{name}: {key} in {unit}")
        stale += [
            f"{name}: {one}" for one in _told(entry) if not any(_matches(key, one) for key in found)
        ]
    return missing, stale


def _told(entry: dict[str, Any]) -> dict[str, Any]:
    return {**entry.get("columns", {}), **entry.get("variables", {})}


def _units_in(path: Path) -> dict[str, str]:
    """Return columns, or variables with their units."""
    if path.suffix == ".csv":
        return dict.fromkeys(pd.read_csv(path, nrows=0).columns, "")
    with xr.open_dataset(path, engine="scipy", decode_times=False) as dataset:
        return {str(name): one.attrs.get("units", "") for name, one in dataset.variables.items()}


def _matches(name: str, pattern: str) -> bool:
    """Whether a name is one of a pattern with <…> in it."""
    if pattern == VARIED:
        return name in Coupon.model_fields or "." in name
    parts = (re.escape(part) for part in re.split(r"<[^>]*>", pattern))
    expression = "[^/]+".join(parts)
    # what a further coupon of a study has lies in a folder of its own
    expression = re.sub(r"^(coupon|damping)/", r"\1/(?:[^/]+/)?", expression)
    return bool(re.fullmatch(expression, name))


PAGES = {
    DOCS / "reference" / "study.md": study_page,
    DOCS / "reference" / "files.md": files_page,
    DOCS / "reference" / "commands.md": commands_page,
    SCHEMA: schema_text,
}
"""What is made, by its file."""


if __name__ == "__main__":
    for path, text in PAGES.items():
        path.parent.mkdir(exist_ok=True)
        path.write_text(text(), encoding="utf-8")
