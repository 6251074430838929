"""The coupon's solver and decks held to closed forms: what the page of verification shows."""

from pidpanel.coupon.verification import contacts, shaken

CASES = {
    "collision": contacts.collision_rows,
    "sliding": contacts.sliding_rows,
    "ball": shaken.ball_rows,
    "slug": shaken.slug_rows,
    "floor": shaken.floor_rows,
}
"""Each of them runs LIGGGHTS in a folder and returns its rows."""
