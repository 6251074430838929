"""A study file: read, checked, and its mistakes answered in one line each."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from pidpanel.paths import PROJECT
from pidpanel.study.base import StudyError
from pidpanel.study.schema import allowed_keys
from pidpanel.study.study import CouponStudy, Study


class _Loader(yaml.SafeLoader):
    """Safe YAML that refuses a key that stands twice."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen: set[Any] = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if key in seen:
                raise StudyError(
                    f"{self.name}:{key_node.start_mark.line + 1}: {key}: "
                    "stands twice; each key once"
                )
            seen.add(key)
        return super().construct_mapping(node, deep)


def load_study(path: str | Path) -> Study:
    """Read and check the file of a study that has a panel; see `load_any_study`."""
    study = load_any_study(path)
    if not isinstance(study, Study):
        raise StudyError(f"{path}: panel: missing; this is a study of the coupon alone")
    return study


def load_any_study(path: str | Path) -> Study | CouponStudy:
    """Read and check a study file: a `CouponStudy` if it says nothing of a panel.

    Parameters
    ----------
    path
        YAML file. Paths in it are taken from the file's own folder, then from
        ``workflow/data`` of the project.

    Raises
    ------
    StudyError
        One line: file, line, key, value, what is allowed.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise StudyError(f"{path}: cannot be read ({error.strerror}); a YAML file") from None
    try:
        loader = _Loader(text)
        loader.name = str(path)
        data = loader.get_single_data()
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 0
        raise StudyError(f"{path}:{line}: not YAML: {error.problem}") from None
    if not isinstance(data, dict):
        raise StudyError(f"{path}: empty; a mapping with the keys {', '.join(Study.model_fields)}")
    data.setdefault("name", path.stem)
    alone = "coupon" in data and not set(data) - set(CouponStudy.model_fields)
    model = CouponStudy if alone else Study
    try:
        study = model.model_validate(data)
    except ValidationError as error:
        raise StudyError("\n".join(_explain(path, text, error))) from None
    return _with_found_files(study, path)


def _with_found_files(study: Study | CouponStudy, path: Path) -> Study | CouponStudy:
    """Replace the files a study names by their paths; refuse those that are not there."""

    def find(key: str, name: Path, folder: str) -> Path:
        shipped = PROJECT / folder
        for base in (path.parent, Path.cwd(), shipped):
            if (base / name).is_file():
                return base / name
        known = ", ".join(sorted(p.name for p in shipped.glob("*.*")))
        raise StudyError(
            f"{path}: {key} = {name}: no such file; a file beside the study"
            + (f" or one of {known}" if known else "")
        )

    coupon = study.coupon
    if coupon is not None:
        if coupon.deck is not None:
            deck = find("coupon.deck", coupon.deck, "templates")
            coupon = coupon.model_copy(update={"deck": deck})
        if "deck" in coupon.vary:
            decks = tuple(
                name if name is None else find("coupon.vary.deck", Path(name), "templates")
                for name in coupon.vary["deck"]
            )
            coupon = coupon.model_copy(update={"vary": {**coupon.vary, "deck": decks}})
        study = study.model_copy(update={"coupon": coupon})
    if not isinstance(study, Study):
        return study
    sound = study.sound.model_copy(
        update={"spectrum": find("sound.spectrum", study.sound.spectrum, "workflow/data/spl")}
    )
    damping = study.damping
    if damping.table is not None:
        damping = damping.model_copy(
            update={"table": find("damping.table", damping.table, "workflow/data/damping")}
        )
    panel = study.panel
    if panel.mesh.file is not None:
        file = path.parent / panel.mesh.file
        if not file.is_file():
            raise StudyError(f"{path}: panel.mesh.file = {panel.mesh.file}: no such file")
        panel = panel.model_copy(update={"mesh": panel.mesh.model_copy(update={"file": file})})
    return study.model_copy(update={"sound": sound, "damping": damping, "panel": panel})


def _explain(path: Path, text: str, error: ValidationError) -> Iterator[str]:
    """One line for each mistake pydantic found, in the order of the file."""
    root = yaml.compose(text)
    best: dict[tuple[Any, ...], str] = {}
    for item in error.errors():
        location = _written_location(root, item["loc"])
        line, value = _line_and_value(root, location)
        key = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in location).lstrip(".")
        if item["type"] == "extra_forbidden":
            allowed = allowed_keys(location[:-1])
            near = difflib.get_close_matches(str(location[-1]), allowed, n=1, cutoff=0.5)
            message = "unknown key" + (
                f"; did you mean {near[0]}?" if near else f"; allowed are {', '.join(allowed)}"
            )
        elif item["type"] == "missing":
            message = "missing; it must be given"
        else:
            message = item["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
        shown = "" if value is None else f" = {value}"
        where = f"{path}:{line}: " if line else f"{path}: "
        best.setdefault(location, f"{where}{key + shown + ': ' if key else ''}{message}")
    for location, line_of_text in best.items():
        # a list of which no item is good is also reported as too short: once is enough
        if not any(len(o) > len(location) and o[: len(location)] == location for o in best):
            yield line_of_text


def _written_location(root: yaml.Node | None, location: Sequence[Any]) -> tuple[Any, ...]:
    """Location as the user wrote it: without pydantic's names of union members."""
    written: list[Any] = []
    for part in location:
        if isinstance(part, str) and not part.startswith("PID"):
            if part[:1].isupper() or "[" in part or part in ("float", "str", "none"):
                continue
            # the member that ``kind`` chose
            if _line_and_value(root, [*written, "kind"])[1] == part:
                continue
        written.append(part)
    return tuple(written)


def _line_and_value(node: yaml.Node | None, location: Sequence[Any]) -> tuple[int, str | None]:
    line = 0
    for part in location:
        if isinstance(node, yaml.MappingNode):
            for key, value in node.value:
                if str(key.value) == str(part):
                    line, node = key.start_mark.line + 1, value
                    break
            else:
                return line, None
        elif (
            isinstance(node, yaml.SequenceNode) and isinstance(part, int) and part < len(node.value)
        ):
            node = node.value[part]
            line = node.start_mark.line + 1
        else:
            return line, None
    return line, node.value if isinstance(node, yaml.ScalarNode) else None
