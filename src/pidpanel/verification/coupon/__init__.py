"""LIGGGHTS and the decks of the coupon compared with closed forms: for the page of verification.

`contacts`
    Single contacts: a collision, a slide that friction ends.
`shaken`
    Shaken spheres with the deck of the product: a ball, a slug in a box, a bed on a floor.
"""

from pidpanel.verification.coupon import contacts, shaken

# Each of them runs LIGGGHTS in a folder and returns its rows.
CASES = {
    "collision": contacts.collision_rows,
    "sliding": contacts.sliding_rows,
    "ball": shaken.ball_rows,
    "slug": shaken.slug_rows,
    "floor": shaken.floor_rows,
}
