"""Geometry that several stages share.

`polygon`, `plane_mesh`
    Outlines, and meshes of a plane.
`cells`, `sizes`
    Honeycomb cells; diameters of particles.
`plane_waves`
    A face condensed for plane waves.
"""
