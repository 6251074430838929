"""What other surroundings would change at the first modes of a panel, or what microphones know.

`from_study`
    In words, of a study.
`modes`
    The acceleration of each mode alone, at its resonance in air.
"""
