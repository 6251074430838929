"""A round of the random drive: the motions that the coupons are given next, and what is reached.

What the response decides (`response.random_rounds`) and the coupon runs.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array


@dataclass(frozen=True)
class PatchDrive:
    """The random motion of one filled patch of one scenario.

    Attributes
    ----------
    label
        Its number among those of the study: the name of its files.
    scenario, patch, damper
        Whose it is.
    fill_fraction
        r [1].
    period
        Record of this round, of each packing [s]; 0 where no more is wanted.
    phases
        Seed of the phases of this round.
    frequency, acceleration_psd
        [Hz] and the mean PSD over the patch there [(m/s²)²/Hz].
    moved
        Largest change of an rms acceleration of the scenario since the round before [1].
    relative_error
        Largest standard error of one of its rms accelerations [1].
    reached
        Whether both are as small as is wanted; not so where time or rounds ran out.
    """

    label: str
    scenario: str
    patch: str
    damper: str
    fill_fraction: float
    period: float
    phases: int
    frequency: tuple[float, ...] = ()
    acceleration_psd: tuple[float, ...] = ()
    moved: float | None = None
    relative_error: float | None = None
    reached: bool = False

    def with_motion(self, frequency: Array, acceleration_psd: Array) -> PatchDrive:
        """Return the drive with another motion; see `motion`."""
        values = tuple(frequency.tolist()), tuple(acceleration_psd.tolist())
        return replace(self, frequency=values[0], acceleration_psd=values[1])

    @property
    def motion(self) -> tuple[Array, Array]:
        """Frequencies (n,) [Hz] and the PSD there [(m/s²)²/Hz]."""
        return np.array(self.frequency), np.array(self.acceleration_psd)

    @property
    def acceleration_rms(self) -> float:
        """Of the patch [m/s²]."""
        frequency, psd = self.motion
        return math.sqrt(float(np.trapezoid(psd, frequency)))


@dataclass(frozen=True)
class RandomRound:
    """One round; the content of ``random/round<n>.json``.

    Attributes
    ----------
    round
        Its number, from 0.
    drives
        Of every filled patch of every scenario.
    acceleration_rms_g
        By scenario, of its points and patches, before this round [g].
    """

    round: int
    drives: tuple[PatchDrive, ...]
    acceleration_rms_g: dict[str, dict[str, float]] = field(default_factory=dict)

    @property
    def wanted(self) -> tuple[PatchDrive, ...]:
        """The drives that are to be run in this round."""
        return tuple(drive for drive in self.drives if drive.period > 0)

    @property
    def is_last(self) -> bool:
        """Whether it wants no more."""
        return not self.wanted

    def drive(self, label: str) -> PatchDrive:
        """Return the drive of a label.

        Raises
        ------
        ValueError
            If there is none.
        """
        for drive in self.drives:
            if drive.label == label:
                return drive
        raise ValueError(f"round {self.round} has no drive {label!r}")

    def write(self, path: Path) -> None:
        """Write it as JSON."""
        path.write_text(json.dumps(asdict(self), indent=1), encoding="utf-8")

    @staticmethod
    def read(path: Path) -> RandomRound:
        """Read what `write` left.

        Raises
        ------
        ValueError
            With the file, if it is no round.
        """
        try:
            values = json.loads(path.read_text(encoding="utf-8"))
            drives = tuple(
                PatchDrive(
                    **{
                        **drive,
                        "frequency": tuple(drive["frequency"]),
                        "acceleration_psd": tuple(drive["acceleration_psd"]),
                    }
                )
                for drive in values["drives"]
            )
            return RandomRound(values["round"], drives, values["acceleration_rms_g"])
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"{path}: not a round of a random drive ({error})") from None


def record_name(round_number: int, label: str, seed: int) -> str:
    """Return where the record of a drive and a packing lies below ``random``.

    Examples
    --------
    >>> record_name(2, "3", 1)
    'leg2/3_s1.npz'
    """
    return f"leg{round_number}/{label}_s{seed}.npz"


def records_of(rounds: Sequence[RandomRound], seeds: int) -> list[str]:
    """Return the names of all records of some rounds, `record_name`."""
    return [
        record_name(one.round, drive.label, seed)
        for one in rounds
        for drive in one.wanted
        for seed in range(1, seeds + 1)
    ]
