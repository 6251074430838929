"""C_e and m_a of a filled patch at given frequencies and motion: one question, several answers.

`models`
    Interface of the damping models, and their values.
`surface`, `surface_cases`, `surface_files`
    The answer of simulated cases: C_e(r, f, Γ) and m_a(r, f, Γ) with standard errors.
`gaussian_process`, `jump`, `sides`
    What it is made of: smooth functions, where beds begin to cross the gap, both put together.
`tables`, `table_files`, `interpolation`
    Measured or foreign damping as CSV; mistakes are reported by line.
`measured`
    Measured points compared with simulated cases and the atlas.
`laws`
    The paper's law, as printed and corrected; C_e and m_a as numbers, a loss factor.
`fit`
    Constants of the paper's form.
`inelastic`
    Closed forms of a perfectly inelastic slug.
`from_study`
    The models that a study names, and the files of the stage: the only module with the study.
"""
