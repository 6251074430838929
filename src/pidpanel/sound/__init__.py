"""The sound on the panel: from a table of band levels to modal forces, and the air it moves.

Nothing here depends on dampers; mode shapes enter as arrays of values at quadrature points.

`from_study`
    The sound of a study; the one module here that knows what a study is.
`table`, `spectrum`
    Tables of band levels; the one-sided pressure PSD equivalent to them.
`field`
    The coherence of the sound over the panel as the modal force matrix G, so that the cross-PSD of
    the modal forces is S_p(f) G(k).
`surface`
    The same on curved surfaces.
`plane_waves`, `microphones`, `microphone_files`
    Waves of some sources; a field that microphones measured, and their files.
`face`
    The face of a panel under plane waves, folded by parity.
`free_edges`, `rectangle`, `outline`, `triangles`
    Thin panels and surfaces with free edges, and functions of the jump on each kind of them.
`radiation`
    The mass of the air that moves with the panel; its dynamic stiffness.
`wavenumber_table`
    Matrices tabulated over the wavenumber and interpolated.
`field_files`
    The NetCDF files of these tables.
"""
