"""What a deck of somebody else may make LIGGGHTS do: move spheres and write its rows, no more.

LIGGGHTS starts programs (``shell``, ``python``, a file name that ends in ``.gz``), reads the
environment and writes wherever it is told. A deck is held to lists of what is known to do none of
this, and to the names of files that it is given; what is not on the lists is refused, unless the
deck is trusted (`TRUST`).
"""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Collection, Iterator
from pathlib import Path

from pidpanel.paths import TEMPLATES

TRUST = "PIDPANEL_TRUST_DECK"
"""Variable of the environment that is ``1`` where decks of one's own may do anything."""

LONGEST = 1_000_000
"""Longest text of a deck [characters]."""

COMMANDS = frozenset(
    """atom_modify atom_style angle_coeff angle_style bond_coeff bond_style boundary
    change_box comm_modify communicate compute coarsegraining create_atoms create_box
    delete_atoms delete_bonds dielectric dihedral_coeff dihedral_style dimension displace_atoms
    fix fix_modify group hard_particles lattice mass modify_timing neigh_modify neighbor newton
    orient origin pair_coeff pair_modify pair_style print processors read_data read_restart region
    reset_timestep run run_style set soft_particles special_bonds thermo thermo_modify
    thermo_style timestep uncompute unfix units variable velocity""".split()
)
"""Commands that start no program and open no file but the ones that are looked at below."""

FIXES = re.compile(
    r"(addforce|adapt|ave/time|aveforce|base/liquidtracking|buoyancy|check/timestep/gran|drag"
    r"|efield|enforce2d|freeze|gravity|heat/gran.*|insert/.*|limit/.*|lineforce|massflow/mesh.*"
    r"|mesh/surface.*|momentum|move|move/mesh|multisphere|nve.*|particledistribution/.*"
    r"|particletemplate/.*|planeforce|property/.*|relax_contacts|rigid.*|rotate|setforce|spring.*"
    r"|store/.*|viscous|wall/gran.*|wall/region.*|wall/reflect)"
)
"""Styles of fixes of the same kind."""

VARIABLES = ("equal", "atom", "delete")
"""Styles of variables; others hold text, which could become a command, or read files."""

_FILE_WORDS = ("file", "append", "infile", "filename")


def is_trusted(template: Path) -> bool:
    """Whether a template may do anything: one that comes with pidpanel, or all where it is said."""
    return os.environ.get(TRUST) == "1" or template.resolve().is_relative_to(TEMPLATES)


def refusals(text: str, files: Collection[str]) -> Iterator[str]:
    r"""Yield why a deck is refused: its command and what is wrong with it.

    Parameters
    ----------
    text
        The deck with its values.
    files
        Names of files that it may read and write.

    Examples
    --------
    >>> list(refusals("timestep 1e-6\nshell rm -r /\n", ()))
    ['shell rm -r /: the command shell is refused in a deck that is not trusted']
    """
    if len(text) > LONGEST:
        yield f"{len(text)} characters; allowed are {LONGEST}"
        return
    odd = next((c for c in text if not c.isprintable() and c not in "\n\t"), None)
    if odd is not None:
        yield f"the character {odd!r} is refused in a deck that is not trusted"
        return
    # as LIGGGHTS goes on with the next line: in place of the last character of this one
    for line in re.sub(r"&[ \t]*\n", "", text).split("\n"):
        reason = _refused(line, files)
        if reason:
            yield f"{line.strip()[:60]}: {reason} refused in a deck that is not trusted"


def _refused(line: str, files: Collection[str]) -> str:
    """What of a line is refused; empty if nothing is."""
    words, reason = _words(line)
    if reason or not words:
        return reason
    command, *rest = words
    if command not in COMMANDS:
        return f"the command {command} is"
    if command == "fix" and (len(rest) < 3 or not FIXES.fullmatch(rest[2])):
        return f"the fix {' '.join(rest[2:3]) or 'without a style'} is"
    if command == "variable" and (len(rest) < 2 or rest[1] not in VARIABLES):
        return f"a variable of the style {' '.join(rest[1:2]) or 'none'} is"
    if command == "run" and not (len(rest) == 1 and rest[0].isdecimal()):
        return "run with more than a number of steps is"
    named = rest[:1] if command in ("read_data", "read_restart") else []
    named += [
        after for word, after in zip(rest, [*rest[1:], ""], strict=True) if word in _FILE_WORDS
    ]
    for name in named:
        if name not in files:
            return f"the file {name!r} (allowed: {', '.join(sorted(files))}) is"
    return ""


def _words(line: str) -> tuple[list[str], str]:
    """Words of a line as LIGGGHTS takes them, and what keeps it from being read so."""
    if line.lstrip().startswith("#"):
        return [], ""
    if "$" in line:
        return [], "the character $ is"
    lexer = shlex.shlex(line, posix=False, punctuation_chars=False)
    lexer.whitespace, lexer.whitespace_split, lexer.commenters = " \t", True, "#"
    try:
        words = list(lexer)
    except ValueError:
        return [], "a quote that is not closed is"
    if any('"' in word or "'" in word for word in words[:1]) or '"""' in line:
        return [], "a quote at the beginning is"
    return [word.strip("\"'") for word in words], ""
