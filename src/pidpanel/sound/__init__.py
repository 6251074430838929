"""The sound on the panel: from a table of band levels to modal forces.

`table` reads a table of band levels from a file, `spectrum` turns band levels into a one-sided
pressure PSD, and `field` turns the coherence of the sound field over the panel into the modal
force matrix G, so that the cross-PSD of the modal forces is S_p(f) G(k). Nothing here knows of
dampers; mode shapes enter as arrays of values at quadrature points.
"""
