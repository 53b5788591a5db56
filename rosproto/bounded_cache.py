"""A bounded cache for what peers send; the least recently used entry is removed first.

Use it wherever the key comes from the network (a definition, an md5sum, a node's name): a plain dict would
grow as long as new keys arrive.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Hashable
from typing import Generic, TypeVar

__all__ = ["BoundedCache"]

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")


class BoundedCache(Generic[K, V]):
    """A thread-safe cache with a limit on entries and on weight.

    Args:
        max_entries: Most entries.
        weight: Most weight of all entries together; a heavier single entry is not stored.
    """

    def __init__(self, max_entries: int, weight: int = 1 << 62) -> None:
        self.max_entries = max_entries
        self.weight = weight
        self._entries: OrderedDict[K, tuple[V, int]] = OrderedDict()
        self._weight = 0
        self._lock = threading.Lock()

    def get(self, key: K) -> V | None:
        """The value of `key`, which counts as a use; None if there is none."""
        with self._lock:
            found = self._entries.get(key)
            if found is None:
                return None
            self._entries.move_to_end(key)
            return found[0]

    def put(self, key: K, value: V, weight: int = 0) -> None:
        """Store `value` under `key`; other entries are removed to make room."""
        with self._lock:
            self._take(key)
            if weight > self.weight:
                return
            self._entries[key] = value, weight
            self._weight += weight
            while len(self._entries) > self.max_entries or self._weight > self.weight:
                self._take(next(iter(self._entries)))

    def _take(self, key: K) -> None:
        _, weight = self._entries.pop(key, (None, 0))
        self._weight -= weight
