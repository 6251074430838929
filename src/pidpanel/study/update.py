"""The section ``update`` of a study: results of tests that have been made, and their errors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import Field

from pidpanel.paths import DATA
from pidpanel.study.base import RelativeError, SectionModel, Text, file_in
from pidpanel.study.mistakes import Keys, Mistake
from pidpanel.study.quantity import Quantity, inside
from pidpanel.study.response import Frequency

if TYPE_CHECKING:
    from pidpanel.study.scenarios import Scenario
    from pidpanel.study.study import Study

MODES_SEEN = 6  # elastic modes of a modal survey
LevelError = Annotated[float, Quantity(0.01, 10)]
CommonError = Annotated[float, Quantity(0, 10)]


class ModalTest(SectionModel):
    """Natural frequencies and damping ratios of the bare panel, by the number of the mode."""

    frequency_hz: Mapping[Text, Frequency] = {}
    """Natural frequencies by the number of the mode, 1 for the lowest elastic one [Hz]."""
    damping_ratio: Mapping[Text, Annotated[float, inside(0, 0.5)]] = {}
    """Damping ratios ζ of these modes [1]."""
    frequency_error: RelativeError | None = None
    """Relative standard error of the frequencies; required with them."""
    damping_ratio_error: RelativeError | None = None
    """Relative standard error of ζ; required with them."""

    needed: ClassVar = ("frequency_hz", "damping_ratio")

    def mistakes(self) -> Iterator[Mistake]:
        for key in self.needed:
            error = f"{key.removesuffix('_hz')}_error"
            if bool(getattr(self, key)) != (getattr(self, error) is not None):
                yield Mistake((error,), f"required with {key}, not allowed without it")
            for mode in getattr(self, key):
                if mode not in map(str, range(1, MODES_SEEN + 1)):
                    message = f"no such mode; must be 1 to {MODES_SEEN}, in the order of frequency"
                    yield Mistake((key, mode), message)
        values = [value for _, value in sorted(self.frequency_hz.items())]
        if values != sorted(values):
            yield Mistake(("frequency_hz",), "must rise with the number of the mode")


class CouponTest(SectionModel):
    """C_e of a coupon on a shaker: the cells of a patch, filled like it."""

    file: Annotated[Path, file_in()]
    """CSV table of damping with frequencies, amplitudes and C_e, as for ``pidpanel identify``."""
    patch: Text | None = None
    """Patch whose damper the coupon is; by default the first of the first scenario."""
    relative_error: RelativeError | None = None
    """Relative standard error of C_e, for a file without errors."""


class AcousticTest(SectionModel):
    """An acoustic test of the panel: PSDs at points, and the sound that it had."""

    measurements: Annotated[tuple[Text, ...], Field(min_length=1)]
    """Names of ``measurements``. Their scenario is bare, or has the dampers of a scenario that is
    judged; its level is that of the test."""
    spectrum: Annotated[Path, file_in(DATA / "spl")] | None = None
    """Measured levels of the sound, as ``sound.spectrum``; by default those of the scenario."""
    error_db: LevelError
    """Standard error of each octave and point [dB]."""
    common_db: CommonError
    """Standard error common to all octaves, points and acoustic tests, as by a calibration [dB]."""


class MicrophoneTest(SectionModel):
    """Measured levels of the sound for which the margin is."""

    spectrum: Annotated[Path, file_in(DATA / "spl")]
    """Measured levels, as ``sound.spectrum``."""
    error_db: LevelError
    """Standard error of each octave [dB]."""
    common_db: CommonError
    """Standard error common to all octaves [dB]."""


class Update(SectionModel):
    """Results of tests that have been made: with them the answer of ``uncertain`` is updated."""

    modal_survey: ModalTest | None = None
    """Natural frequencies and damping ratios of the bare panel."""
    impact_test: ModalTest | None = None
    """The same from hits of a hammer."""
    coupon: CouponTest | None = None
    """C_e of a coupon on a shaker."""
    acoustic: Mapping[Text, AcousticTest] = {}
    """Acoustic tests by name, bare or damped."""
    microphones: MicrophoneTest | None = None
    """Measured levels of the sound for which the margin is."""

    needed: ClassVar = ("modal_survey", "impact_test", "coupon", "acoustic", "microphones")

    @property
    def text(self) -> str:
        """What was measured in words.

        Examples
        --------
        >>> survey = {"frequency_hz": {"1": 70, "2": 95}, "frequency_error": 0.01}
        >>> Update(modal_survey=survey).text
        'modal survey (2 values)'
        """
        parts = [
            f"{name} ({len(test.frequency_hz) + len(test.damping_ratio)} values)"
            for name, test in (
                ("modal survey", self.modal_survey),
                ("impact test", self.impact_test),
            )
            if test is not None
        ]
        parts += [f"coupon ({self.coupon.file.name})"] if self.coupon else []
        parts += [f"{name} ({len(test.measurements)} PSDs)" for name, test in self.acoustic.items()]
        return ", ".join([*parts, *(["microphones"] if self.microphones else [])])


def scenario_of_test(study: Study, name: str) -> Scenario:
    """Return the scenario of a measurement; the bare panel by default."""
    by_label = {scenario.label: scenario for scenario in study.all_scenarios()}
    return by_label[study.measurements[name].scenario or next(iter(by_label))]


def tested_scenarios(study: Study) -> list[Scenario]:
    """Return the scenarios with dampers of acoustic tests."""
    tests = study.update.acoustic.values() if study.update else ()
    scenarios = [scenario_of_test(study, name) for test in tests for name in test.measurements
             if name in study.measurements]  # fmt: skip
    return list(
        {scenario.label: scenario for scenario in scenarios if not scenario.is_bare}.values()
    )


def mistakes_of_update(study: Study, judged: list[Scenario]) -> Iterator[Mistake]:
    """Yield what of the section ``update`` the study does not go together with."""
    if study.update is None:
        return
    coupon, highest = study.update.coupon, study.response.frequency_hz[1]
    for survey in ("modal_survey", "impact_test"):
        for mode, value in getattr(getattr(study.update, survey), "frequency_hz", {}).items():
            if value > highest:
                message = f"must be at most {highest:g}, the end of the response"
                yield Mistake((survey, "frequency_hz", mode), message)
    patches = [patch for scenario in judged for patch in scenario.patches]
    if coupon is not None and coupon.patch not in (None, *patches):
        message = f"must be one of {', '.join(dict.fromkeys(patches))}"
        yield Mistake(("coupon", "patch"), message)
    if coupon is not None and not patches:
        yield Mistake(("coupon",), "no scenario has dampers")
    used: list[str] = []
    for title, test in study.update.acoustic.items():
        for index, name in enumerate(test.measurements):
            keys: Keys = ("acoustic", title, "measurements", index)
            if name in used:
                yield Mistake(keys, f"{name} is in a test already; it would count twice")
            used.append(name)
            if name not in study.measurements:
                names = ", ".join(study.measurements) or "none"
                yield Mistake(keys, f"no such measurement; names: {names}")
                continue
            measurement = study.measurements[name]
            scenario = scenario_of_test(study, name)
            if measurement.excitation == "base" or measurement.drive is not None:
                yield Mistake(keys, f"{name} is no measurement under sound")
            elif not scenario.is_bare and judged_like(scenario, judged) is None:
                message = f"{scenario.label} must have the dampers of a scenario that is judged"
                yield Mistake(keys, f"{message}, with the same fill fractions")
    levels = {s.oaspl_db or study.oaspl_db for s in tested_scenarios(study)}
    if len(levels) > 1:
        yield Mistake(("acoustic",), "tests with dampers must have one level")


def judged_like(scenario: Scenario, judged: list[Scenario]) -> int | None:
    """Return the number of the judged scenario with the same dampers; None for none."""
    for number, candidate in enumerate(judged):
        if (scenario.fillings, scenario.steady_acceleration_g) == (
            candidate.fillings, candidate.steady_acceleration_g,
        ):  # fmt: skip
            return number
    return None
