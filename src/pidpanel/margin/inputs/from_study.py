"""A study with its inputs as standard normal scores."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.damping.broadband import EXACT, BroadbandError
from pidpanel.damping.models import FilledDamper
from pidpanel.margin.chaos import BandPower
from pidpanel.margin.samples import Group, columns_of, joined_keys, leading
from pidpanel.margin.spread_dampers import ERROR_TERMS, TEST_DB
from pidpanel.margin.update.from_study import (
    CouponTones,
    coupon_tones,
    level_of_test,
)
from pidpanel.response.from_study import dampers_of_scenarios, scenario_of
from pidpanel.solve.bands import whole_third_octaves
from pidpanel.sound.from_study import spectrum_of
from pidpanel.study import Study
from pidpanel.study.uncertain import (
    SHIFT,
    SPECTRUM,
    correlation_matrix,
    judged_scenarios,
    number_at,
    varied,
    way_of,
)

BROADBAND = "damping models under broadband sound"
QUICK = ("dampers.", "scenarios.", "sound.shift_db")  # keys that leave the panel and its air


@dataclass(frozen=True)
class UncertainStudy:
    """A study with its inputs as standard normal scores."""

    study: Study
    damping: Path | None  # folder of surfaces of simulated tones

    @cached_property
    def keys(self) -> list[str]:
        """Keys with a spread but that of the spectrum."""
        return [key for key in self.study.uncertain if key != SPECTRUM]

    @cached_property
    def band_edges(self) -> Array:
        """(n_bands, 2) third octaves of the response [Hz]."""
        return whole_third_octaves(*self.study.response.frequency_hz)[1]

    @cached_property
    def groups(self) -> list[Group]:
        """The groups of inputs: keys, the spectrum, errors of damping models."""
        uncertain, groups = self.study.uncertain, []
        correlation = correlation_matrix(self.study)
        for numbers in joined_keys(correlation):
            names = [self.keys[number] for number in numbers]
            mixing = np.zeros((len(self.keys), len(numbers)))
            mixing[numbers] = np.linalg.cholesky(correlation[np.ix_(numbers, numbers)])
            sources = "; ".join(dict.fromkeys(uncertain[name].source for name in names))
            changes_panel = not all(name.startswith(QUICK) for name in names)
            groups.append(Group(" and ".join(names), sources, mixing, changes_panel))
        if (spread := uncertain.get(SPECTRUM)) is not None:
            octave = np.log2(self.band_edges).mean(axis=1)
            distance = np.abs(octave[:, None] - octave) / (spread.correlation_octaves or 1.0)
            mixing = spread.deviation * leading(np.exp(-distance))
            groups.append(Group(SPECTRUM, spread.source, mixing))
        if np.any(self.broadband):
            mixing = np.zeros((0, len(BroadbandError._fields)))
            groups.append(Group(BROADBAND, "their stated error", mixing))
        for name in self.error_names:
            mixing = np.zeros((0, ERROR_TERMS))
            groups.append(Group(f"damping model of {name}", "its stated error", mixing))
        return groups

    @cached_property
    def error_names(self) -> list[str]:
        """Dampers whose damping model states an error, by name."""
        dampers = [damper for scenario in self.dampers() for damper in scenario.values()]
        return list(dict.fromkeys(d.name for d in dampers if d.model.nodes is not None))

    @cached_property
    def broadband(self) -> Array:
        """(n_scenarios, 2) `BroadbandError` of each judged scenario, the largest of its dampers."""
        return np.array([
            np.max([EXACT, *(damper.model.broadband_error for damper in dampers.values())], axis=0)
            for dampers in self.dampers()
        ])  # fmt: skip

    def log_broadband(self, scores: Array, effect: Array) -> Array:
        """Return the error of ln g rms under broadband sound (n_scenarios, …).

        ``effect`` (n_scenarios, …) is that of the damping on ln g rms.
        """
        z = np.zeros(2)
        for group, part in zip(self.groups, columns_of(self.groups), strict=True):
            if group.name == BROADBAND:
                z = scores[part]
        share, rest = (self.broadband * z).T.reshape(2, -1, *(1,) * (effect.ndim - 1))
        return np.asarray(share * effect + rest)

    @property
    def size(self) -> int:
        """Number of scores."""
        return sum(group.size for group in self.groups)

    @property
    def error_columns(self) -> dict[str, slice]:
        """Scores of the error of each damper."""
        start = self.size - ERROR_TERMS * len(self.error_names)
        return {
            name: slice(start + number * ERROR_TERMS, start + (number + 1) * ERROR_TERMS)
            for number, name in enumerate(self.error_names)
        }

    def values(self, scores: Array) -> dict[str, float]:
        """Return the values of the keys at scores of `groups` (n,)."""
        z = self.key_scores(scores)
        spreads = self.study.uncertain
        return {key: spreads[key].value(z[n]) for n, key in enumerate(self.keys)}

    def key_scores(self, scores: Array) -> Array:
        """Return standard normal scores of the keys."""
        total = np.zeros(len(self.keys))
        for group, part in zip(self.groups, columns_of(self.groups), strict=True):
            if len(group.mixing) == len(total) and group.name != SPECTRUM:
                total += group.mixing @ scores[part]
        return total

    def levels(self, scores: Array) -> Array:
        """Return the deviation of the level of each band (n_bands,) [dB]."""
        for group, part in zip(self.groups, columns_of(self.groups), strict=True):
            if group.name == SPECTRUM:
                return group.mixing @ scores[part]
        return np.zeros(len(self.band_edges))

    def band_power(self, band_rms: Array) -> BandPower | None:
        """Return how a nominal answer with rms values in bands (n_bands,) follows their levels."""
        for group, part in zip(self.groups, columns_of(self.groups), strict=True):
            if group.name == SPECTRUM:
                mixing = np.zeros((len(band_rms), self.size))
                mixing[:, part] = group.mixing
                return BandPower(band_rms**2 / np.sum(band_rms**2), mixing)
        return None

    def all_levels(self, scores: Array) -> Array:
        """Return `levels` with the deviation of ``sound.shift_db``."""
        stated = self.study.acoustics.shift_db
        return self.levels(scores) + self.values(scores).get(SHIFT, stated) - stated

    def dampers(self, end: tuple[int, float] | None = None) -> list[dict[str, FilledDamper]]:
        """Return the dampers by patch of each judged scenario, with one key at a score."""
        study = self.study if end is None else self.at_end(*end)
        damper_of = dampers_of_scenarios(study, self.damping, None)
        return [
            dict(scenario_of(study, scenario, scenario.label, damper_of).dampers)
            for scenario in judged_scenarios(study)
        ]

    @cached_property
    def test_db(self) -> float:
        """Level of an acoustic test over that of the study [dB]."""
        level = level_of_test(self.study)
        return TEST_DB if level is None else level

    @cached_property
    def coupon(self) -> CouponTones | None:
        """What was measured of a coupon."""
        update = self.study.update
        return coupon_tones(update.coupon) if update and update.coupon else None

    @property
    def factors(self) -> list[float]:
        """PSD of the sound of each judged scenario over that of the study."""
        spectrum = spectrum_of(self.study.acoustics)
        levels = [scenario.oaspl_db for scenario in judged_scenarios(self.study)]
        return [1.0 if db is None else spectrum.pressure_factor(db) for db in levels]

    def is_nominal(self, number: int) -> bool:
        """Return whether the middle of the spread of a key is the number of the study."""
        key = self.keys[number]
        value = number_at(self.study, way_of(self.study, key))
        return math.isclose(self.study.uncertain[key].value(0.0), float(value), rel_tol=1e-9)

    def at_end(self, number: int, z: float) -> Study:
        """Return the study with one key at a score."""
        key = self.keys[number]
        return varied(self.study, {key: self.study.uncertain[key].value(z)})
