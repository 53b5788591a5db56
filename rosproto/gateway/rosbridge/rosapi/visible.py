"""The part of the graph that one gateway shows: the master's lists without the names its `Access` hides."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from rosproto.gateway.access import Kind, Refusal

__all__ = ["Asked", "Visible"]


class Asked(Protocol):
    """What is needed of an `Access` here."""

    def may_read(self, kind: Kind, name: str) -> Refusal | None: ...

    def may_write(self, kind: Kind, name: str, type: str = "") -> Refusal | None: ...


class Visible:
    """The decisions of an `Access`, as filters."""

    def __init__(self, access: Asked) -> None:
        self.access = access

    def shows(self, kind: Kind, name: str) -> bool:
        """True when clients may know about it."""
        return self.access.may_read(kind, name) is None

    def only(self, kind: Kind, names: Iterable[str]) -> list[str]:
        """Those that clients may know about, sorted, each once."""
        return sorted(name for name in set(names) if self.shows(kind, name))
