"""A deck of the user's own is a program: whose decks are run.

A template can compute anything, and the commands of LIGGGHTS start programs and write files under
many names. A list of what is harmless has to read a line exactly as LIGGGHTS does, and to know the
files of every style; each gap is a program that starts. So nothing of such a deck is rendered or
run before its user allows it to do anything (`TRUST`).
"""

import os
from pathlib import Path

from pidpanel.coupon.liggghts.failures import DeckRefused
from pidpanel.paths import TEMPLATES

# Variable of the environment that is ``1`` where decks of one's own may do anything.
TRUST = "PIDPANEL_TRUST_DECK"


def comes_with_pidpanel(template: Path) -> bool:
    """Return whether a template is not of the user's own."""
    return template.resolve().is_relative_to(TEMPLATES)


def check_trust(template: Path) -> None:
    """Refuse a template that did not come with pidpanel, unless such decks are trusted.

    Raises
    ------
    DeckRefused
        If the deck is not trusted, with its risks and how to allow it.
    """
    if os.environ.get(TRUST) != "1" and not comes_with_pidpanel(template):
        raise DeckRefused(
            f"{template}: your own deck is a program, which can start others and write any file; "
            "read it, then allow it with --trust-deck"
        )
