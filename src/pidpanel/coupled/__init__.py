"""Panel and particles in one time integration: the reference for all damping models.

All shapes of the panel and the spheres of some cells of every filled patch move together, each
station of a patch with its own motion, under modal forces drawn from the excitation. The response
is compared with that of the same panel with a linear damper under the same forces. The equivalent
linear damper (C_e, m_a) and the own force of the bed follow from the same run.

`force_record`
    Modal forces with the cross-PSDs of an excitation.
`integration`
    Panel, exactly from one impulse to the next, and spheres step by step; the balance of energy.
`linear`
    The same panel with linear dampers, over frequency.
`impedance`, `own_force`
    C_e, m_a and the bed's own force from records, with the excitation as instrument.
`estimate`
    Third octaves and rms of the whole patch from those of the run, with errors.
`beds`, `pieces`
    The spheres of a run in LIGGGHTS as a library, and the process around it.
`scenario`, `excited_panel`, `scenario_runs`
    Settings, the panel with the stations of the patches of a scenario, and its runs.
`checkpoints`
    Results of the runs.
`from_study`
    The runs of a study, and the files of their estimates.
"""
