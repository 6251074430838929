"""Bulk data of Nastran: cards, coordinate systems, shells, constraints, properties.

`read_deck` returns a `Deck`.
"""

from pidpanel.nastran.deck import Deck, read_deck

__all__ = ["Deck", "read_deck"]
