"""Severity of a response: oscillator spectra, peaks in a duration, fatigue under random stress."""
