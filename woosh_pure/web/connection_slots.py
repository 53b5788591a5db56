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

__all__ = ["MOST", "SILENCE", "Key", "Places"]

MOST, RESERVED, EACH = 256, 64, 64
"""All places, those for known addresses only, and what one address can have that is not known."""
SILENCE = 10.0
"""Seconds until the first request has come, and from one to the next."""
KNOWN_SECONDS, MOST_KNOWN = 900.0, 256

Key = tuple[str, int]
"""Address and port of the other end."""


@dataclass(slots=True)
class _Place:
    since: float
    end: Callable[[], object]
    asks: int = 0
    let_in: int = 0


class Places:
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
        self._places: dict[Key, _Place] = {}
        self._known: OrderedDict[str, float] = OrderedDict()

    def __len__(self) -> int:
        return len(self._places)

    def come(self, key: Key, end: Callable[[], object], now: float) -> bool:
        """A connection was opened; False when there is no place for it."""
        self.tidy(now)
        address, known = key[0], self._is_known(key[0], now)
        own = sum(other[0] == address for other in self._places)
        if not known and own >= self._each and not self._make_room(now, address):
            return False
        most = self._most if known else self._most - self._reserved
        if len(self._places) >= most and not self._make_room(now):
            return False
        self._places[key] = _Place(now, end)
        return True

    def gone(self, key: Key, end: Callable[[], object]) -> None:
        """It has ended; who came after it, from the same port, has not."""
        place = self._places.get(key)
        if place is not None and place.end == end:
            del self._places[key]

    def begin(self, key: Key, now: float, *, let_in: bool) -> None:
        """A request has begun; `let_in`: of somebody who may ask, so it is not ended for a newcomer."""
        place = self._places.get(key)
        if place is not None:
            place.asks += 1
            place.let_in += let_in

    def know(self, address: str, now: float) -> None:
        """Somebody there has shown the token."""
        self._known.pop(address, None)
        self._known[address] = now
        while len(self._known) > MOST_KNOWN:
            self._known.popitem(last=False)

    def end(self, key: Key, now: float, *, let_in: bool) -> None:
        """That request is over; the next may come."""
        place = self._places.get(key)
        if place is not None:
            place.asks, place.let_in, place.since = place.asks - 1, place.let_in - let_in, now

    def tidy(self, now: float) -> None:
        """End those that have been silent for too long; to be called every second or so."""
        for key, place in list(self._places.items()):
            if not place.asks and now - place.since > self._silence:
                self._drop(key)

    def end_all(self) -> None:
        """The server ends: so do those that have not heard of it."""
        for key in list(self._places):
            self._drop(key)

    def _is_known(self, address: str, now: float) -> bool:
        return is_loopback(address) or now - self._known.get(address, -KNOWN_SECONDS) < KNOWN_SECONDS

    def _make_room(self, now: float, address: str | None = None) -> bool:
        """Take somebody's place, of one address or of any; False where everybody asks."""
        idle = {key: place for key, place in self._places.items() if not place.let_in}
        if address is not None:
            idle = {key: place for key, place in idle.items() if key[0] == address}
        if not idle:
            return False
        crowd = Counter(key[0] for key in idle)
        self._drop(min(idle, key=lambda key: (idle[key].asks > 0, -crowd[key[0]], idle[key].since)))
        return True

    def _drop(self, key: Key) -> None:
        self._places.pop(key).end()
