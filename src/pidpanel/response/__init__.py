"""The response of a study: from its files to PSDs, tables, maps and exports.

`from_study`
    The panel of a study in its sound.
`refinement`
    A basis that is wide enough for every scenario.
`results`, `tables`, `trust`, `map_files`, `export`, `nastran`, `tabdmp1`
    The files of the stage.
`coupled_damping`
    C_e, m_a and own force of coupled runs as a damping model.
"""
