"""The response of a panel with damper patches to a sound field.

`modal` solves the panel in modal coordinates line by line and returns PSDs, rms values and the
balance of power; `linearisation` finds the level at which the motion of a patch and the damping
that it causes agree. Both are functions of arrays: modes, modal force, patch damping in; PSDs out.
"""
