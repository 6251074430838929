"""The results in sentences name what the numbers say, and no more than their errors allow."""

from pidpanel.report.outcome import outcome

POINTS = ["middle", "corner"]
FILL = {("A_r0.1_150dB", p): 4.0 for p in POINTS}
FILL |= {("A_r0.7_150dB", p): 2.0 for p in POINTS} | {("A_r0.9_150dB", p): 1.8 for p in POINTS}


def test_the_outcome_names_the_best_fill_of_each_point(reported, respond):
    # red: `-` left out of the key of the ranking
    summary, _ = respond({**FILL, ("A_r0.9_150dB", "corner"): 9.0}, error_db=0.3)
    said = " ".join(outcome(reported, summary))
    assert "at middle most with A at r = 0.1 (4.00 ± 0.30 dB" in said
    assert "at corner most with A at r = 0.9 (9.00 ± 0.30 dB" in said
    assert "as printed" not in said


def test_what_lies_within_the_errors_is_not_called_better(reported, respond):
    # red: SIGNIFICANCE = 0; a gain of 2 dB with an error of 1.5 dB called one
    summary, _ = respond(FILL, error_db=0.8)
    said = " ".join(outcome(reported, summary))
    assert (
        "at middle A at r = 0.1 to 0.9 agree within the uncertainty (1.80 to 4.00 ± 0.80 dB)"
        in said
    )
    summary, _ = respond(FILL, error_db=3.0)
    assert "at middle no reduction exceeds its error" in " ".join(outcome(reported, summary))


def test_without_errors_nothing_is_called_better(reported, respond):
    # red: NaN compared as if it were a number
    summary, _ = respond(FILL)
    said = " ".join(outcome(reported, summary))
    assert "at middle reductions of 1.80 to 4.00 dB, without a stated error" in said
    assert "most with" not in said
