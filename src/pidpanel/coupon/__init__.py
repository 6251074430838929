"""The shaken coupon: honeycomb cells with spheres, run in LIGGGHTS, read cycle by cycle.

Runs
    `from_study` makes cases of a study; `cases` defines packings, beds, runs and cases and what
    their labels depend on; `drive` is the motion.
Running it
    `preparation` pours and loosens, `runs` shakes, `window` measures the energy balance of a run;
    `attempts` does each as a job that is tried twice; `liggghts` is all that speaks to LIGGGHTS.
Formulas of arrays
    `geometry` of cells and spheres, `contact` of one elastic contact, `balance` of the energies,
    `cycles` from momentum to C_e and m_a with errors.
Reading it
    `rows` reads and judges a run, `summary` makes the table of cases; `records` are what is kept
    in JSON files.
Beside it
    `estimate` has the run time of a sweep.
"""
