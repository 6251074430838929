"""The panel: its mesh, its plate theory, its modes.

Shapes are functions of position only; of sound and dampers no more is known here than how short
the waves and how heavy the patches can be.

`from_study`
    The panel of a study; the one module here that knows what a study is.
`grid`, `triangles`
    Meshes drawn here: quadrilaterals on a rectangle, triangles in any outline.
`flat_mesh`, `gmsh_files`, `nastran`
    Meshes from other programs: checks, gmsh files, Nastran bulk data.
`mesh`
    The mesh that all of them lead to, and its gmsh file.
`section`
    Mass and stiffness per unit width: thin and solid plates, sandwiches from their plies.
`supports`, `attachments`
    Edges, hinges and hold-downs; springs and masses.
`plate`, `thin`, `mindlin`
    The assembled plate, by Kirchhoff's theory or with transverse shear.
`modes`, `basis`
    Modes and further shapes that dampers need; their values where they are needed.
`eigen`
    Many eigenpairs of large sparse matrices.
`navier`, `resolution`
    Closed forms for rectangles; how fine a mesh must be.
`files`, `tables`
    Files of the basis and of the plate's matrices; tables of modes and section.
"""
