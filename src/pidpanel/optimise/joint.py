"""The panel of a search under all its excitations."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.optimise.reduced import ReducedPanel


@dataclass(frozen=True)
class JointPanel:
    """A panel under one excitation or several.

    The stiffness s of a damper has a column for each line of all parts: its damping follows the
    motion under each excitation. Of several parts mean squares are shares of the largest of the
    bare panel under the same excitation. The largest share is then that of the smallest reduction.
    """

    parts: tuple[ReducedPanel, ...]  # the panel under each excitation, with the same places

    @cached_property
    def frequency(self) -> Array:
        """(nf,) lines of all parts [Hz]."""
        return np.concatenate([part.frequency for part in self.parts])

    @property
    def area(self) -> Array:
        """(n_places,) [m²]."""
        return self.parts[0].area

    @property
    def points(self) -> int:
        """Number of mean squares of the objective."""
        return sum(part.points for part in self.parts)

    @cached_property
    def _scale(self) -> list[float]:
        if len(self.parts) == 1:
            return [1.0]
        return [1 / float(part.bare.max()) for part in self.parts]

    @cached_property
    def bare(self) -> Array:
        """(n_points,) mean squares without dampers."""
        scaled = zip(self.parts, self._scale, strict=True)
        return np.concatenate([scale * part.bare for part, scale in scaled])

    def mean_square(
        self, places: Sequence[int], stiffness: Complexes, further: Index, added: Complexes
    ) -> Array:
        """Return mean squares (n_options, n_points) of a layout with each of further dampers.

        Parameters are those of `ReducedPanel.additions`, on the lines of all parts.
        """
        edges = np.cumsum([part.frequency.size for part in self.parts])[:-1]
        on_parts = (np.split(values, edges, axis=1) for values in (stiffness, added))
        squares = [
            scale * part.additions(places, s, further, s_added).mean_square
            for part, scale, s, s_added in zip(self.parts, self._scale, *on_parts, strict=True)
        ]
        return np.concatenate(squares, axis=1)
