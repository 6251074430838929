"""Numbers of a study: the bounds that physics sets to them, and the unit that was likely meant."""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from pidpanel.columns import NUMBER
from pidpanel.study.mistakes import WORDS

LEADING_ZEROS = re.compile(r"[+-]?0\d")


def level_of(pressure: float) -> float:
    """Return the level of an rms pressure [Pa], dB re 20 µPa; NaN for none.

    Examples
    --------
    >>> round(level_of(20.0), 6)
    120.0
    """
    return 20 * math.log10(pressure / 20e-6) if pressure > 0 else math.nan


# Conversion of a value in another unit, by the name of the required unit: a factor or a function.
UNITS: Mapping[str, Mapping[str, float | Callable[[float], float]]]
UNITS = {"": {}, "level": {"Pa": level_of}, **WORDS["units"]}


@dataclass(frozen=True)
class Quantity:
    """Bounds of a number, for the annotation of a key.

    Examples
    --------
    >>> Quantity(0.01, 30, unit="metres").refuses(1500.0)
    'must be from 0.01 to 30; 1500 mm would be 1.5'
    >>> Quantity(0, 1, low_itself=False).refuses(0.5)
    ''
    """

    low: float
    high: float = math.inf
    low_itself: bool = True  # whether the bound is allowed
    high_itself: bool = True
    unit: str = ""  # key of `UNITS`, with those in which it may have been given by mistake
    whole: bool = False

    def __post_init__(self) -> None:
        _ = UNITS[self.unit]  # no other

    @property
    def allowed(self) -> str:
        """Allowed values in words."""
        if self.high == math.inf:
            return f"must be {'at least' if self.low_itself else 'above'} {self.low:g}"
        if self.low_itself and self.high_itself:
            return f"must be from {self.low:g} to {self.high:g}"
        low = f"{'at least' if self.low_itself else 'above'} {self.low:g}"
        return f"must be {low} and {'at most' if self.high_itself else 'below'} {self.high:g}"

    def holds(self, value: float) -> bool:
        """Return whether a value lies within the bounds."""
        above_low = value >= self.low if self.low_itself else value > self.low
        return above_low and (value <= self.high if self.high_itself else value < self.high)

    def refuses(self, value: float) -> str:
        """Return what is allowed instead of a value, and what was likely meant; empty if it is."""
        if self.holds(value):
            return ""
        hint = self._unit_hint(value)
        return self.allowed + (f"; {hint}" if hint else "")

    def _unit_hint(self, value: float) -> str:
        """Return the value in the likeliest of the units: the one nearest the middle of the range.

        Distances are those of logarithms.
        """
        candidates: list[tuple[float, str]] = []
        low, high = max(self.low, self.high * 1e-9, 1e-300), self.high
        for unit, way in UNITS[self.unit].items():
            converted = way(value) if callable(way) else way * value
            if unit == "%" and value < 1:
                continue
            if converted > 0 and self.holds(converted):
                distance = abs(math.log(converted) - (math.log(low) + math.log(high)) / 2)
                candidates.append((distance, f"{value:g} {unit} would be {converted:.4g}"))
        return min(candidates)[1] if candidates else ""

    def number(self, value: Any) -> float | int:
        """Return a value as a number.

        Raises
        ------
        PydanticCustomError
            If it is none.
        """
        kind = "int" if self.whole else "float"
        if isinstance(value, str) and NUMBER.fullmatch(value) and not LEADING_ZEROS.match(value):
            value = float(value)
        if isinstance(value, bool) or not isinstance(value, Real):
            if isinstance(value, str) and value.lower().strip("+-.") in ("nan", "inf", "infinity"):
                raise PydanticCustomError("finite_number", "must be a finite number")
            message = "must be a whole number" if self.whole else "must be a number"
            raise PydanticCustomError(
                f"{kind}_type", "{message}", {"message": message + text_hint(value)}
            )
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise PydanticCustomError("finite_number", "must be a finite number")
        if not self.whole:
            return number
        if not isinstance(value, Integral) and number != math.floor(number):
            raise PydanticCustomError(
                "int_type", "{message}", {"message": "must be a whole number"}
            )
        return int(value) if isinstance(value, Integral) else int(number)

    def __call__(self, value: Any) -> float | int:
        """Return the number that a value is, for pydantic."""
        number = self.number(value)
        message = self.refuses(number)
        if message:
            raise PydanticCustomError("quantity", "{message}", {"message": message})
        return number

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Return the schema of this quantity for pydantic."""
        return core_schema.no_info_before_validator_function(self, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Return the JSON schema: a number with these bounds."""
        json_schema = handler(schema)
        json_schema["minimum" if self.low_itself else "exclusiveMinimum"] = self.low
        if self.high < math.inf:
            json_schema["maximum" if self.high_itself else "exclusiveMaximum"] = self.high
        return json_schema


def whole(low: int, high: int) -> Quantity:
    """Return the bounds of a count."""
    return Quantity(low, high, whole=True)


def inside(low: float, high: float) -> Quantity:
    """Return the bounds of a share or ratio that reaches neither."""
    return Quantity(low, high, low_itself=False, high_itself=False, unit="percent")


def text_hint(value: Any) -> str:
    """Return the hint for a text that is nearly a number."""
    if not isinstance(value, str):
        return ""
    if NUMBER.fullmatch(value):
        return " without leading zeros, which some programs read as octal"
    if re.fullmatch(r"[+-]?\d+,\d+", value):
        return ", with a decimal point"
    if re.fullmatch(rf"{NUMBER.pattern}\s*[^\W\d_%°].*|{NUMBER.pattern}\s*[%°]", value):
        return ", without its unit"
    return ""
