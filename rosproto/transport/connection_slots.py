"""`ConnectionSlots`: bounds the connections of a server. Pure: times are arguments."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

from rosproto.bounded_cache import BoundedCache
from rosproto.transport.uri import is_loopback

KNOWN_SECONDS, MAX_KNOWN = 900.0, 256

Key = tuple[str, int]
"""IP address and port of the peer, or another number of the connection."""


@dataclass(slots=True)
class _Slot:
    since: float
    end: Callable[[], object]
    requests: int = 0
    authorized: int = 0


class ConnectionSlots:
    """Each connection takes a slot before anything is read from it.

    Any peer can open connections and send nothing, or half a request. So the number of slots is limited, and
    some are reserved for addresses that have presented the token recently. A connection that is silent for
    too long loses its slot. When all slots are taken, a new connection replaces a pending one, which has no
    authorized request: the longest silent one of the address with the most of those. So one address locks
    nobody else out, and among many addresses the newest connections stay.

    Used in the event loop only, or with the server's lock held. The `end` callbacks close a connection and
    must not wait.

    Args:
        max_slots: The number of slots.
        reserved: How many of these are reserved for known addresses.
        max_per_address: How many slots an unknown address can have; None for all.
        max_silence: Seconds without a request after which a slot is lost; None for no limit.

    Attributes:
        replaced: Pending connections so far that were replaced by new ones.
    """

    def __init__(
        self,
        max_slots: int,
        *,
        reserved: int = 0,
        max_per_address: int | None = None,
        max_silence: float | None = None,
    ) -> None:
        self._max_slots, self._reserved = max_slots, reserved
        self._max_per_address = max_slots if max_per_address is None else max_per_address
        self._max_silence = max_silence
        self._slots: dict[Key, _Slot] = {}
        self._known: BoundedCache[str, float] = BoundedCache(MAX_KNOWN)
        self.replaced = 0

    def __len__(self) -> int:
        return len(self._slots)

    def admit(self, key: Key, end: Callable[[], object], now: float, max_slots: int = sys.maxsize) -> bool:
        """Give a new connection a slot. False if there is none.

        Args:
            key: The connection.
            end: Closes it.
            now: The time.
            max_slots: How many slots there may be now: fewer than usual when few files are left.
        """
        self.drop_silent(now)
        address, known = key[0], self._is_known(key[0], now)
        own = sum(other[0] == address for other in self._slots)
        if not known and own >= self._max_per_address and not self.drop_one(address):
            return False
        slots = min(max_slots, self._max_slots if known else self._max_slots - self._reserved)
        while len(self._slots) >= slots:
            if not self.drop_one():
                return False
        self._slots[key] = _Slot(now, end)
        return True

    def release(self, key: Key, end: Callable[[], object] | None = None) -> bool:
        """Free the slot of a connection, which was closed or is counted elsewhere from now on.

        Args:
            key: The connection.
            end: As given to `admit`; a newer connection from the same address and port keeps its slot.

        Returns:
            Whether it had a slot, and no request is open.
        """
        slot = self._slots.get(key)
        if slot is None or end not in (None, slot.end):
            return False
        del self._slots[key]
        return not slot.requests

    def request_begins(self, key: Key, now: float, *, authorized: bool) -> None:
        """Note the start of a request. A new connection does not replace one with an `authorized` request."""
        slot = self._slots.get(key)
        if slot is not None:
            slot.requests, slot.authorized, slot.since = slot.requests + 1, slot.authorized + authorized, now

    def remember(self, address: str, now: float) -> None:
        """Note that a client at this address has presented the token."""
        self._known.put(address, now)

    def request_ends(self, key: Key, now: float, *, authorized: bool) -> None:
        """Note the end of a request; the connection may send another."""
        slot = self._slots.get(key)
        if slot is not None:
            slot.requests, slot.authorized, slot.since = slot.requests - 1, slot.authorized - authorized, now

    def drop_silent(self, now: float) -> None:
        """Drop connections that have been silent for too long. To be called every second or so."""
        if self._max_silence is not None:
            for key, slot in list(self._slots.items()):
                if not slot.requests and now - slot.since > self._max_silence:
                    self._close(key)

    def drop_all(self) -> None:
        """Drop all remaining connections."""
        for key in list(self._slots):
            self._close(key)

    def drop_one(self, address: str | None = None) -> bool:
        """Drop a pending connection, of that address or of any, as for a new one; False if there is none."""
        pending = {
            key: slot.since
            for key, slot in self._slots.items()
            if not slot.authorized and address in (None, key[0])
        }
        if not pending:
            return False
        crowd = Counter(key[0] for key in pending)
        self._close(min(pending, key=lambda key: (-crowd[key[0]], pending[key])))
        self.replaced += 1
        return True

    def _is_known(self, address: str, now: float) -> bool:
        then = self._known.get(address)
        return is_loopback(address) or (then is not None and now - then < KNOWN_SECONDS)

    def _close(self, key: Key) -> None:
        self._slots.pop(key).end()
