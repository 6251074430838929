"""The response of a panel with damper patches to a sound field.

`modal` solves the bare panel in modal coordinates line by line, `dampers` attaches dampers to it,
`linearisation` finds the Γ at which the motion of a patch and the damping that it causes
agree, `power` strikes the balance and `stress` tells strain and stress. All are functions of
arrays: modes, modal force, patch damping in; PSDs out.
"""
