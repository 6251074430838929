"""Numbers that may be stated with a standard error, as ``{value: 0.3, error: 0.05}``."""

from typing import Annotated, Any, NamedTuple

from pydantic import GetCoreSchemaHandler, ValidatorFunctionWrapHandler
from pydantic_core import CoreSchema, core_schema

from pidpanel.study.base import Fill, SectionModel
from pidpanel.study.choice import Choice
from pidpanel.study.quantity import Quantity

StandardError = Annotated[float, Quantity(0, 0.5)]


class StatedNumber(SectionModel):
    """A number with its standard error."""

    value: float
    """Value."""
    error: StandardError
    """Standard error of ``value``, which enters the uncertainty of the results."""


class Tolerated(float):
    """A number with its standard error; a plain one to all that do not ask for `error_of`."""

    error = 0.0


class OrStated(NamedTuple):
    """For the annotation of a number, here a type, that may also be a `StatedNumber`."""

    number: Any

    def __get_pydantic_core_schema__(self, _: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the schema for pydantic; a `StatedNumber` becomes a `Tolerated`."""
        schema = handler.generate_schema(Annotated[self.number | StatedNumber, Choice()])
        return core_schema.no_info_wrap_validator_function(_as_number, schema)


def _as_number(value: Any, handler: ValidatorFunctionWrapHandler) -> Any:
    stated = value if isinstance(value, Tolerated) else handler(value)
    if isinstance(stated, StatedNumber):
        error, stated = stated.error, Tolerated(handler(stated.value))
        stated.error = error
    return stated


def error_of(value: Any) -> float:
    """Return the standard error of a number or section; 0 if none is stated."""
    return float(getattr(value, "error", 0.0))


FillFraction = Annotated[float, OrStated(Fill)]
