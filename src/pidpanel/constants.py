"""Constants that more than one stage needs."""

import re

STANDARD_GRAVITY = 9.80665  # m/s², exact by definition (3rd CGPM, 1901)

# The version that the decks and readers are written for; no other is run.
LIGGGHTS_VERSION = "3.8.0"

LARGEST_GAMMA = 2000.0  # largest amplitude of an acceleration [g]

# η of particles that do not rebound is at most 4/π = 1.27; more is taken for percent [1].
MOST_LOSS_FACTOR = 2.0

# η of particles with e = 0.99 is at most 4/π (1 + e)/(1 − e); no damper has more [1].
MOST_LOSS_OF_REBOUND = 250.0

# Most m_a over the mass of the particles. Particles that ride along have 1, in resonance with
# their gap a few times that; what is above is taken for a wrong unit.
MOST_OF_MASS = 10.0

ATLAS = "atlas"  # name of the damping model of the table of simulated beds

# Nastran cards that place nodes or elements: other nodes and elements, files, superelements
PLACING_CARDS = re.compile(
    "GRID|GRDSET|INCLUDE|BEGIN|END|SE[A-Z]+|CQUAD|CTRIA|CTRAX|CSHEAR|CHEX|CTETRA|CPENTA|CPYRAM|="
)

# Standard deviations of an uncertain input within which its values are physical; samples end there.
REACH = 3.0

# Probability of measured results under the stated spreads below which they contradict them.
IMPROBABLE = 1e-3
