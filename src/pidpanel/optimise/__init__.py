"""Layouts within a mass budget: where dampers go, how full, and how good the proposal is.

`places`
    A grid of patches on the panel that dampers may fill.
`reduced_panel`
    The panel seen from a few motions of each place: every addition of a damper to a layout at once.
`options`
    Dampers on places with their damping frozen at the motion of each damper alone.
`search`
    Greedy search with exchange; branch and bound; checks of the property that the bound needs.
`excitations`, `variants`
    The best layouts at their consistent motion, with errors, dead weight and robustness.
`proposal`
    Layouts that are equivalent within the uncertainty, and the front of mass and reduction.
"""
