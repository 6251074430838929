"""The shaken coupon: honeycomb cells with spheres, run in LIGGGHTS, read per cycle.

`cases` lists what is to be run, `bed` and `contact` are its geometry and mechanics,
`deck` writes what LIGGGHTS reads, `solver` runs it, `log` reads what it wrote, and
`cycles` turns cycle rows into dissipated energy, damping and apparent mass.
"""
