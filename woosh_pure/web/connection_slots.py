"""Places at the server: each connection has one, from before anything of it is read. Pure: times are given.

Whoever reaches the server can open connections and say nothing, or half of something. So there are only so
many places, some of them for addresses that have shown the token not long ago. Who is silent for too long
loses the place; and when all are taken, a newcomer gets that of somebody who does not ask anything: of the
address that has most of these, the one that has been silent longest. So a stop gets in, however many wait
outside with half a request.
"""

from __future__ import annotations

from collections import Counter, OrderedDict
from collections.abc import Callable
from dataclasses import dataclass

from woosh_pure.web.access import is_loopback

__all__ = ["MOST", "SILENCE", "ConnectionSlots", "Key"]

MOST, RESERVED, EACH = 256, 64, 64
"""All places, those for known addresses only, and what one address can have that is not known."""
SILENCE = 10.0
"""Seconds until the first request has come, and from one to the next."""
KNOWN_SECONDS, MOST_KNOWN = 900.0, 256

Key = tuple[str, int]
"""Address and port of the other end."""


@dataclass(slots=True)
class _Slot:
    since: float
    end: Callable[[], object]
    requests: int = 0
    authorized: int = 0


class ConnectionSlots:
    """Belongs to the event loop. `end`s are called here: they end a connection, and do not wait.

    Args:
        most: How many there are.
        reserved: How many of these are for known addresses.
        each: How many an address can have that is not known.
        silence: Seconds without a request after which a place is lost.
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
        """A connection was opened; False when there is no place for it."""
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
        """It has ended; who came after it, from the same port, has not."""
        slot = self._slots.get(key)
        if slot is not None and slot.end == end:
            del self._slots[key]

    def request_begins(self, key: Key, now: float, *, authorized: bool) -> None:
        """A request has begun; `authorized`: of somebody who may ask, so it is not ended for a newcomer."""
        slot = self._slots.get(key)
        if slot is not None:
            slot.requests += 1
            slot.authorized += authorized

    def remember(self, address: str, now: float) -> None:
        """Somebody there has shown the token."""
        self._known.pop(address, None)
        self._known[address] = now
        while len(self._known) > MOST_KNOWN:
            self._known.popitem(last=False)

    def request_ends(self, key: Key, now: float, *, authorized: bool) -> None:
        """That request is over; the next may come."""
        slot = self._slots.get(key)
        if slot is not None:
            slot.requests, slot.authorized, slot.since = slot.requests - 1, slot.authorized - authorized, now

    def drop_silent(self, now: float) -> None:
        """End those that have been silent for too long; to be called every second or so."""
        for key, slot in list(self._slots.items()):
            if not slot.requests and now - slot.since > self._silence:
                self._close(key)

    def drop_all(self) -> None:
        """The server ends: so do those that have not heard of it."""
        for key in list(self._slots):
            self._close(key)

    def _is_known(self, address: str, now: float) -> bool:
        return is_loopback(address) or now - self._known.get(address, -KNOWN_SECONDS) < KNOWN_SECONDS

    def _evict(self, now: float, address: str | None = None) -> bool:
        """Take somebody's place, of one address or of any; False where everybody asks."""
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
