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
from collections.abc import Callable
from dataclasses import dataclass, field

from rosproto.coercion import as_float
from rosproto.logs import get_logger
from rosproto.sentence import say

__all__ = ["DEFAULT_SECONDS", "MOST_SECONDS", "ChassisLease", "Lease", "LeaseState"]

DEFAULT_SECONDS = 60.0
MOST_SECONDS = 3600.0
MOST_ASKING = 16
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


@dataclass(slots=True)
class Lease:
    """The rules of a lease. Pure: `now` is an argument, in seconds of any one clock.

    Attributes:
        owner: The owner's name; None if the lease is free.
        expires: When it lapses.
        asking: Names of the clients that have requested it, in order.
    """

    owner: str | None = None
    expires: float = -math.inf
    asking: list[str] = field(default_factory=list)

    def lapse(self, now: float) -> bool:
        """Free the lease if its time is up; True if this call has freed it."""
        if self.owner is None or now < self.expires:
            return False
        self.owner, self.expires = None, -math.inf
        return True

    def acquire(self, owner: str, seconds: float, now: float) -> bool:
        """Take the lease if it is free, or extend it; False if another client has it."""
        self.lapse(now)
        if self.owner not in (None, owner):
            return False
        self.owner, self.expires = owner, now + seconds
        self._forget(owner)
        return True

    def renew(self, owner: str, seconds: float, now: float) -> bool:
        """Extend the lease; False if this client does not have it."""
        self.lapse(now)
        if self.owner != owner:
            return False
        self.expires = max(self.expires, now + seconds)
        return True

    def shorten(self, owner: str, seconds: float, now: float) -> bool:
        """Let the lease lapse within `seconds`; False if this client does not have it."""
        self.lapse(now)
        if self.owner != owner:
            return False
        self.expires = min(self.expires, now + seconds)
        return True

    def release(self, owner: str, now: float) -> bool:
        """Give the lease back and withdraw a request; False if this client did not have the lease."""
        self.lapse(now)
        self._forget(owner)
        if self.owner != owner:
            return False
        self.owner, self.expires = None, -math.inf
        return True

    def withdraw(self, owner: str) -> bool:
        """Withdraw a request, but keep the lease; False if this client has not requested it."""
        asks = owner in self.asking
        self._forget(owner)
        return asks

    def request(self, owner: str, now: float) -> bool:
        """Request the lease; False if it is free, if this client has it, or if too many have requested it."""
        self.lapse(now)
        if self.owner is None or self.owner == owner:
            return False
        if owner not in self.asking:
            if len(self.asking) >= MOST_ASKING:
                return False
            self.asking.append(owner)
        return True

    def grant(self, owner: str, to: str, seconds: float, now: float) -> bool:
        """Grant the lease to `to`; False if this client does not have it, or `to` has not requested it."""
        self.lapse(now)
        if self.owner != owner or to not in self.asking:
            return False
        self.owner, self.expires = to, now + seconds
        self._forget(to)
        return True

    def take_over(self, owner: str, holder: str, seconds: float, now: float) -> bool:
        """Take the lease from `holder`; False if another client has it, or `owner` has not requested it."""
        self.lapse(now)
        if self.owner != holder or owner not in self.asking:
            return False
        self.owner, self.expires = owner, now + seconds
        self._forget(owner)
        return True

    def state(self, now: float) -> LeaseState:
        """The state of the lease at `now`."""
        self.lapse(now)
        left = 0.0 if self.owner is None else self.expires - now
        return LeaseState(self.owner, left, tuple(self.asking))

    def _forget(self, owner: str) -> None:
        if owner in self.asking:
            self.asking.remove(owner)


class ChassisLease:
    """The lease of one `Chassis`, as `chassis.lease`. Safe from any thread.

    Owners are names of programs and persons, shown to the others. Nothing is enforced here.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = threading.RLock()
        self._lease = Lease()
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
        with self._lock:
            lapsed = self._lease.lapse(self._clock())
            state = self._lease.state(self._clock())
        if lapsed:
            self._tell(state)
        return state

    def acquire(self, owner: str, seconds: float = DEFAULT_SECONDS) -> bool:
        """Take the lease if it is free, or extend it; False if another client has it: then `request` it.

        Args:
            owner: A name that others see.
            seconds: Until it lapses, at most an hour; `renew` keeps it.

        Raises:
            ValueError: No name, or `seconds` makes no sense.
        """
        owner, seconds = _name(owner), _seconds(seconds)
        return self._change(lambda now: self._lease.acquire(owner, seconds, now))

    def renew(self, owner: str, seconds: float = DEFAULT_SECONDS) -> bool:
        """Extend the lease; False if this client does not have it any more.

        Raises:
            ValueError: No name, or `seconds` makes no sense.
        """
        owner, seconds = _name(owner), _seconds(seconds)
        with self._lock:  # no listener is called: the holder stays the same
            return self._lease.renew(owner, seconds, self._clock())

    def shorten(self, owner: str, seconds: float) -> bool:
        """Let the lease lapse within `seconds`, for a client that has gone; False if it does not have the
        lease.

        Raises:
            ValueError: No name, or `seconds` makes no sense.
        """
        owner, seconds = _name(owner), _seconds(seconds)
        with self._lock:
            return self._lease.shorten(owner, seconds, self._clock())

    def release(self, owner: str) -> bool:
        """Give the lease back, or withdraw a request; False if this client did not have the lease."""
        return self._change(lambda now: self._lease.release(owner, now))

    def withdraw(self, owner: str) -> bool:
        """Withdraw a request, but keep the lease; False if this client has not requested it."""
        return self._change(lambda now: self._lease.withdraw(owner))

    def request(self, owner: str) -> bool:
        """Request the lease; False if it is free (`acquire` it), or too many have requested it.

        Raises:
            ValueError: No name.
        """
        owner = _name(owner)
        return self._change(lambda now: self._lease.request(owner, now))

    def grant(self, owner: str, to: str, seconds: float = DEFAULT_SECONDS) -> bool:
        """Grant the lease to `to`; False if this client does not have it, or `to` has not requested it.

        Raises:
            ValueError: `seconds` makes no sense.
        """
        seconds = _seconds(seconds)
        return self._change(lambda now: self._lease.grant(owner, to, seconds, now))

    def take_over(self, owner: str, holder: str, seconds: float = DEFAULT_SECONDS) -> bool:
        """Take the lease from a program; False if another client has it, or `owner` has not requested it.

        The program's goals go on until they are cancelled or replaced.

        Raises:
            ValueError: No name, or `seconds` makes no sense.
        """
        owner, seconds = _name(owner), _seconds(seconds)
        return self._change(lambda now: self._lease.take_over(owner, holder, seconds, now))

    def on(self, callback: Callable[[LeaseState], object]) -> Callable[[], None]:
        """Call `callback(state)` after each change, in the thread that changed it. Return a function that
        removes the callback.

        A lapse is reported when the state is read next.
        """
        with self._lock:
            self._listeners.append(callback)

        def off() -> None:
            with self._lock:
                if callback in self._listeners:
                    self._listeners.remove(callback)

        return off

    def _change(self, act: Callable[[float], bool]) -> bool:
        with self._lock:
            before = self._seen()
            done = act(self._clock())
            changed, state = self._seen() != before, self._lease.state(self._clock())
        if changed:
            self._tell(state)
        return done

    def _seen(self) -> tuple[object, ...]:
        return (self._lease.owner, *self._lease.asking)

    def _tell(self, state: LeaseState) -> None:
        with self._lock:
            listeners = list(self._listeners)
        for listener in listeners:
            try:
                listener(state)
            except Exception:
                _logger.exception("a listener of the lease failed")


def _name(owner: str) -> str:
    if not (isinstance(owner, str) and owner.strip() and len(owner) <= 200):
        raise ValueError(
            say(
                "owner {owner!r:.80}: expected a name that others can read, of at most 200 letters",
                owner=owner,
            )
        )
    return owner


def _seconds(seconds: float) -> float:
    seconds = as_float(seconds)
    if not (math.isfinite(seconds) and 0.0 < seconds <= MOST_SECONDS):
        raise ValueError(
            say(
                "seconds={seconds}: expected more than 0 and at most {most_seconds:g}",
                seconds=seconds,
                most_seconds=MOST_SECONDS,
            )
        )
    return seconds
