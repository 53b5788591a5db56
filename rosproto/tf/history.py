"""What is known of one edge of the tree over time, with interpolation: no clock, no I/O.

Source: tf2 time_cache.cpp, static_cache.cpp.
"""

from __future__ import annotations

from bisect import bisect_left
from typing import NamedTuple

from rosproto import quaternion
from rosproto.quaternion import Quaternion, Vector

__all__ = ["History", "Sample"]


class Sample(NamedTuple):
    """Pose of the child in its parent at one moment (`stamp` in ns)."""

    stamp: int
    parent: str
    translation: Vector
    rotation: Quaternion


class History:
    """Samples of one child frame, oldest first.

    Attributes:
        static: True when the newest sample holds for all times.
        authority: Node that sent the last one.
    """

    __slots__ = ("_cache_ns", "_most", "_samples", "_stamps", "authority", "static")

    def __init__(self, cache_ns: int, most: int) -> None:
        self._cache_ns = cache_ns
        self._most = most
        self._samples: list[Sample] = []
        self._stamps: list[int] = []
        self.static = False
        self.authority = ""

    def add(self, sample: Sample, *, static: bool) -> bool:
        """Take a sample; False when it is older than the cache or repeats a stamp (the first one stays)."""
        if static or self.static:
            self._samples, self._stamps, self.static = [], [], static
        if self._stamps and sample.stamp < self._stamps[-1] - self._cache_ns:
            return False
        at = bisect_left(self._stamps, sample.stamp)
        if at < len(self._stamps) and self._stamps[at] == sample.stamp:
            return False
        self._samples.insert(at, sample)
        self._stamps.insert(at, sample.stamp)
        self._forget()
        return True

    def _forget(self) -> None:
        old = bisect_left(self._stamps, self._stamps[-1] - self._cache_ns)
        old = max(old, len(self._stamps) - self._most)
        if old > 0:
            del self._samples[:old], self._stamps[:old]

    @property
    def earliest(self) -> int:
        return self._stamps[0]

    @property
    def newest(self) -> Sample:
        return self._samples[-1]

    def __len__(self) -> int:
        return len(self._samples)

    def at(self, stamp: int) -> Sample | None:
        """The pose at a time; None when that lies outside what is known."""
        if self.static:
            return self._samples[-1]
        at = bisect_left(self._stamps, stamp)
        if at == len(self._stamps):
            return None
        after = self._samples[at]
        if after.stamp == stamp:
            return after
        return self._between(self._samples[at - 1], after, stamp) if at else None

    @staticmethod
    def _between(before: Sample, after: Sample, stamp: int) -> Sample:
        if before.parent != after.parent:
            return before  # it moved to another parent in between; what was, holds until then
        ratio = (stamp - before.stamp) / (after.stamp - before.stamp)
        (x0, y0, z0), (x1, y1, z1) = before.translation, after.translation
        moved = (x0 + (x1 - x0) * ratio, y0 + (y1 - y0) * ratio, z0 + (z1 - z0) * ratio)
        turned = quaternion.slerp(before.rotation, after.rotation, ratio)
        return Sample(stamp, before.parent, moved, turned)
