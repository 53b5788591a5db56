"""`Outbox`: the bounded queue of payloads that wait to be sent to one client.

Any thread fills it; the thread that writes to the client empties it. Messages of topics have a key and may be
dropped: first the oldest with the same key, if more than `keep` or too many bytes with that key wait; then,
if all together take too many bytes, the oldest with the key that takes most. Answers have no key and are
never dropped; when too many wait, `overflow` is set.
"""

from __future__ import annotations

import itertools
import threading
from collections import Counter, OrderedDict, deque
from collections.abc import Callable
from typing import Generic, TypeVar

from rosproto.deprecation import former_parameters
from rosproto.gateway.client_limits import GatewayLimits

T = TypeVar("T")
Key = object


class Outbox(Generic[T]):
    """A queue to one client.

    Attributes:
        bytes: Bytes that wait.
        answer_bytes: Bytes of answers among them.
        dropped: Messages dropped so far, by key.
        overflow: Too many bytes of answers wait; the connection must be closed.
        closed: `put` does nothing any more.
    """

    def __init__(self, limits: GatewayLimits, wake: Callable[[], object] | None = None) -> None:
        """
        Args:
            limits: Bounds.
            wake: Called by `put` when the outbox was empty, in the same thread.
        """
        self._limits = limits
        self._wake = wake
        self._lock = threading.Lock()
        self._numbers = itertools.count()
        self._queue: OrderedDict[int, tuple[Key | None, int, T]] = OrderedDict()  # key, size, payload
        self._waiting: dict[Key, deque[int]] = {}  # numbers in the queue
        self._key_bytes: Counter[Key] = Counter()
        self.bytes = 0
        self.answer_bytes = 0
        self.dropped: Counter[Key] = Counter()
        self.overflow = False
        self.closed = False

    def __len__(self) -> int:
        return len(self._queue)

    def put(self, key: Key | None, size: int, payload: T, keep: int | None = None) -> None:
        """Add a payload; never waits.

        Args:
            key: The topic; None for an answer.
            size: Bytes of the payload.
            payload: Returned by `take`.
            keep: The most payloads with this key; None for `GatewayLimits.outbox_messages`.
        """
        with self._lock:
            if self.closed:
                return
            was_empty = not self._queue
            number = next(self._numbers)
            if key is None:
                self.answer_bytes += size
                self.overflow |= self.answer_bytes > self._limits.answer_bytes
            else:
                self._make_room(key, size, self._limits.outbox_messages if keep is None else keep)
                self._waiting.setdefault(key, deque()).append(number)
                self._key_bytes[key] += size
            self._queue[number] = key, size, payload
            self.bytes += size
        if was_empty and self._wake is not None:
            self._wake()

    @former_parameters(most="max_bytes")
    def take(self, max_bytes: int | None = None) -> T | None:
        """The oldest payload; None when there is none, or when it has more than `max_bytes` bytes."""
        with self._lock:
            if not self._queue:
                return None
            number, (_, size, payload) = next(iter(self._queue.items()))
            if max_bytes is not None and size > max_bytes:
                return None
            self._remove(number)
            return payload

    def waits(self, key: Key) -> int:
        """Number of payloads with this key."""
        with self._lock:
            return len(self._waiting.get(key, ()))

    def forget(self, key: Key) -> None:
        """Remove the payloads with this key without counting them as dropped."""
        with self._lock:
            while key in self._waiting:
                self._remove(self._waiting[key][0])
            self.dropped.pop(key, None)

    def close(self) -> None:
        """Drop everything; later `put`s do nothing."""
        with self._lock:
            self.closed = True
            self._queue.clear()
            self._waiting.clear()
            self._key_bytes.clear()
            self.bytes = self.answer_bytes = 0

    # -- with the lock held ---------------------------------------------------------------------------------

    def _make_room(self, key: Key, size: int, keep: int) -> None:
        limits = self._limits
        while key in self._waiting and (
            len(self._waiting[key]) >= max(1, keep) or self._key_bytes[key] + size > limits.topic_bytes
        ):
            self._drop(key)
        while self._key_bytes and self.bytes - self.answer_bytes + size > limits.outbox_bytes:
            self._drop(max(self._key_bytes, key=self._key_bytes.__getitem__))

    def _drop(self, key: Key) -> None:
        self._remove(self._waiting[key][0])
        self.dropped[key] += 1

    def _remove(self, number: int) -> None:
        """Remove a payload, the oldest one with its key."""
        key, size, _ = self._queue.pop(number)
        self.bytes -= size
        if key is None:
            self.answer_bytes -= size
            return
        self._key_bytes[key] -= size
        self._waiting[key].popleft()
        if not self._waiting[key]:
            del self._waiting[key], self._key_bytes[key]
