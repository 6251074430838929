"""The answer after tests that have been made: their results, the posterior, what remains."""
