"""The main results name what the numbers say."""

from pidpanel.report.outcome import outcome

POINTS = ["middle", "corner"]
FILL = {("A_r0.1_150dB", p): 4.0 for p in POINTS}
FILL |= {("A_r0.7_150dB", p): 2.0 for p in POINTS} | {("A_r0.9_150dB", p): 1.8 for p in POINTS}


def test_the_outcome_names_the_best_fill_of_each_point(study, respond):
    # red: `idxmin` of the reduction
    summary, _ = respond({**FILL, ("A_r0.9_150dB", "corner"): 9.0})
    said = " ".join(outcome(study, summary))
    assert "r = 0.1 at point middle (4.0 dB below" in said
    assert "r = 0.9 at point corner (9.0 dB below" in said
    assert "as printed" not in said
