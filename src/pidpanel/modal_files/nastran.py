"""Mesh of a Nastran deck: nodes in any frame, shells; groups are properties and sets."""

import re
from pathlib import Path

from pidpanel.modal_files.shapes import SurfaceElements
from pidpanel.nastran import read_deck
from pidpanel.nastran.deck import SHELLS

# Elements with a surface that are not read
OTHERS = re.compile("C(QUAD|TRI|TRA|SHEAR)")


def read_mesh(path: Path) -> SurfaceElements:
    """Read nodes, shells, properties and sets of a deck and the files it includes."""
    deck = read_deck(path)
    shells = deck.shells
    unread = [name for name in deck.counts if OTHERS.match(name) and name not in SHELLS]
    remarks = tuple(f"{deck.counts[name]} {name} are not read" for name in unread)
    numbers = shells.number.tolist()
    mesh = SurfaceElements(
        deck.node, deck.position, numbers, shells.corners, deck.groups, deck.frame
    )
    return mesh._replace(remarks=remarks)
