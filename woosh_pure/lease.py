"""The lease of a chassis: which program or person may command it now.

A client acquires the lease while it is free. While another client holds it, a client requests it, and the
holder grants it. A client that has requested it can take it over from a program, which cannot grant it
(`take_over`); the page and the REST API never take it from a person. A lease that is not renewed lapses. It
is advisory for programs, which can read `chassis.lease.holder`, and binding for the page, the REST API and
the fleet.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from rosproto.coercion import as_float, require_callback
from rosproto.deprecation import former_names
from rosproto.logs import get_logger
from rosproto.sentence import say

__all__ = ["DEFAULT_SECONDS", "MAX_SECONDS", "ChassisLease", "LeaseState"]

DEFAULT_SECONDS = 60.0
MAX_SECONDS = 3600.0
__getattr__ = former_names(__name__, {"MOST_SECONDS": "MAX_SECONDS"})
MAX_ASKING = 16
"""Further requests are refused: clients fill this list, so it is bounded."""
_logger = get_logger("woosh_pure.lease")


@dataclass(frozen=True, slots=True)
class LeaseState:
    """A lease at one moment.

    Attributes:
        holder: The owner's name; None if the lease is free.
        seconds: Time until it lapses; 0 if it is free.
        asking: Names of the clients that have requested it, the first one first.
    """

    holder: str | None = None
    seconds: float = 0.0
    asking: tuple[str, ...] = ()


class ChassisLease:
    """The lease of one `Chassis`, as `chassis.lease`. Safe from any thread.

    Owners are names of programs and persons, shown to the others. Nothing is enforced here.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = threading.RLock()
        self._holder: str | None = None
        self._expires = -math.inf
        self._asking: list[str] = []
        self._listeners: list[Callable[[LeaseState], object]] = []

    def __repr__(self) -> str:
        state = self.state
        return f"<ChassisLease {state.holder or 'free'}, {len(state.asking)} ask for it>"

    @property
    def holder(self) -> str | None:
        """The owner's name; None if the lease is free."""
        return self.state.holder

    @property
    def state(self) -> LeaseState:
        """The state now. Reading it frees a lease whose time is up."""
        with self._changing() as now:
            return self._state(now)

    def acquire(self, owner: str, seconds: float = DEFAULT_SECONDS) -> bool:
        """Take the lease if it is free, or extend it; False if another client has it: then `request` it.

        Args:
            owner: A name that others see.
            seconds: Until it lapses, at most an hour; `renew` keeps it.

        Raises:
            ValueError: No name, or `seconds` makes no sense.
        """
        owner, seconds = _name(owner), _seconds(seconds)
        with self._changing() as now:
            if self._holder not in (None, owner):
                return False
            self._give(owner, now + seconds)
            return True

    def renew(self, owner: str, seconds: float = DEFAULT_SECONDS) -> bool:
        """Extend the lease; False if this client does not have it any more.

        Raises:
            ValueError: No name, or `seconds` makes no sense.
        """
        owner, seconds = _name(owner), _seconds(seconds)
        with self._changing() as now:
            if self._holder != owner:
                return False
            self._expires = max(self._expires, now + seconds)
            return True

    def shorten(self, owner: str, seconds: float) -> bool:
        """Let the lease lapse within `seconds`, for a client that has gone; False if it does not have the
        lease.

        Raises:
            ValueError: No name, or `seconds` makes no sense.
        """
        owner, seconds = _name(owner), _seconds(seconds)
        with self._changing() as now:
            if self._holder != owner:
                return False
            self._expires = min(self._expires, now + seconds)
            return True

    def release(self, owner: str) -> bool:
        """Give the lease back, or withdraw a request; False if this client did not have the lease."""
        with self._changing():
            self._forget(owner)
            had = self._holder == owner
            self._holder = None if had else self._holder
            return had

    def withdraw(self, owner: str) -> bool:
        """Withdraw a request, but keep the lease; False if this client has not requested it."""
        with self._changing():
            return self._forget(owner)

    def request(self, owner: str) -> bool:
        """Request the lease; False if it is free (`acquire` it), or too many have requested it.

        Raises:
            ValueError: No name.
        """
        owner = _name(owner)
        with self._changing():
            if self._holder in (None, owner):
                return False
            if owner not in self._asking:
                if len(self._asking) >= MAX_ASKING:
                    return False
                self._asking.append(owner)
            return True

    def grant(self, owner: str, to: str, seconds: float = DEFAULT_SECONDS) -> bool:
        """Grant the lease to `to`; False if this client does not have it, or `to` has not requested it.

        Raises:
            ValueError: `seconds` makes no sense.
        """
        return self._hand_over(owner, to, _seconds(seconds))

    def take_over(self, owner: str, holder: str, seconds: float = DEFAULT_SECONDS) -> bool:
        """Take the lease from a program; False if another client has it, or `owner` has not requested it.

        The program's goals go on until they are cancelled or replaced.

        Raises:
            ValueError: No name, or `seconds` makes no sense.
        """
        return self._hand_over(holder, _name(owner), _seconds(seconds))

    def on(self, callback: Callable[[LeaseState], object]) -> Callable[[], None]:
        """Call `callback(state)` after each change, in the thread that changed it. Return a function that
        removes the callback.

        A lapse is reported when the lease is used next.
        """
        with self._lock:
            self._listeners.append(require_callback(callback))

        def off() -> None:
            with self._lock:
                if callback in self._listeners:
                    self._listeners.remove(callback)

        return off

    def _hand_over(self, owner: str, to: str, seconds: float) -> bool:
        with self._changing() as now:
            if self._holder != owner or to not in self._asking:
                return False
            self._give(to, now + seconds)
            return True

    def _give(self, owner: str, expires: float) -> None:
        self._holder, self._expires = owner, expires
        self._forget(owner)

    def _forget(self, owner: str) -> bool:
        """Remove a request; False if there is none."""
        if owner not in self._asking:
            return False
        self._asking.remove(owner)
        return True

    def _state(self, now: float) -> LeaseState:
        left = 0.0 if self._holder is None else self._expires - now
        return LeaseState(self._holder, left, tuple(self._asking))

    @contextmanager
    def _changing(self) -> Iterator[float]:
        """Hold the lock over a change, free a lease whose time is up, and tell the listeners afterwards.

        The value is the time.
        """
        with self._lock:
            before, now = (self._holder, *self._asking), self._clock()
            if now >= self._expires:
                self._holder = None
            yield now
            changed, state = (self._holder, *self._asking) != before, self._state(now)
            listeners = list(self._listeners)
        for listener in listeners if changed else ():
            try:
                listener(state)
            except Exception:
                _logger.exception("a listener of the lease failed")


def _name(owner: str) -> str:
    if not (isinstance(owner, str) and owner.strip() and len(owner) <= 200):
        wrong = "owner {owner!r:.80}: expected a printable name of at most 200 characters"
        raise ValueError(say(wrong, owner=owner))
    return str(owner)  # a sentence stays one


def _seconds(seconds: float) -> float:
    seconds = as_float(seconds)
    if not (math.isfinite(seconds) and 0.0 < seconds <= MAX_SECONDS):
        wrong = "seconds={seconds}: expected more than 0 and at most {max_seconds:g}"
        raise ValueError(say(wrong, seconds=seconds, max_seconds=MAX_SECONDS))
    return seconds
