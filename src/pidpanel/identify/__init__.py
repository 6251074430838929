"""Restitution, friction and fill fraction of particles from a measurement of their damper.

`prediction`
    C_e and m_a of the atlas for many particles at once, with their covariance over the tones.
`posterior`
    Posterior of e, μ and r from a measurement: weights on a grid, intervals, goodness of fit.
`next_tones`
    The tone that is expected to reduce the uncertainty most.
`force_files`
    Force over acceleration of a damper from universal files.
`from_study`
    The file of an identification, and the files of its results.
"""
