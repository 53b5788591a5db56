"""Properties of an awaited object that are those of the threaded one underneath."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Generic, TypeVar, overload

R = TypeVar("R")
V = TypeVar("V")


class SameProperty(property, Generic[R]):
    """`done = SameProperty[bool](ThreadedHandle.done, "handle")`: the value and the text of that property.

    The type is written for editors; mypy compares it with the threaded property's.

    Args:
        of: The property of the threaded class.
        held_in: The attribute of the awaited object that holds the threaded one.
        view: Converts the value, given the awaited object; None returns it unchanged.
    """

    @overload
    def __init__(self, of: Callable[[Any], R], held_in: str) -> None: ...
    @overload
    def __init__(self, of: Callable[[Any], V], held_in: str, view: Callable[[Any, V], R]) -> None: ...
    def __init__(
        self, of: Callable[[Any], object], held_in: str, view: Callable[[Any, Any], object] | None = None
    ) -> None:
        get = getattr(of, "fget", None) or of

        def read(owner: object) -> object:
            value = get(getattr(owner, held_in))
            return value if view is None else view(owner, value)

        super().__init__(read)
        self.__doc__ = of.__doc__  # `doc=` of a subclass is hidden by the text of the class

    if TYPE_CHECKING:

        def __get__(self, instance: object, owner: type | None = None) -> R: ...  # type: ignore[override]
