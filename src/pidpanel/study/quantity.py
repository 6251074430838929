"""Numbers of a study: the bounds that physics sets to them, and the unit that was likely meant."""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from pidpanel.columns import NUMBER, Bounds
from pidpanel.study.mistakes import WORDS

# Numbers of YAML 1.2, without leading zeros; and those of other programs that are refused as such.
NUMERIC = re.compile(rf"(?![+-]?0\d){NUMBER.pattern}|(?i:[+-]?inf|[+-]?infinity|nan)")


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
class Quantity(Bounds):
    """Bounds of a number, for the annotation of a key.

    Examples
    --------
    >>> Quantity(0.01, 30, unit="metres").refuses(1500.0)
    'must be from 0.01 to 30; 1500 mm would be 1.5'
    >>> Quantity(0, 1, low_itself=False).refuses(0.5)
    ''
    """

    unit: str = ""  # key of `UNITS`, with those in which it may have been given by mistake
    whole: bool = False

    def __post_init__(self) -> None:
        _ = UNITS[self.unit]  # no other

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

    def _check_text(self, value: Any) -> Any:
        """Refuse truth values and texts that are no numbers in YAML 1.2; pydantic converts all."""
        if isinstance(value, bool) or (isinstance(value, str) and not NUMERIC.fullmatch(value)):
            words = {"whole": "whole " * self.whole, "hint": text_hint(value)}
            raise PydanticCustomError("number", "must be a {whole}number{hint}", words)
        return value

    def _check_bounds(self, value: float) -> float:
        if message := self.refuses(value):
            raise PydanticCustomError("quantity", "{message}", {"message": message})
        return value

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Return the schema of this quantity for pydantic."""
        number = core_schema.no_info_before_validator_function(self._check_text, handler(source))
        return core_schema.no_info_after_validator_function(self._check_bounds, number)

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
