"""The response of a panel with layouts of dampers to a sound field.

`from_study`
    The panel of a study in its sound: the one door for the study.
`modal`, `model`
    The bare panel in modal coordinates, line by line; arrays with their checks.
`dampers`, `direct`, `diagonal`
    Dampers attached to the bare panel by low-rank updates, in all its shapes, in the paper's form.
`in_air`
    The bare panel in air on many lines from few factorisations.
`solvers`
    A panel with patches, solved for any number of layouts.
`scenarios`, `linearisation`, `search`, `motions`
    Layouts at their own motion: the Γ at which the motions of all patches and their damping agree.
`elements`, `basis_error`, `refinement`
    All elements beside the basis: what it leaves out of every scenario, and a wider one.
`uncertainty`
    Standard errors of C_e and m_a carried through to PSDs and rms values.
`radiation`, `power`, `stress`, `maps`, `bands`, `lines`
    Air, balance of power, strain and stress, rms all over the panel, third octaves, lines.
`results`, `tables`, `map_files`, `export`, `tabdmp1`
    The files of the stage.
`rounds`
    The rounds of a target: which cases of the coupon to run next.
`source`, `coupled_damping`
    The particles' own force as a load; what coupled runs found as a damping model.
`verification`
    Cases with a known answer.
"""
