"""Measured PSDs of the response points beside computed ones."""
