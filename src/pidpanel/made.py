"""What a job of the workflow made, and from what, so that a change or a damage of either is seen.

Beside the files of a job, in ``.made``, are two of its own: ``<file>.rests`` holds what they rest
on besides other results, as text, and is an input of the rule; ``<file>.sums`` holds the hashes of
that and of all that was made. Both are below ``results``, so nothing hangs on ``.snakemake``.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from pidpanel import durable

FOLDER, RESTS, SUMS = ".made", ".rests", ".sums"
CHUNK = 1 << 20
"""Bytes that are read at a time."""


def rests_file(output: str | Path) -> Path:
    """Return the file that says what a job rests on, from the first file that it makes.

    Examples
    --------
    >>> str(rests_file("results/wing/panel/modes.nc"))
    'results/wing/panel/.made/modes.nc.rests'
    """
    output = Path(output)
    return output.parent / FOLDER / f"{output.name}{RESTS}"


def write_rests(file: Path, values: Mapping[str, object]) -> None:
    """Write what a job rests on, if it is not what is there."""
    text = json.dumps(values, indent=1, sort_keys=True) + "\n"
    try:
        same = file.read_text(encoding="utf-8") == text
    except (OSError, UnicodeDecodeError):
        same = False
    if not same:
        file.parent.mkdir(parents=True, exist_ok=True)
        durable.write_text(file, text)


def write_sums(rests: Path, outputs: Iterable[str | Path]) -> None:
    """Write the hashes of what a job rests on and of what it has made."""
    durable.write_text(rests.with_suffix(SUMS), json.dumps(sums([rests, *outputs]), indent=1))


def sums(paths: Iterable[str | Path]) -> dict[str, str]:
    """Hash of each file, and of each in a folder; an empty one where there is none."""
    return {str(file): _hash(file) for path in paths for file in _files(Path(path))}


def changes(
    rests: Path, outputs: Sequence[str | Path], wanted: Path | None = None
) -> tuple[bool, list[Path]]:
    """Compare what is there with what a job left.

    Parameters
    ----------
    rests
        Its `rests_file`.
    outputs
        What it makes.
    wanted
        A file that holds what it should rest on; left out, ``rests`` itself does.

    Returns
    -------
    anew : bool
        Whether it is to be made anew. False where nothing of it is there.
    damaged : list of Path
        Files that are not as they were left, or are not there any more.
    """
    try:
        left = json.loads(rests.with_suffix(SUMS).read_bytes())
    except (OSError, ValueError, RecursionError):
        left = None
    if not isinstance(left, dict):
        return any(Path(output).exists() for output in outputs), []
    now = sums([rests, *outputs])
    own = str(rests)
    files = sorted((now.keys() | left.keys()) - {own})
    damaged = [Path(file) for file in files if now.get(file, "") != left.get(file)]
    return bool(damaged) or left.get(own) != _hash(wanted or rests), damaged


def _files(path: Path) -> Iterator[Path]:
    if path.is_dir():
        # Snakemake puts files of its own into a folder
        inside = (file for file in path.rglob("*") if not file.name.startswith(".snakemake"))
        yield from sorted(file for file in inside if file.is_file())
    else:
        yield path


def _hash(path: Path) -> str:
    digest = hashlib.sha256()
    try:
        with path.open("rb") as file:
            while chunk := file.read(CHUNK):
                digest.update(chunk)
    except OSError:
        return ""
    return digest.hexdigest()
