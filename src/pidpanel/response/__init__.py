"""The response of a study: from its files to PSDs, tables, maps and exports.

`from_study`
    The files of a study, and its values as data.
`panel`, `dampers`, `cases`
    The panel in its sound; dampers with their models; all scenarios solved.
`refinement`
    A basis that is wide enough for every scenario.
`results`, `tables`, `trust`, `psd_files`
    PSDs and tables.
`mapping`, `exports`, `nastran`
    Maps; files for other programs.
`model_error`
    Errors of damping models and of coupled runs.
"""
