"""Connection slots: each connection takes one before anything is read from it. Pure: times are arguments.

Whoever can reach the server can open connections and send nothing, or half a request. So the number of slots
is limited, and some are reserved for addresses that have presented the token recently. A connection that is
silent for too long loses its slot. When all slots are taken, a new connection replaces one without an
authorized request: from the address that has most of those, the one that has been silent longest. So a stop
gets through, no matter how many connections hang with half a request.
"""

from __future__ import annotations

from collections import Counter, OrderedDict
from collections.abc import Callable
from dataclasses import dataclass

from woosh_pure.web.access import is_loopback

__all__ = ["MOST", "SILENCE", "ConnectionSlots", "Key"]

MOST, RESERVED, EACH = 256, 64, 64
"""All slots; those reserved for known addresses; and how many an unknown address can have."""
SILENCE = 10.0
"""Seconds allowed before the first request, and between requests."""
KNOWN_SECONDS, MOST_KNOWN = 900.0, 256

Key = tuple[str, int]
"""IP address and port of the peer."""


@dataclass(slots=True)
class _Slot:
    since: float
    end: Callable[[], object]
    requests: int = 0
    authorized: int = 0


class ConnectionSlots:
    """Used in the event loop only. The `end` callbacks close a connection and must not wait.

    Args:
        most: The number of slots.
        reserved: How many of these are reserved for known addresses.
        each: How many slots an unknown address can have.
        silence: Seconds without a request after which a slot is lost.
    """

    def __init__(
        self, most: int = MOST, reserved: int = RESERVED, each: int = EACH, silence: float = SILENCE
    ) -> None:
        self._most, self._reserved, self._each, self._silence = most, reserved, each, silence
        self._slots: dict[Key, _Slot] = {}
        self._known: OrderedDict[str, float] = OrderedDict()

    def __len__(self) -> int:
        return len(self._slots)

    def admit(self, key: Key, end: Callable[[], object], now: float) -> bool:
        """A connection was opened. False if there is no slot for it."""
        self.drop_silent(now)
        address, known = key[0], self._is_known(key[0], now)
        own = sum(other[0] == address for other in self._slots)
        if not known and own >= self._each and not self._evict(now, address):
            return False
        most = self._most if known else self._most - self._reserved
        if len(self._slots) >= most and not self._evict(now):
            return False
        self._slots[key] = _Slot(now, end)
        return True

    def closed(self, key: Key, end: Callable[[], object]) -> None:
        """The connection has ended. A newer one from the same address and port keeps its slot."""
        slot = self._slots.get(key)
        if slot is not None and slot.end == end:
            del self._slots[key]

    def request_begins(self, key: Key, now: float, *, authorized: bool) -> None:
        """A request has begun. An `authorized` one is not dropped in favour of a new connection."""
        slot = self._slots.get(key)
        if slot is not None:
            slot.requests += 1
            slot.authorized += authorized

    def remember(self, address: str, now: float) -> None:
        """A client at this address has presented the token."""
        self._known.pop(address, None)
        self._known[address] = now
        while len(self._known) > MOST_KNOWN:
            self._known.popitem(last=False)

    def request_ends(self, key: Key, now: float, *, authorized: bool) -> None:
        """That request is over; the connection may send another."""
        slot = self._slots.get(key)
        if slot is not None:
            slot.requests, slot.authorized, slot.since = slot.requests - 1, slot.authorized - authorized, now

    def drop_silent(self, now: float) -> None:
        """Drop connections that have been silent for too long. To be called every second or so."""
        for key, slot in list(self._slots.items()):
            if not slot.requests and now - slot.since > self._silence:
                self._close(key)

    def drop_all(self) -> None:
        """Drop what is left when the server ends."""
        for key in list(self._slots):
            self._close(key)

    def _is_known(self, address: str, now: float) -> bool:
        return is_loopback(address) or now - self._known.get(address, -KNOWN_SECONDS) < KNOWN_SECONDS

    def _evict(self, now: float, address: str | None = None) -> bool:
        """Drop an idle connection, of that address or of any; False if none is idle."""
        idle = {key: slot for key, slot in self._slots.items() if not slot.authorized}
        if address is not None:
            idle = {key: slot for key, slot in idle.items() if key[0] == address}
        if not idle:
            return False
        crowd = Counter(key[0] for key in idle)
        self._close(min(idle, key=lambda key: (idle[key].requests > 0, -crowd[key[0]], idle[key].since)))
        return True

    def _close(self, key: Key) -> None:
        self._slots.pop(key).end()
