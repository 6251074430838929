"""What a launch margin rests on: g rms over the spread of all inputs, shares, the next test.

`family` has panels of any edges, stiffness and mass in one basis, `waves` the sound and the air on
it, `runs` the answers of one set of inputs; `chaos` gives shares of variance, `next_test` what a
measurement would leave of them. `from_study` reads the study.
"""
