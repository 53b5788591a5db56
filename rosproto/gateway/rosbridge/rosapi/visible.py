"""What of the graph one gateway shows: the master's lists without what its `Access` hides."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from rosproto.gateway.access import Kind, Refusal

__all__ = ["Asked", "Visible"]


class Asked(Protocol):
    """What is asked of an `Access` here."""

    def may_read(self, kind: Kind, name: str) -> Refusal | None: ...

    def may_write(self, kind: Kind, name: str, type: str = "") -> Refusal | None: ...


class Visible:
    """Verdicts of an `Access`, as filters."""

    def __init__(self, access: Asked) -> None:
        self.access = access

    def shows(self, kind: Kind, name: str) -> bool:
        """True when clients may know of it."""
        return self.access.may_read(kind, name) is None

    def only(self, kind: Kind, names: Iterable[str]) -> list[str]:
        """Those that clients may know of, sorted, each once."""
        return sorted(name for name in set(names) if self.shows(kind, name))
