"""The panel: its mesh, its plate theory, its modes.

Shapes are functions of position only; nothing here depends on sound or on dampers.

`from_study`
    The panel of a study; the one module here that knows what a study is.
`grid`, `triangles`
    Meshes drawn here: quadrilaterals on a rectangle, triangles in any outline.
`flat_mesh`, `nastran`
    Meshes from other programs: checks, gmsh files, Nastran bulk data.
`mesh`
    The mesh that all of them lead to, and its gmsh file.
`section`, `layup`
    Mass and stiffness per unit width: thin and solid plates, sandwiches from their plies.
`supports`, `attachments`
    Edges, hinges and hold-downs; springs and masses.
`plate`, `thin`, `mindlin`
    The assembled plate, by Kirchhoff's theory or with transverse shear.
`modes`
    Modes and residual vectors: the basis of the response.
`eigen`
    Many eigenpairs of large sparse matrices.
`face`
    The face as its sound needs it, condensed for plane waves.
`navier`, `resolution`
    Closed forms for rectangles; how fine a mesh must be.
`basis_files`, `tables`
    Files of the basis; tables of modes and section.
`verification`
    Natural frequencies compared with published values.
"""
