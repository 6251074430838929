"""Cases of the coupon chosen by the response: rounds from the response back to the coupon.

`rounds`
    The next round of a target or of tones.
`choice`
    Which further cases reduce the variance of the rms accelerations most.
"""
