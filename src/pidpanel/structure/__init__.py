"""Structures of any shape: their modes, surfaces, patches and points as the panel's basis.

`from_study`
    The structure of a study, or its panel.
`surface`
    Triangles of a surface: patches, points, normals.
`modal_plate`
    Matrices of modes from a file, in the modes as coordinates.
"""
