"""LIGGGHTS and the decks of the coupon compared with closed forms: for the page of verification.

`contacts`
    Single contacts: impacts, slides, rolls.
`shaken`
    Shaken spheres with the deck of the product: a ball, a slug in a box, a bed on a floor.
"""

from pidpanel.verification.coupon import contacts, shaken

# Each of them runs LIGGGHTS in a folder and returns its rows.
CASES = {
    "collision": contacts.collision_rows,
    "sliding": contacts.sliding_rows,
    "rolling": contacts.rolling_rows,
    "oblique": contacts.oblique_rows,
    "peak": contacts.peak_rows,
    "growth": contacts.growth_rows,
    "ball": shaken.ball_rows,
    "slug": shaken.slug_rows,
    "floor": shaken.floor_rows,
}
