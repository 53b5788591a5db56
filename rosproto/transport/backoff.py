"""Delays between attempts: growing up to a limit, with some randomness."""

from __future__ import annotations


class Backoff:
    """Growing delays. The randomness keeps many nodes from reconnecting at the same moment after a master
    restarts.

    Args:
        first: First delay, seconds.
        factor: Each delay is this many times the previous one.
        maximum: Longest delay, seconds, before the random part.
        jitter: Each delay is changed at random by up to this fraction of itself.
    """

    __slots__ = ("_delay", "_factor", "_first", "_jitter", "_maximum")

    def __init__(
        self, first: float = 0.1, factor: float = 2.0, maximum: float = 5.0, jitter: float = 0.2
    ) -> None:
        self._first, self._factor, self._maximum, self._jitter = first, factor, maximum, jitter
        self._delay = first

    def next(self) -> float:
        """The delay before the next attempt, seconds."""
        from random import uniform  # only needed after a failure

        delay = self._delay
        self._delay = min(self._maximum, delay * self._factor)
        return delay * (1.0 + uniform(-self._jitter, self._jitter))

    def reset(self) -> None:
        """Start with `first` again, after an attempt has succeeded."""
        self._delay = self._first
