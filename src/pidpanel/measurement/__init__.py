"""Measured PSDs and transmissibilities of the response points, compared with computed ones."""
