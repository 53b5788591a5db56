"""Who may try to connect with a broker now. Pure: the clock is given.

Hundreds of connections of one process lose a broker in the same moment. While it does not answer, only one of
them tries, about once a second: a refused attempt costs next to nothing, and the broker is found within about
a second of its return. Once it answers the others follow, a few at a time, so that a broker that has just
started is not overrun. A connection that reaches a broker and is turned away (a wrong password, too many
clients, a broker that accepts and says nothing) waits on its own, longer each time and a little at random, so
that many processes do not try in step.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

from rosproto.transport import Backoff

__all__ = ["TOGETHER", "ConnectionAttempts"]

TOGETHER = 8
"""Connections that are opened at the same time."""
_WAITS = (0.2, 2.0, 1.0, 0.3)  # between two tries while nobody answers, as `Backoff` has them

Who = TypeVar("Who")


class ConnectionAttempts(Generic[Who]):
    """The attempts to connect with one broker.

    Attributes:
        answers: Whether the broker answered when it was tried last.
    """

    def __init__(self, uniform: Callable[[float, float], float] | None = None) -> None:
        self.answers = True
        self._waiting: dict[Who, float] = {}  # when each may try, in the order in which they asked
        self._trying: set[Who] = set()
        self._waits = Backoff(*_WAITS, uniform)
        self._next = 0.0

    def __bool__(self) -> bool:
        """Whether somebody waits or tries."""
        return bool(self._waiting or self._trying)

    def request(self, who: Who, not_before: float = 0.0) -> None:
        """It wants to connect, not before a time of the clock."""
        self._trying.discard(who)
        self._waiting[who] = not_before

    def begin(self, now: float) -> list[Who]:
        """Those whose turn it is; each must tell by `succeeded`, `failed` or `forget` how it went."""
        if now < self._next:
            return []
        free = (TOGETHER if self.answers else 1) - len(self._trying)
        found = [who for who, due in self._waiting.items() if due <= now][: max(0, free)]
        for who in found:
            del self._waiting[who]
            self._trying.add(who)
        return found

    def succeeded(self, who: Who) -> None:
        """The broker took it."""
        self._trying.discard(who)
        self.answers, self._next = True, 0.0
        self._waits.reset()

    def failed(self, who: Who, now: float, *, there: bool) -> None:
        """It did not get in.

        Args:
            who: The connection; it asks again if it wants to.
            now: The time.
            there: Whether the broker answered at all.
        """
        self._trying.discard(who)
        if not there:
            self.answers = False
            if now >= self._next:  # several who tried together count as one attempt
                self._next = now + self._waits.next()

    def forget(self, who: Who) -> None:
        """It wants nothing any more."""
        self._trying.discard(who)
        self._waiting.pop(who, None)

    def due(self) -> float | None:
        """When `begin` may have somebody; None while only the end of a try can change that."""
        if not self._waiting or len(self._trying) >= (TOGETHER if self.answers else 1):
            return None
        return max(self._next, min(self._waiting.values()))
