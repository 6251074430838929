"""The dampers of the judged scenarios over the spread of their inputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from pidpanel.arrays import Array
from pidpanel.damping.models import FilledDamper
from pidpanel.margin.damping_table import (
    ACCELERATIONS,
    ENDS,
    FREQUENCIES,
    DampingTable,
    VariedDamping,
)
from pidpanel.margin.runs import AcousticMedium, DampedLayout, RunInputs, UnitPanel, answers
from pidpanel.margin.samples import leading
from pidpanel.margin.spread_panel import SpreadPanel

if TYPE_CHECKING:
    from pidpanel.margin.inputs.from_study import UncertainStudy

TEST_DB = -12.0  # level of an acoustic test that could be made, over that of the study
ERROR_TERMS = 3  # scores of the error of a damping model
SEARCHED_G = (0.3, 2000.0)  # Γ between which the nominal motion is searched
COARSER = 2  # the change with inputs is read at every second Γ: g rms within 1e-4
FURTHER = 4.0  # Γ of the tables beyond the nominal motions at both levels


class SpreadDampers:
    """The dampers of the judged scenarios over the spread of their inputs, at two levels.

    The second level is that of a test, `TEST_DB` from the first.

    Parameters
    ----------
    nominal
        Inputs of the nominal run.
    """

    def __init__(
        self,
        uncertain: UncertainStudy,
        panel: SpreadPanel,
        nominal: RunInputs,
        medium: AcousticMedium,
    ) -> None:
        study = uncertain.study
        self._names, self._keys = panel.basis.patch_names, uncertain.keys
        self.scenarios, self.factors = uncertain.dampers(), uncertain.factors
        self.test_db = uncertain.test_db
        self._follows = study.damping.level.acceleration_g is None
        self._frequency = np.geomspace(*study.response.frequency_hz, FREQUENCIES)
        stated = np.array([study.damping.level.acceleration_g or 1.0])
        self._gamma = np.geomspace(*SEARCHED_G, ACCELERATIONS) if self._follows else stated
        self._errors = uncertain.error_columns
        no_error = np.zeros((2 * FREQUENCIES, ERROR_TERMS))
        self._tables = {
            place: VariedDamping(table, (), no_error)
            for place, table in self._tables_of(self.scenarios).items()
        }
        middle = np.zeros(len(self._keys)), np.zeros(uncertain.size)
        bare = UnitPanel.solved(nominal, medium, self.patches)
        nominal_answers = answers(nominal, bare, self.layouts(*middle), uncertain.band_edges)
        motions = np.concatenate([*nominal_answers.log_acceleration, np.zeros(0)])
        if self._follows and motions.size:
            low, high = np.exp([motions.min(), motions.max()]) * [1 / FURTHER, FURTHER]
            tones = [low, high] if uncertain.coupon is None else uncertain.coupon.acceleration_g
            ends = min(low, *tones), max(high, *tones)
            self._gamma = np.geomspace(*ends, ACCELERATIONS)
        self._vary(uncertain)
        self.near = nominal_answers.log_acceleration

    @property
    def patches(self) -> list[int]:
        """Patches with a damper in some scenario."""
        return sorted({self._names.index(name) for part in self.scenarios for name in part})

    def layouts(self, keys: Array | None, scores: Array) -> list[DampedLayout]:
        """Return the layouts at both levels, at scores of the keys and of all groups.

        None stands for the keys as in the study.
        """
        layouts = []
        for decibels in (0.0, self.test_db):
            for number, (dampers, factor) in enumerate(
                zip(self.scenarios, self.factors, strict=True)
            ):
                read = []
                for patch, damper in dampers.items():
                    varied = self._tables[number, patch]
                    part = self._errors.get(damper.name)
                    error = np.zeros(ERROR_TERMS) if part is None else scores[part]
                    read.append(varied.damping(keys, error))
                patches = tuple(self._names.index(name) for name in dampers)
                level = factor * 10 ** (decibels / 10)
                layouts.append(DampedLayout(patches, tuple(read), level, self._follows))
        return layouts

    def _tables_of(
        self, scenarios: Sequence[Mapping[str, FilledDamper]], step: int = 1
    ) -> dict[tuple[int, str], DampingTable]:
        """Return the tables of dampers by scenario and patch; equal ones are read once.

        ``step`` takes every n-th Γ.
        """
        read: dict[tuple[int, float], DampingTable] = {}
        tables = {}
        for number, dampers in enumerate(scenarios):
            for patch, damper in dampers.items():
                key = id(damper.model), damper.fill
                if key not in read:
                    read[key] = DampingTable.tabulated(damper, self._frequency, self._gamma[::step])
                tables[number, patch] = read[key]
        return tables

    def _vary(self, uncertain: UncertainStudy) -> None:
        """Read how the dampers follow their inputs, and their errors."""
        nodes, coarse = np.insert(ENDS, len(ENDS) // 2, 0.0), np.log(self._gamma[::COARSER])
        hats = [np.interp(np.log(self._gamma), coarse, unit) for unit in np.eye(coarse.size)]
        between = np.transpose(hats)
        changes: dict[tuple[int, str], list[tuple[int, PchipInterpolator]]]
        tables, changes = self._tables_of(self.scenarios), {place: [] for place in self._tables}
        for key_number, key in enumerate(uncertain.keys):
            if not key.startswith(("dampers.", "scenarios.")):
                continue
            # the middle of a spread may be another number than that of the study
            is_nominal = uncertain.is_nominal(key_number)
            ends = [uncertain.dampers((key_number, z)) for z in (ENDS if is_nominal else nodes)]
            if key.startswith("scenarios."):
                ends = [self._refilled(end) for end in ends]
            at_ends = [self._tables_of(end, COARSER) for end in ends]
            for place in at_ends[0]:
                middle = tables[place].values[:, ::COARSER]
                change = between @ np.array([end[place].values - middle for end in at_ends])
                if np.any(change):
                    if is_nominal:
                        change = np.insert(change, len(ENDS) // 2, 0.0, axis=0)
                    change[:, 0] = np.exp(change[:, 0])
                    changes[place].append((key_number, PchipInterpolator(nodes, change)))
        for (number, patch), table in tables.items():
            error = self._error(self.scenarios[number][patch])
            self._tables[number, patch] = VariedDamping(table, changes[number, patch], error)

    def _refilled(self, scenarios: Sequence[Mapping[str, FilledDamper]]) -> list[Any]:
        """Return the dampers with another fill than the nominal ones."""
        return [
            {patch: damper for patch, damper in dampers.items() if damper.fill != old[patch].fill}
            for dampers, old in zip(scenarios, self.scenarios, strict=True)
        ]

    def _error(self, damper: FilledDamper) -> Array:
        """Return the error (2 n_f, r) of ln C_e, then m_a, over scores; at the middle motion."""
        nodes = damper.model.nodes
        if nodes is None:
            return np.zeros((2 * FREQUENCIES, ERROR_TERMS))
        gamma = float(np.sqrt(self._gamma[0] * self._gamma[-1]))
        nodes = nodes[(nodes > self._frequency[0] / 1.3) & (nodes < self._frequency[-1] * 1.3)]
        covariance = damper.model.covariance(nodes, damper.fill, gamma)
        mixing = leading(covariance, 1.0)[:, :ERROR_TERMS].reshape(2, nodes.size, -1)
        x, x_nodes = np.log(self._frequency), np.log(nodes)
        hats = np.transpose([np.interp(x, x_nodes, unit) for unit in np.eye(nodes.size)])
        return np.concatenate([hats @ half for half in mixing])
