"""Decks of LIGGGHTS as text: the templates and the values they are given."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import cache, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jinja2
import jinja2.meta

from pidpanel import fingerprint
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.paths import TEMPLATES

if TYPE_CHECKING:  # the label of a run is made from its deck
    from pidpanel.coupon.cases import Constants, Packing, Run

START_FILE, WALLS_FILE = "start.data", "walls.stl"
"""What a deck reads; see `start_files`."""


def cycles_file(leg: int) -> str:
    """Name of the file of cycle rows that a leg of a run writes."""
    return f"cycles_{leg}.txt"


def contact_model(rolling: bool) -> str:
    """LIGGGHTS' words for the contact law."""
    return "hertz tangential history" + (" rolling_friction cdt" if rolling else "")


def contact_values(constants: Constants) -> dict[str, Any]:
    """Variables of ``templates/contacts.j2``."""
    return {**vars(constants), "contact_model": contact_model(constants.has_rolling_friction)}


def fill_text(
    packing: Packing, constants: Constants, *, time_step: float, drag: float, chunk_steps: int
) -> str:
    """Deck that pours a packing.

    Parameters
    ----------
    packing, constants
        What is poured, and the contacts of the pour.
    time_step
        [s]
    drag
        Force over speed [N s/m].
    chunk_steps
        Steps between two lines of the log.
    """
    return render(
        "fill.in.j2",
        {
            **contact_values(constants),
            "data_file": START_FILE,
            "walls_file": WALLS_FILE,
            "skin": 0.3 * packing.diameter,
            "gravity": STANDARD_GRAVITY,
            "drag": drag,
            "time_step": time_step,
            "chunk_steps": chunk_steps,
        },
    )


def shake_text(run: Run, leg: int = 1, restart: str | None = None) -> str:
    """Deck of a run, or of a leg of it from a restart: ours, or a template of the user's own.

    Raises
    ------
    jinja2.UndefinedError
        For a variable of the user's template that `shake_values` does not hold.
    """
    name, folder = _template(run)
    return render(name, shake_values(run, leg, restart), folder)


def shake_digest(run: Run, restart: str | None = None) -> str:
    """Hash of the deck of a run without comments: what its rows depend on.

    Runs that differ in their beds alone have one deck, which is rendered once in a process.
    """
    name, folder = _template(run)
    return _digest(name, folder, tuple(shake_values(run, restart=restart).items()))


def _template(run: Run) -> tuple[str, Path]:
    """Name and folder of the template of a run."""
    own = TEMPLATES / "shake.in.j2" if run.deck is None else Path(run.deck)
    return own.name, own.parent


@cache
def _digest(name: str, folder: Path, values: tuple[tuple[str, Any], ...]) -> str:
    return fingerprint.text_digest([without_comments(render(name, dict(values), folder))])


def shake_values(run: Run, leg: int = 1, restart: str | None = None) -> dict[str, Any]:
    """Variables of ``templates/shake.in.j2`` for a run, or a leg of it from a restart."""
    packing, drive = run.packing, run.drive
    values = {
        **contact_values(run.constants),
        "data_file": START_FILE,
        "walls_file": WALLS_FILE,
        "cycles_file": cycles_file(leg),
        "skin": 0.3 * packing.diameter,
        "depth": packing.depth,
        "gravity": run.bed.gravity,
        "gravity_direction": " ".join(f"{part:.12g}" for part in run.bed.gravity_direction),
        "frequency": drive.frequency,
        "amplitude": drive.amplitude,
        "acceleration": drive.acceleration,
        "speed": drive.speed,
        "time_step": run.time_step,
        "steps_per_cycle": run.steps_per_cycle,
        "samples_per_cycle": run.samples_per_cycle,
        "steps_per_sample": run.steps_per_cycle // run.samples_per_cycle,
    }
    return values if restart is None else {**values, "restart_file": restart}


def lists_contacts(run: Run) -> bool:
    """Whether the deck of a run can list its contacts, without which there is no balance."""
    return run.deck is None or "compute touches" in Path(run.deck).read_text(encoding="utf-8")


# ------------------------------------------------------------------ templates as such


def _number(value: Any) -> Any:
    """Numbers as LIGGGHTS reads them back exactly; text as it is."""
    if isinstance(value, float):
        return f"{value:.15g}"
    return value


@lru_cache
def _environment(folder: Path) -> jinja2.Environment:
    return jinja2.Environment(
        # a deck of the user's own may include ours
        loader=jinja2.FileSystemLoader([folder, TEMPLATES]),
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_number,
        autoescape=False,
    )


def render(name: str, values: Mapping[str, Any], folder: Path = TEMPLATES) -> str:
    """Text of the deck ``templates/<name>`` with all its variables filled in.

    Raises
    ------
    jinja2.UndefinedError
        For a variable that the template names and ``values`` does not hold.
    """
    return _environment(folder).get_template(name).render(values)


def without_comments(text: str) -> str:
    r"""A deck as LIGGGHTS takes it: no comments, no blank lines, no indents, one space for several.

    Examples
    --------
    >>> without_comments("# pour\n\nrun  10 # steps\nprint 'a  # b'\n")
    "run 10\nprint 'a  # b'"
    """
    lines = (_without_comment(line) for line in text.splitlines())
    return "\n".join(line for line in lines if line)


_QUOTED = re.compile(r"""("[^"]*"|'[^']*')""")


def _without_comment(line: str) -> str:
    kept = ""
    for number, piece in enumerate(_QUOTED.split(line)):
        if number % 2:  # quoted: stays as it is
            kept += piece
            continue
        before, mark, _ = piece.partition("#")
        kept += re.sub(r"\s+", " ", before)
        if mark:
            break
    return kept.strip()


def undeclared(text: str, known: Iterable[str]) -> list[str]:
    """Variables that a template asks for and that are not among the ``known`` ones.

    Raises
    ------
    jinja2.TemplateSyntaxError
        With the line.
    """
    tree = jinja2.Environment().parse(text)
    return sorted(jinja2.meta.find_undeclared_variables(tree) - set(known))
