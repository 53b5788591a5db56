"""Who may try to connect with a broker now. Pure: the clock is given.

Hundreds of lines of one process lose a broker in the same moment. While it does not answer only one of them
knocks, about once a second: a refused connection costs nothing, and the broker is found within about a second
of its return. Once it answers the others follow, a few at a time, so that a broker that has just begun is not
stormed. A line that reaches a broker and is sent away (a wrong password, too many clients, a broker that
takes the connection and says nothing) waits for itself, longer each time and a little at random: many
processes do not knock in step.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Generic, TypeVar

__all__ = ["TOGETHER", "Turns", "Waits"]

TOGETHER = 8
"""Lines that connect at the same time."""
_KNOCKS = (0.2, 2.0, 1.0, 0.3)  # between two tries while nobody answers, as `Waits` has them

Who = TypeVar("Who")


class Waits:
    """Growing waits, each a little at random.

    Args:
        first, factor, most: Seconds of the first wait, how many times as long each next one is, and at most.
        jitter: A wait is longer or shorter by up to this share of itself.
        uniform: Makes the random numbers.
    """

    def __init__(
        self,
        first: float,
        factor: float,
        most: float,
        jitter: float,
        uniform: Callable[[float, float], float] | None = None,
    ) -> None:
        self._first, self._factor, self._most, self._jitter = first, factor, most, jitter
        self._uniform = uniform or random.uniform
        self._wait = first

    def next(self) -> float:
        """Seconds until the next try."""
        wait = self._wait
        self._wait = min(self._most, wait * self._factor)
        return wait * (1.0 + self._uniform(-self._jitter, self._jitter))

    def reset(self) -> None:
        """Begin with the first again."""
        self._wait = self._first


class Turns(Generic[Who]):
    """The tries to connect with one broker.

    Attributes:
        answers: Whether the broker answered when it was tried last.
    """

    def __init__(self, uniform: Callable[[float, float], float] | None = None) -> None:
        self.answers = True
        self._waiting: dict[Who, float] = {}  # when each may try, in the order in which they asked
        self._trying: set[Who] = set()
        self._knocks = Waits(*_KNOCKS, uniform)
        self._next = 0.0

    def __bool__(self) -> bool:
        """Whether somebody waits or tries."""
        return bool(self._waiting or self._trying)

    def ask(self, who: Who, not_before: float = 0.0) -> None:
        """It wants to connect, not before a time of the clock."""
        self._trying.discard(who)
        self._waiting[who] = not_before

    def begin(self, now: float) -> list[Who]:
        """Those whose turn it is; each must tell by `reached`, `failed` or `forget` how it went."""
        if now < self._next:
            return []
        free = (TOGETHER if self.answers else 1) - len(self._trying)
        found = [who for who, due in self._waiting.items() if due <= now][: max(0, free)]
        for who in found:
            del self._waiting[who]
            self._trying.add(who)
        return found

    def reached(self, who: Who) -> None:
        """The broker took it."""
        self._trying.discard(who)
        self.answers, self._next = True, 0.0
        self._knocks.reset()

    def failed(self, who: Who, now: float, *, there: bool) -> None:
        """It did not get in.

        Args:
            who: The line; it asks again if it wants to.
            now: The time.
            there: Whether the broker answered at all.
        """
        self._trying.discard(who)
        if not there:
            self.answers = False
            if now >= self._next:  # several who tried together are one knock
                self._next = now + self._knocks.next()

    def forget(self, who: Who) -> None:
        """It wants nothing any more."""
        self._trying.discard(who)
        self._waiting.pop(who, None)

    def due(self) -> float | None:
        """When `begin` may have somebody; None while only the end of a try can change that."""
        if not self._waiting or len(self._trying) >= (TOGETHER if self.answers else 1):
            return None
        return max(self._next, min(self._waiting.values()))
