"""Rate limits. Pure: times are arguments."""

from __future__ import annotations

import math
from dataclasses import dataclass

from rosproto.bounded_cache import BoundedCache

MAX_ADDRESSES = 1000


@dataclass(slots=True)
class TokenBucket:
    """A rate limit: at most `burst` at once, and `rate` per second after that."""

    rate: float
    burst: float
    _level: float = math.inf
    _then: float = 0.0

    def take(self, now: float) -> bool:
        """Whether one more is allowed now."""
        # Refilled for the time since the last call, up to `burst`; full (inf) before the first one.
        self._level = min(self.burst, self._level + max(0.0, now - self._then) * self.rate)
        self._then = now
        if self._level < 1.0:
            return False
        self._level -= 1.0
        return True


class AddressBuckets:
    """A `TokenBucket` for each IP address; only the last `MAX_ADDRESSES` are remembered."""

    def __init__(self, rate: float, burst: float) -> None:
        self._rate, self._burst = rate, burst
        self._buckets: BoundedCache[str, TokenBucket] = BoundedCache(MAX_ADDRESSES)

    def take(self, address: str, now: float) -> bool:
        """Whether one more from this address is allowed now."""
        bucket = self._buckets.get(address) or TokenBucket(self._rate, self._burst)
        self._buckets.put(address, bucket)
        return bucket.take(now)
