"""Structures of any shape: their modes, surfaces, patches and points as the panel's basis.

`from_study`
    The structure of a study, or its panel.
`any_structure`, `surface`
    What all structures have: a surface with patches and points, in a plane or in space.
`foreign`, `modal_plate`
    The modes of another solver, and their matrices with the modes as coordinates.
`shelled`
    A shell that is meshed and solved here.
"""
