"""Changed names: the old ones work for a release, with a DeprecationWarning (docs/releases.md)."""

from __future__ import annotations

import functools
import sys
import warnings
from collections.abc import Callable, Mapping
from typing import Any, ParamSpec, TypeVar

__all__ = ["former_attribute", "former_names", "former_parameters"]

P = ParamSpec("P")
T = TypeVar("T")


def former_names(module: str, now: Mapping[str, str]) -> Callable[[str], object]:
    """Make the `__getattr__` of a module some of whose names have changed.

    Args:
        module: Its `__name__`.
        now: The present name, or "module.name", of each old one.
    """

    def find(name: str) -> object:
        if name not in now:
            raise AttributeError(f"module {module!r} has no attribute {name!r}")
        warnings.warn(f"{module}.{name} is now {now[name]}", DeprecationWarning, stacklevel=2)
        place, _, present = now[name].rpartition(".")
        found: object = getattr(sys.modules[place or module], present)
        return found

    return find


def former_parameters(**now: str) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Decorate a function some of whose parameters have changed their names; `now` has the present names."""

    def decorate(function: Callable[P, T]) -> Callable[P, T]:
        @functools.wraps(function)
        def call(*args: P.args, **kwargs: P.kwargs) -> T:
            for name in kwargs.keys() & now.keys():
                warnings.warn(f"{name}= is now {now[name]}=", DeprecationWarning, stacklevel=2)
                if now[name] in kwargs:
                    raise TypeError(f"{name}= and {now[name]}= mean the same; give only the latter")
                kwargs[now[name]] = kwargs.pop(name)
            return function(*args, **kwargs)

        return call

    return decorate


def former_attribute(old: str, now: str) -> Any:
    """Make the property that stands for an attribute or method under its old name."""

    def get(this: Any) -> Any:
        warnings.warn(f"{type(this).__name__}.{old} is now {now}", DeprecationWarning, stacklevel=2)
        return getattr(this, now)

    def put(this: Any, value: Any) -> None:
        warnings.warn(f"{type(this).__name__}.{old} is now {now}", DeprecationWarning, stacklevel=2)
        setattr(this, now, value)

    return property(get, put, doc=f"Deprecated: `{now}`.")
