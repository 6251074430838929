"""LIGGGHTS and the decks of the coupon compared with closed forms: for the page of verification.

`contacts`
    Single contacts: impacts, slides, rolls.
`shaken`
    Shaken spheres with the deck of the product: a ball, a slug in a box, a bed on a floor.
"""

from pidpanel.verification.coupon import contacts, shaken
from pidpanel.verification.rows import cases_of

# Each of them runs LIGGGHTS in a folder.
CASES = cases_of(vars(contacts) | vars(shaken))
