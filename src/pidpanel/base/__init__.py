"""Motion of the supports on a shaker: random and sine responses of the panel, and notches.

The stage comes after `response`: it takes its basis, its scenarios and its damping models.
"""
