"""The response of a panel with damper patches to a sound field.

`from_study`
    The panel of a study in its sound: the one door for the study.
`modal`, `model`
    The bare panel in modal coordinates, line by line; arrays with their checks.
`dampers`
    Dampers attached to the bare panel by low-rank updates.
`scenarios`, `linearisation`
    One scenario; the Γ at which the motion of a patch and its damping agree.
`uncertainty`
    Standard errors of C_e and m_a carried through to PSDs and rms values.
`radiation`, `power`, `stress`, `maps`, `bands`, `lines`
    Air, balance of power, strain and stress, rms all over the panel, third octaves, lines.
`results`, `tables`, `map_files`, `export`, `tabdmp1`
    The files of the stage.
`rounds`
    The rounds of a target: which cases of the coupon to run next.
`verification`
    Cases with a known answer.
"""
