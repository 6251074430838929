"""Measured PSDs and transmissibilities of the response points beside computed ones."""
