"""Names of a package that are imported with their first use (PEP 562)."""

from __future__ import annotations

TYPE_CHECKING = False  # as in typing: packages that have late names must be quick to import
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

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
        module, _, other = homes[name].partition(":")
        known_as = other or name
        # What importlib.import_module would do, without the time that importing importlib takes.
        return getattr(__import__(f"{package}.{module}", fromlist=(known_as,)), known_as)

    return find
