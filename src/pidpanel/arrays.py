"""Types of the arrays that the whole package speaks of."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complexes = NDArray[np.complexfloating[Any, Any]]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]
