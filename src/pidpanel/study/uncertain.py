"""The sections ``uncertain`` and ``margin`` of a study: inputs with spreads, and what is judged."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from statistics import NormalDist
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, TypeVar, get_args

from pydantic import BaseModel

from pidpanel.constants import REACH
from pidpanel.study.base import SectionModel, Text
from pidpanel.study.mistakes import Keys, Mistake
from pidpanel.study.particles import ImpactRestitution
from pidpanel.study.quantity import Quantity, inside, whole
from pidpanel.study.stated_number import OrStated, Tolerated
from pidpanel.study.update import judged_like, mistakes_of_update, tested_scenarios

if TYPE_CHECKING:
    from pidpanel.study.study import Study

T = TypeVar("T")

ENDS = NormalDist().inv_cdf(0.95)  # of a normal spread, in standard deviations
SPECTRUM, SHIFT = "sound.spectrum", "sound.shift_db"
SHIFT_DB = 20.0  # largest deviation of a third octave at 95 % or the end of the spread
FIELDS = ("diffuse", "uniform", "uncorrelated")  # whose modal force is real and tabulated
# Keys with a spread, as patterns.
ALLOWED = (
    r"panel\.(damping_ratio|section\..+|supports\..*stiffness\w*|masses\..+\.mass_kg)",
    r"panel\.patches\..+\.centre_m\.[01]",
    r"sound\.(spectrum|shift_db|speed_m_s|air_density_kg_m3)",
    r"dampers\..+",
    r"scenarios\..+\.fill_fraction",
)


class Spread(SectionModel):
    """The spread of a number: ``normal`` and ``lognormal`` by their 5 and 95 %."""

    normal: tuple[float, float] | None = None
    """5 and 95 % of a normal distribution, in the unit of the key."""
    lognormal: tuple[float, float] | None = None
    """5 and 95 % of a lognormal distribution."""
    uniform: tuple[float, float] | None = None
    """Ends of a uniform distribution."""
    source: Text
    """Where the spread is from; it stands on the page. "assumed" says that it has no source."""
    correlation_octaves: Annotated[float, Quantity(0.01, 100)] | None = None
    """Of ``sound.spectrum``, whose spread is that of each third octave about its level [dB]: the
    distance at which the correlation of two bands has fallen to 1/e [octaves]."""

    forms: ClassVar = (("normal",), ("lognormal",), ("uniform",))

    def mistakes(self) -> Iterator[Mistake]:
        low, high = self.ends
        if not low < high:
            yield Mistake((self.kind,), "must be two values, the second above the first")
        elif self.lognormal is not None and low <= 0:
            yield Mistake(("lognormal",), "must be two values above 0")
        if not self.source.strip():
            yield Mistake(("source",), 'must say where the spread is from, or "assumed"')

    @property
    def kind(self) -> str:
        """``normal``, ``lognormal`` or ``uniform``."""
        return next(key for (key,) in self.forms if getattr(self, key) is not None)

    @property
    def ends(self) -> tuple[float, float]:
        """The two values."""
        low, high = getattr(self, self.kind)
        return low, high

    def value(self, z: float) -> float:
        """Return the value at a standard normal z, within `REACH`."""
        (low, high), z = self.ends, min(max(z, -REACH), REACH)
        if self.uniform is not None:
            return low + (high - low) * NormalDist().cdf(z)
        if self.lognormal is not None:
            low, high = math.log(low), math.log(high)
        value = (low + high) / 2 + z / ENDS * (high - low) / 2
        return math.exp(value) if self.lognormal is not None else value

    @property
    def deviation(self) -> float:
        """Standard deviation of the spread of a level about 0 [dB]."""
        low, high = self.ends
        return (high - low) / (math.sqrt(12) if self.uniform is not None else 2 * ENDS)


class Correlation(SectionModel):
    """Two inputs that vary together."""

    keys: tuple[Text, Text]
    """Keys of ``uncertain``."""
    coefficient: Annotated[float, inside(-1, 1)]
    """Correlation of their normal scores."""


class Errors(SectionModel):
    """Errors of measurements that could be made next, as standard deviations."""

    frequency: Annotated[float, inside(0, 0.5)] = 0.005
    """Relative error of natural frequencies of a modal survey; twice that of an impact test."""
    damping_ratio: Annotated[float, inside(0, 1)] = 0.1
    """Relative error of ζ of a modal survey; twice that of an impact test."""
    level_db: Annotated[float, Quantity(0.01, 10)] = 0.5
    """Error of an octave of an acoustic test, and of the level by microphones [dB]."""
    common_db: Annotated[float, Quantity(0, 10)] = 0.3
    """Error common to all octaves, and to bare and damped panel, as by a calibration [dB]."""
    coupon: Annotated[float, inside(0, 1)] = 0.05
    """Relative error of C_e of a coupon on a shaker."""
    common_damping: Annotated[float, Quantity(0, 1)] = 1.0
    """Correlation of the error of C_e at the level of a test and of the launch."""


class Margin(SectionModel):
    """What is judged with the spreads of ``uncertain``."""

    factor_of_safety: Annotated[float, Quantity(1, 5)] = 1.25
    """Factor of safety on 3σ of the acceleration."""
    scenarios: tuple[Text, ...] = ()
    """Scenarios to compute, by name; by default all with dampers."""
    correlations: tuple[Correlation, ...] = ()
    """Inputs that vary together."""
    runs_at_most: Annotated[int, whole(32, 4096)] = 256
    """Most runs; they end at 128 where the surrogate explains 98 % of the variance."""
    test_errors: Errors = Errors()
    """Errors of the measurements among which the next is advised."""


def number_at(section: Any, keys: Sequence[str]) -> Any:
    """Return the value at a way; `KeyError` where there is none."""
    for key in keys:
        if isinstance(section, BaseModel):
            if key not in type(section).model_fields:
                raise KeyError(key)
            section = getattr(section, key)
        elif isinstance(section, Mapping):
            section = section[key]
        elif isinstance(section, tuple) and key.isdigit() and int(key) < len(section):
            section = section[int(key)]
        else:
            raise KeyError(key)
    return section


def with_number(section: T, keys: Sequence[str], value: float) -> T:
    """Return a section with another number at a way."""
    if not keys:
        return value  # type: ignore[return-value]
    key, *further = keys
    if isinstance(section, BaseModel):
        changed = with_number(getattr(section, key), further, value)
        return section.model_copy(update={key: changed})
    if isinstance(section, Mapping):
        return {**section, key: with_number(section[key], further, value)}  # type: ignore[return-value]
    parts = list(section)  # type: ignore[call-overload]
    parts[int(key)] = with_number(parts[int(key)], further, value)
    return tuple(parts)  # type: ignore[return-value]


def way_of(study: Study, key: str) -> list[str]:
    """Return the way of a dotted key; names with dots count as one."""
    keys, section, names = [], study, key.split(".")
    while names:
        for length in range(1, len(names) + 1):
            name = ".".join(names[:length])
            try:
                section = number_at(section, [name])
            except KeyError:
                continue
            keys.append(name)
            names = names[length:]
            break
        else:
            raise KeyError(names[0])
    return keys


def bounds_at(study: Study, keys: Sequence[str]) -> Quantity | None:
    """Return the bounds of the number at a way; None where its model states none."""
    for depth in range(len(keys) - 1, 0, -1):
        owner = number_at(study, keys[:depth])
        if isinstance(owner, BaseModel) and keys[depth] in type(owner).model_fields:
            entry = type(owner).model_fields[keys[depth]]
            return _quantity((entry.annotation, *entry.metadata))
    return None


def _quantity(parts: Sequence[Any]) -> Quantity | None:
    for part in parts:
        if isinstance(part, Quantity):
            return part
        if isinstance(part, OrStated):
            part = part.number
        metadata = getattr(part, "__metadata__", ()) + get_args(part)
        if quantity := _quantity([p for p in metadata if p is not part]):
            return quantity
    return None


def varied(study: Study, values: Mapping[str, float]) -> Study:
    """Return a study with other numbers at dotted keys; levels of bands are left."""
    for key, value in values.items():
        if key != SPECTRUM:
            study = with_number(study, way_of(study, key), value)
    return study


def mistakes_of_margin(study: Study) -> Iterator[Mistake]:
    """Yield what of the sections ``uncertain`` and ``margin`` a study does not go together with."""
    uncertain = study.uncertain
    if not uncertain:
        if "margin" in study.model_fields_set:
            yield Mistake(("margin",), "only allowed with uncertain")
        if study.update is not None:
            yield Mistake(("update",), "only allowed with uncertain")
        return
    if study.sound is None or study.sound.field not in FIELDS:
        keys: Keys = ("uncertain",) if study.sound is None else ("sound", "field")
        yield Mistake(
            keys, f"with uncertain, a sound must be {', '.join(FIELDS[:2])} or {FIELDS[2]}"
        )
        return
    if getattr(study.panel, "section", None) is None or not hasattr(study.panel, "outline_m"):
        yield Mistake(("uncertain",), "only allowed for a panel; structures have their modes")
        return
    if study.response.modal_damping == "diagonal" or study.damping.level.by == "element":
        yield Mistake(("uncertain",), "only allowed with response.modal_damping: full and "
                      "damping.level.by: patch")  # fmt: skip
        return
    errors = [entry for part in ("dampers", "scenarios")
              for entry in _with_errors(getattr(study, part), (part,))]  # fmt: skip
    for way, value, error in errors:
        ends = f"{value - ENDS * error:.4g}, {value + ENDS * error:.4g}"
        yield Mistake(way, "an error of its own does not count with uncertain; must be a spread "
                      f"there: {{normal: [{ends}], source: …}}")  # fmt: skip
    if errors:
        return
    for key, spread in uncertain.items():
        yield from (m.prefix("uncertain", key) for m in _mistakes_of_key(study, key, spread))
    yield from (mistake.prefix("margin") for mistake in _mistakes_of_settings(study))
    mistakes = mistakes_of_update(study, judged_scenarios(study))
    yield from (mistake.prefix("update") for mistake in mistakes)


def _with_errors(section: Any, way: Keys) -> Iterator[tuple[Keys, float, float]]:
    """Yield ways, values and standard errors of numbers that state one."""
    if isinstance(section, Tolerated):
        yield way, section, section.error
    elif isinstance(section, ImpactRestitution) and section.error:
        yield (*way, "value"), section.value, section.error
    entries: Any = section.items() if isinstance(section, Mapping) else ()
    if isinstance(section, BaseModel):
        entries = ((key, getattr(section, key)) for key in type(section).model_fields)
    elif isinstance(section, tuple):
        entries = enumerate(section)
    for key, value in entries:
        yield from _with_errors(value, (*way, key))


def _mistakes_of_key(study: Study, key: str, spread: Spread) -> Iterator[Mistake]:
    if not any(re.fullmatch(pattern, key) for pattern in ALLOWED):
        yield Mistake((), "must be panel.damping_ratio, a number of panel.section, a stiffness of "
                      "panel.supports, mass_kg of panel.masses, panel.patches.<name>.centre_m.0 "
                      "or .1, sound.spectrum, shift_db, speed_m_s or air_density_kg_m3, a number "
                      "of dampers, or a fill_fraction of scenarios")  # fmt: skip
        return
    is_level = key in (SPECTRUM, SHIFT)
    if is_level and study.acoustics.level == "p95_50":
        yield Mistake((), "not allowed with sound.level: p95_50, which contains the scatter of the "
                      "level; it would count twice")  # fmt: skip
    elif is_level and study.acoustics.level is None:
        yield Mistake((), "required: sound.level, median or test: what the levels are")
    if (key == SPECTRUM) != (spread.correlation_octaves is not None):
        message = f"required for {SPECTRUM}, not allowed otherwise"
        yield Mistake(("correlation_octaves",), message)
    if key == SPECTRUM:
        if spread.lognormal is not None:
            yield Mistake(("lognormal",), "must be normal or uniform; levels are in dB")
        elif not -SHIFT_DB <= spread.ends[0] == -spread.ends[1]:
            message = f"must be -x and x, at most {SHIFT_DB:g} dB: deviations of bands about their "
            yield Mistake((spread.kind,), f"{message}level; sound.shift_db moves all")  # fmt: skip
        return
    try:
        keys = way_of(study, key)
        value = number_at(study, keys)
    except KeyError as error:
        yield Mistake((), f"no such key in this study: {error.args[0]}; state it, then its spread")
        return
    if isinstance(value, bool) or not isinstance(value, int | float):
        type_name = "no value" if value is None else f"a {type(value).__name__}"
        yield Mistake((), f"must be the key of a number; it has {type_name}")
        return
    bounds, reach = bounds_at(study, keys), (spread.value(-REACH), spread.value(REACH))
    if not reach[0] <= value <= reach[1]:
        reaches = f"it is from {reach[0]:.4g} to {reach[1]:.4g} at {REACH:g} σ"
        message = f"must contain the number of the study, {value:g}; {reaches}"
        yield Mistake((spread.kind,), message)
        return
    for end in reach:
        if bounds is not None and (message := bounds.refuses(end)):
            yield Mistake((spread.kind,), f"reaches {end:.4g} at {REACH:g} σ; {message}")
            return
        changed = number_at(with_number(study, keys, end), keys[:1])
        part = changed if isinstance(changed, SectionModel) else changed[keys[1]]
        for mistake in part.mistakes():
            yield Mistake((spread.kind,), f"reaches {end:.4g} at {REACH:g} σ; {mistake.message}")
            return


def _mistakes_of_settings(study: Study) -> Iterator[Mistake]:
    margin, labels = study.margin, [s.label for s in study.all_scenarios() if not s.is_bare]
    for index, name in enumerate(margin.scenarios):
        if name not in labels:
            message = f"must be one of {', '.join(labels)}" if labels else "no scenario has dampers"
            yield Mistake(("scenarios", index), message)
    if coupled := [s.label for s in judged_scenarios(study) if study.is_coupled_scenario(s)]:
        message = "coupled runs know the damping at one motion alone; give the damper model: atlas"
        yield Mistake(("scenarios",), f"{', '.join(coupled)}: {message}")
    for index, correlation in enumerate(margin.correlations):
        keys: Keys = ("correlations", index)
        for place, key in enumerate(correlation.keys):
            if key not in study.uncertain or key == SPECTRUM:
                yield Mistake((*keys, "keys", place), "must be a key of uncertain, not a spectrum")
                return
        pairs = [set(other.keys) for other in margin.correlations[:index]]
        if correlation.keys[0] == correlation.keys[1] or set(correlation.keys) in pairs:
            yield Mistake((*keys, "keys"), "must be two different keys, each pair once")
            return
    if margin.correlations:
        import numpy as np

        lowest = float(np.linalg.eigvalsh(correlation_matrix(study)).min())
        if lowest <= 0:
            yield Mistake(("correlations",), "must be positive definite together; the lowest "
                          f"eigenvalue of their matrix is {lowest:.3g}")  # fmt: skip


def correlation_matrix(study: Study) -> Any:
    """Return the correlation (n, n) of the keys with spreads, but that of the spectrum."""
    import numpy as np

    keys = [key for key in study.uncertain if key != SPECTRUM]
    matrix = np.eye(len(keys))
    for correlation in study.margin.correlations:
        first, second = (keys.index(key) for key in correlation.keys)
        matrix[first, second] = matrix[second, first] = correlation.coefficient
    return matrix


def judged_scenarios(study: Study) -> list[Any]:
    """Return the scenarios with dampers that are judged: all that are no test of another one."""
    judged: list[Any] = []
    named = study.margin.scenarios
    tests = [scenario.label for scenario in tested_scenarios(study)]
    launched = [s for s in study.all_scenarios() if not s.is_bare and s.label not in tests]
    for scenario in study.all_scenarios():
        like = judged_like(scenario, [*launched, *judged])
        is_test = scenario.label in tests and like is not None
        if scenario.label in named or not (named or scenario.is_bare or is_test):
            judged.append(scenario)
    return judged
