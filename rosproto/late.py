"""Names of a package that are imported with their first use (PEP 562)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module

__all__ = ["late_names"]


def late_names(package: str, homes: Mapping[str, str]) -> Callable[[str], object]:
    """The `__getattr__` of a package whose names stand in modules of it.

    Args:
        package: Its `__name__`.
        homes: Each name, and the module it is defined in; `module:name` where it has another name there.
    """

    def find(name: str) -> object:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module, _, known_as = homes[name].partition(":")
        return getattr(import_module(f"{package}.{module}"), known_as or name)

    return find
