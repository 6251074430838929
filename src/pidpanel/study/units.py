"""Values of a study in SI: the end of a key says its unit."""

import math
from typing import Any

from pidpanel.constants import STANDARD_GRAVITY

FACTORS = {
    "_mm": 1e-3,
    "_mpa": 1e6,
    "_gpa": 1e9,
    "_deg": math.pi / 180,
    "_g": STANDARD_GRAVITY,
}


class InSI(property):
    """The value of a key in SI; of a list, all its values; None for None.

    Examples
    --------
    >>> class Sheet:
    ...     thickness_mm = 2.0
    ...     thickness = InSI("thickness_mm")
    >>> Sheet().thickness
    0.002
    """

    def __init__(self, key: str) -> None:
        factor = FACTORS[key[key.rindex("_") :]]

        def convert(value: Any) -> Any:
            if isinstance(value, tuple):
                return tuple(map(convert, value))
            return None if value is None else value * factor

        super().__init__(lambda section: convert(getattr(section, key)))
