"""Particle impact damping of honeycomb panels under launch sound, from grains to PSDs."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pidpanel.api import Model, ResultsError, StudyError

    __version__: str

__all__ = ["Model", "ResultsError", "StudyError", "__version__"]


def __getattr__(name: str) -> Any:
    """Import what a notebook asks for once it does: a script needs none of it."""
    if name == "__version__":
        return import_module("importlib.metadata").version("pidpanel")
    if name in __all__:
        return getattr(import_module("pidpanel.api"), name)
    raise AttributeError(f"module 'pidpanel' has no attribute {name!r}")


def __dir__() -> list[str]:
    """Return what a notebook may ask for."""
    return list(__all__)
