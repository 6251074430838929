"""Flat meshes of Nastran decks: shells in any plane, all of a deck or groups of it.

A deck with any other card (supports, masses, other elements) describes another panel than would be
read, so it is refused with the card and its line, unless the study lists the card as ignored or
names the groups of its panel. The section comes from the study. Whatever is not used is counted.
"""

import re
from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np

from pidpanel.constants import PLACING_CARDS
from pidpanel.nastran.deck import GEOMETRY, MASSES, MOST_FAULTS, SHELLS, Deck, deck_and_faults
from pidpanel.panel.flat_mesh import FlatMesh, MeshFileError, counted

# Cards without a part in the natural modes, and properties and materials, for which the study has a
# section. Cards of supports, masses and elements are not among them.
HARMLESS = re.compile(
    "PARAM|PLOTEL|P(SHELL|COMPG?|SOLID|BARL?|BEAML?|BCOMP|ROD|TUBE|BUSH|BUSH1D|ELAST?|DAMP|SHEAR|GAP"
    "|MASS|WELD|FAST|VISC|LSOLID)|MAT[0-9TSU]+[A-Z0-9]*|EIG[A-Z]*|TABLE[A-Z0-9]*|TABD[A-Z0-9]*"
    "|FORCE[12]?|MOMENT[12]?|PLOAD[124]?|LOAD|LSEQ|GRAV|RFORCE|ACCEL1?|TEMP[A-Z0-9]*|FREQ[1-5]?"
    "|TSTEP|DLOAD|[RT]LOAD[12]|DAREA|DPHASE|DELAY|SET[1-3]|SPCD|SPOINT|EPOINT|[ABCQU]SET1?|SUPORT1?"
    "|D(EQATN|ESVAR|RESP[12]|CON[A-Z]+|VPREL1|VMREL1|OPTPRM|LINK|TABLE)|RANDPS|RANDT1|CORD[0-9A-Z]+"
)
# What would falsify even the chosen groups
TWISTING = re.compile("BEGIN|=|SEBULK|SELOC|SEMPLN|GRID[A-Z]")
ALLOWED = ", ".join(("GRID", "GRDSET", *SHELLS, "CORD1R to CORD2S", "BEGIN BULK", "ENDDATA"))
ADVICE = "state supports and masses in the study and list their cards in panel.mesh.ignore"
PLACED = "it places nodes or elements; panel.mesh.groups chooses the panel's"
STRAIGHT = 1e-3  # distance of a node from the middle of its edge over its length


def is_refused(name: str, ignored: Collection[str] = (), *, is_chosen: bool = False) -> bool:
    """Return whether a card keeps a deck from being read; fewer do where groups are chosen."""
    if name in GEOMETRY or HARMLESS.fullmatch(name):
        return False
    if is_chosen:
        return TWISTING.match(name) is not None
    return name not in ignored or PLACING_CARDS.match(name) is not None


def read_nastran(
    path: Path, ignored: Collection[str] = (), unit: float = 1.0, groups: Sequence[str] = ()
) -> FlatMesh:
    """Read a flat mesh from a deck; groups are properties (``12``) and sets (``SET 7``).

    Parameters
    ----------
    ignored
        Further cards to ignore, such as SPC1 and CONM2; they are counted.
    unit
        Length unit of the file [m].
    groups
        Those that the panel consists of; all shells without any. Whatever else the deck has is
        counted then.

    Raises
    ------
    MeshFileError
        A line for each mistake: file, line, card, what is allowed.
    ValueError
        If `FlatMesh.from_elements` refuses the elements, or there is no such group.
    """
    return flat_mesh(checked_deck(path, ignored, groups), unit, groups)


def checked_deck(
    path: Path, ignored: Collection[str] | None = None, groups: Sequence[str] = ()
) -> Deck:
    """Return a deck whose cards may all be read or left out; see `read_nastran`.

    Without ``ignored`` all cards that may be ignored are, for a study that states what they say.
    """
    deck, faults = deck_and_faults(path, is_whole=ignored is None)
    ignored = deck.first if ignored is None else ignored
    for name, place in deck.first.items():
        if is_refused(name, ignored, is_chosen=bool(groups)):
            advice = PLACED if PLACING_CARDS.match(name) else ADVICE
            faults.append(f"{place}: card {name} is not read; allowed are {ALLOWED}; {advice}")
        if len(faults) > MOST_FAULTS:
            break
    if faults:
        raise MeshFileError(faults)
    return deck


def flat_mesh(deck: Deck, unit: float, groups: Sequence[str] = ()) -> FlatMesh:
    """Return the flat mesh of a deck; see `read_nastran`."""
    shells = deck.shells
    chosen = deck.chosen(groups)
    place = {k: row for row, k in enumerate(chosen.tolist())}
    parts = {
        name: [place[k] for k in members if k in place] for name, members in deck.groups.items()
    }
    corners = [shells.corners[k][: SHELLS[shells.kind[k]][0]] for k in place]
    used = {number for nodes in corners for number in nodes}
    middles = {number for k in place for number in shells.corners[k]} - used
    is_used = np.isin(deck.node, list(used)) if groups else ~np.isin(deck.node, list(middles))
    return FlatMesh.from_elements(
        deck.path,
        deck.node[is_used].tolist(),
        unit * deck.position[is_used],
        shells.number[chosen].tolist(),
        corners,
        {name: members for name, members in parts.items() if members},
        [*_unused(deck, used, is_chosen=bool(groups)), *_unlike(deck, chosen)],
    )


def _unused(deck: Deck, used: Collection[int], *, is_chosen: bool) -> list[str]:
    """Return which cards are not used, with their mass in the unit of the deck."""
    fixed = [node for node in deck.fixed if node in used]
    remarks = [f"{len(fixed)} GRID with PS"] if fixed else []
    for name, count in deck.counts.items():
        if name in GEOMETRY or HARMLESS.fullmatch(name):
            continue
        mass = deck.mass_of(name) if name in MASSES else 0.0
        remarks.append(f"{count} {name}" + f" (mass {mass:g} in the unit of the deck)" * (mass > 0))
    return [", ".join(remarks)] if is_chosen and remarks else remarks


def _unlike(deck: Deck, chosen: np.ndarray) -> list[str]:
    """Return what shells state that a flat mesh has not: directions, offsets, curved edges."""
    shells, remarks = deck.shells, []
    curved = 0
    at = dict(zip(deck.node.tolist(), deck.position, strict=True))
    for k in chosen.tolist():
        count = SHELLS[shells.kind[k]][0]
        nodes = [at[number] for number in shells.corners[k] if number in at]
        if len(nodes) != 2 * count:
            continue
        ends, middle = np.array(nodes[:count]), np.array(nodes[count:])
        following = np.roll(ends, -1, axis=0)
        gap = np.linalg.norm(middle - (ends + following) / 2, axis=1)
        curved += bool((gap > STRAIGHT * np.linalg.norm(following - ends, axis=1)).any())
    statements = {
        "THETA or MCID": (shells.system[chosen] >= 0) | (np.nan_to_num(shells.angle[chosen]) != 0),
        "ZOFFS": shells.offset[chosen] != 0,
        "a thickness of their own": np.array(shells.has_thickness)[chosen],
    }
    for text, is_stated in statements.items():
        if count := int(is_stated.sum()):
            remarks.append(
                f"{counted(count, 'element')} with {text}: the section of the study counts"
            )
    if curved:
        remarks.append(f"{counted(curved, 'element')} with curved edges, which are straight here")
    return remarks
