"""Delays between attempts: growing up to a limit, with some randomness."""

from __future__ import annotations

from collections.abc import Callable


class Backoff:
    """Growing delays. The randomness keeps many nodes from reconnecting at the same moment after a master
    restarts.

    Attributes:
        first: First delay, seconds.
        factor: Each delay is this many times the previous one.
        most: Longest delay, seconds, before the random part.
        jitter: Each delay is changed at random by up to this fraction of itself.
    """

    __slots__ = ("_delay", "_uniform", "factor", "first", "jitter", "most")

    def __init__(
        self,
        first: float = 0.1,
        factor: float = 2.0,
        most: float = 5.0,
        jitter: float = 0.2,
        uniform: Callable[[float, float], float] | None = None,
    ) -> None:
        if not (0 < first <= most and factor >= 1 and 0 <= jitter < 1):
            raise ValueError(
                f"Backoff(first={first}, factor={factor}, most={most}, jitter={jitter}): "
                "need 0 < first <= most, factor >= 1, 0 <= jitter < 1"
            )
        self.first, self.factor, self.most, self.jitter = first, factor, most, jitter
        self._uniform = uniform
        self._delay = first

    def next(self) -> float:
        """The delay before the next attempt, seconds."""
        delay = self._delay
        self._delay = min(self.most, delay * self.factor)
        if not self.jitter:
            return delay
        if self._uniform is None:
            import random  # only needed after a failure

            self._uniform = random.uniform
        return delay * (1.0 + self._uniform(-self.jitter, self.jitter))

    def reset(self) -> None:
        """Start with `first` again, after an attempt has succeeded."""
        self._delay = self.first
