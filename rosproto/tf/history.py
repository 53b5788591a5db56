"""What is known of one edge of the tree over time, with interpolation: no clock, no I/O.

Source: tf2 cache.cpp, static_cache.cpp (what is kept, and the order of the arithmetic).
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from typing import NamedTuple

from rosproto import quaternion
from rosproto.quaternion import Quaternion, Vector

__all__ = ["History", "Sample"]

OLD = "older than the cache"
REPEATED = "the stamp is known already"


class Sample(NamedTuple):
    """Pose of the child in its parent at one moment (`stamp` in ns)."""

    stamp: int
    parent: str
    translation: Vector
    rotation: Quaternion


class History:
    """Samples of one child frame, oldest first; of a static one the last, which holds at all times.

    Args:
        cache_ns: How much older than the newest a sample may be.
        most: Samples that are kept at most; None for no bound.
        static: True when the frame does not move.

    Attributes:
        static: True when the frame does not move.
        authority: Node that sent the last one.
    """

    __slots__ = ("_cache_ns", "_most", "_samples", "_stamps", "authority", "static")

    def __init__(self, cache_ns: int, most: int | None = None, *, static: bool = False) -> None:
        self._cache_ns = cache_ns
        self._most = most
        self._samples: list[Sample] = []
        self._stamps: list[int] = []
        self.static = static
        self.authority = ""

    def add(self, sample: Sample) -> str | None:
        """Take a sample; why it was not taken (`OLD`, or `REPEATED`: the first one stays), or None."""
        if self.static:
            self._samples, self._stamps = [sample], [sample.stamp]
            return None
        if self._stamps and sample.stamp < self._stamps[-1] - self._cache_ns:
            return OLD
        at = bisect_left(self._stamps, sample.stamp)
        if at < len(self._stamps) and self._stamps[at] == sample.stamp:
            return REPEATED
        self._samples.insert(at, sample)
        self._stamps.insert(at, sample.stamp)
        self._forget()
        return None

    def _forget(self) -> None:
        old = bisect_left(self._stamps, self._stamps[-1] - self._cache_ns)
        if self._most is not None:
            old = max(old, len(self._stamps) - self._most)
        if old > 0:
            del self._samples[:old], self._stamps[:old]

    def clear(self) -> None:
        """Forget all, unless it is static: that holds whatever the clock does."""
        if not self.static:
            self._samples, self._stamps = [], []

    @property
    def earliest(self) -> int:
        return self._stamps[0]

    @property
    def newest(self) -> Sample:
        return self._samples[-1]

    def __len__(self) -> int:
        return len(self._samples)

    def at(self, stamp: int) -> Sample | None:
        """The pose at a time, 0 for the newest; None when that lies outside what is known."""
        stamps = self._stamps
        if not stamps:
            return None
        if self.static or stamp in (0, stamps[-1]):
            return self._samples[-1]
        if stamp == stamps[0]:
            return self._samples[0]
        if not stamps[0] < stamp < stamps[-1]:
            return None
        after = bisect_right(stamps, stamp)
        return _between(self._samples[after - 1], self._samples[after], stamp)


def seconds(ns: int) -> float:
    """Nanoseconds as roscpp's toSec() gives them."""
    whole, rest = divmod(ns, 1_000_000_000)
    return float(whole) + 1e-9 * rest


def _between(before: Sample, after: Sample, stamp: int) -> Sample:
    if before.parent != after.parent:
        return before  # it moved to another parent in between; what was, holds until then
    ratio = seconds(stamp - before.stamp) / seconds(after.stamp - before.stamp)
    rest = 1.0 - ratio
    (x0, y0, z0), (x1, y1, z1) = before.translation, after.translation
    moved = (rest * x0 + ratio * x1, rest * y0 + ratio * y1, rest * z0 + ratio * z1)
    return Sample(stamp, before.parent, moved, quaternion.slerp(before.rotation, after.rotation, ratio))
