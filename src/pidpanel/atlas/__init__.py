"""The atlas: C_e and m_a of particle beds over their dimensionless groups, as published.

`groups`
    The groups of a bed under a sine, and what drive has them.
`table`
    The table of cases, ``cases.csv``, described by ``datapackage.json``.

The runs are those of ``workflow/studies/atlas.yaml``. ``benchmarks/atlas_design.py`` makes their
table of cases, `pidpanel.coupon.from_study` their rows.
"""
