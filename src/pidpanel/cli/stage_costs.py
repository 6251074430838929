"""About what the stages of a study take: time and memory, from sizes known before the run.

One thread of a 2.5 GHz core. Coefficients are fitted to runs in ``benchmarks/README.md``: ``wing``
(57 000 coordinates, 371 shapes; response 54 s) and ``big_wing`` (186 000, 1073; 250 s), and to a
sandwich door of 13 000 coordinates (30 s). Within a factor of 2.
"""

import math
from typing import NamedTuple

IMPORTS = 250e6  # memory of a process before it computes [bytes]
# Coordinates times solved columns of the check of the basis, at most; see `basis_error.WORK`.
CHECK = 1.2e7
RESIDUALS = 20  # shapes beside the modes for each patch; as many again for the loaded panel


class Cost(NamedTuple):
    """What a stage takes."""

    stage: str
    seconds: float  # CPU time [s]
    memory: float  # peak [bytes]


def shape_count(area: float, half_wave: float, patches: int) -> int:
    """Return about the number of shapes of a panel, by Weyl's law."""
    wavenumber = math.pi / half_wave
    return max(12, round(area * wavenumber**2 / (4 * math.pi))) + RESIDUALS * patches


NOTCH_ROUNDS = 6  # solutions of a scenario with limits after its first, usually


def base_cost(shapes: int, lines: int, sine_lines: int, cases: int, *, notched: bool) -> Cost:
    """Return the cost of base motion, fitted to ``shaker`` (41 s).

    Lines are those of the random motion and of a sweep, cases are layouts times damping models.
    """
    rounds = 1 + NOTCH_ROUNDS * notched
    seconds = 8 + cases * (2.1e-6 * lines * shapes * rounds + 1.3e-3 * sine_lines)
    return Cost("base", seconds, IMPORTS + 4e6 * shapes)


def search_cost(shapes: int, lines: int, excitations: int) -> Cost:
    """Return the cost of a search: ``design_launch`` takes 120 s, ``design_wing`` 280 s."""
    return Cost("optimise", 1.2e-5 * lines * shapes**2 * excitations, 3e9)


def panel_costs(coordinates: int, shapes: int, lines: int, solves: int) -> list[Cost]:
    """Return the costs of the stages from the panel to the report; without solves no response."""
    product = coordinates * shapes
    per_line = lines * shapes * shapes
    # of the basis against all elements, which takes fewer lines of larger panels
    check = min(CHECK, 36 * coordinates * solves)
    response = 4 + 1.8e-9 * per_line * solves + 2e-6 * check
    under_sound = [
        Cost("sound", 2 + 2 * (shapes / 371) ** 3, IMPORTS + 4e3 * shapes**2),
        Cost("response", response, IMPORTS + 1.5e9 * (shapes / 371) ** 1.55),
    ]
    return [
        Cost("panel", 3 + 20 * (product / 2.1e7) ** 1.25, IMPORTS + 36 * product),
        *(under_sound if solves else []),
        Cost("report", 3 + 0.2 * solves, 3 * IMPORTS),
    ]
