"""What is remembered because a peer sent it: only so much, and what was used longest ago goes first.

Whoever keeps something under a key that comes from the network (a definition, an md5sum, a node's name) keeps
it in here: a plain dict grows for as long as somebody thinks of new keys.
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
    """A bounded memory; safe from any thread.

    Args:
        most: Entries.
        weight: The weights of all entries together; one that is heavier alone is not kept.
    """

    def __init__(self, most: int, weight: int = 1 << 62) -> None:
        self.most = most
        self.weight = weight
        self._entries: OrderedDict[K, tuple[V, int]] = OrderedDict()
        self._weight = 0
        self._lock = threading.Lock()

    def get(self, key: K) -> V | None:
        """What is kept under `key`, which counts as a use; None when there is nothing (any more)."""
        with self._lock:
            found = self._entries.get(key)
            if found is None:
                return None
            self._entries.move_to_end(key)
            return found[0]

    def put(self, key: K, value: V, weight: int = 0) -> None:
        """Keep `value`, in place of what was there; others go to make room."""
        with self._lock:
            self._take(key)
            if weight > self.weight:
                return
            self._entries[key] = value, weight
            self._weight += weight
            while len(self._entries) > self.most or self._weight > self.weight:
                self._take(next(iter(self._entries)))

    def pop(self, key: K) -> V | None:
        """Forget one; what it was, None when there is nothing."""
        with self._lock:
            return self._take(key)

    def clear(self) -> None:
        """Forget everything."""
        with self._lock:
            self._entries.clear()
            self._weight = 0

    def keys(self) -> list[K]:
        """What is kept now, used longest ago first."""
        with self._lock:
            return list(self._entries)

    def _take(self, key: K) -> V | None:
        found = self._entries.pop(key, None)
        if found is None:
            return None
        self._weight -= found[1]
        return found[0]

    def __contains__(self, key: K) -> bool:
        return key in self._entries

    def __len__(self) -> int:
        return len(self._entries)
