"""Who commands a robot now: one at a time, asked for, shown to all, given back, lapsing by itself.

A lease is taken when it is free. Who wants it while another holds it asks, and the holder grants it. Who has
asked can take it over from a holder that cannot be asked, a program: `take_over`; the page and the REST API
never take it from a person. It lapses when its holder does not renew it. It is advisory for programs
(`chassis.lease.holder` tells them), and binding for the page, the REST API and the fleet.
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
"""Who asks beyond these is not noted: a list that others fill has a bound."""
_logger = get_logger("woosh_pure.lease")


@dataclass(frozen=True, slots=True)
class LeaseState:
    """A lease at one moment.

    Attributes:
        holder: Who has it, None when it is free.
        seconds: Until it lapses; 0 when it is free.
        asking: Who asks for it, the first one first.
    """

    holder: str | None = None
    seconds: float = 0.0
    asking: tuple[str, ...] = ()


@dataclass(slots=True)
class Lease:
    """The machine. Pure: `now` is given, in seconds of any one clock.

    Attributes:
        owner: Who has it, None when it is free.
        expires: When it lapses.
        asking: Who asks for it, in the order of asking.
    """

    owner: str | None = None
    expires: float = -math.inf
    asking: list[str] = field(default_factory=list)

    def lapse(self, now: float) -> bool:
        """Take note of the time; True when the lease has lapsed just now."""
        if self.owner is None or now < self.expires:
            return False
        self.owner, self.expires = None, -math.inf
        return True

    def acquire(self, owner: str, seconds: float, now: float) -> bool:
        """Take it when it is free, or keep it; False when another has it."""
        self.lapse(now)
        if self.owner not in (None, owner):
            return False
        self.owner, self.expires = owner, now + seconds
        self._forget(owner)
        return True

    def renew(self, owner: str, seconds: float, now: float) -> bool:
        """Keep it for another while; False when it is not this owner's (any more)."""
        self.lapse(now)
        if self.owner != owner:
            return False
        self.expires = max(self.expires, now + seconds)
        return True

    def shorten(self, owner: str, seconds: float, now: float) -> bool:
        """Let it lapse after so many seconds at most; False when it is not this owner's (any more)."""
        self.lapse(now)
        if self.owner != owner:
            return False
        self.expires = min(self.expires, now + seconds)
        return True

    def release(self, owner: str, now: float) -> bool:
        """Give it back, and take back a question; False when it was not this owner's."""
        self.lapse(now)
        self._forget(owner)
        if self.owner != owner:
            return False
        self.owner, self.expires = None, -math.inf
        return True

    def withdraw(self, owner: str) -> bool:
        """Take back a question, and keep the lease; False when nobody of that name asks."""
        asks = owner in self.asking
        self._forget(owner)
        return asks

    def request(self, owner: str, now: float) -> bool:
        """Ask the holder for it; True when the question stands, False when there is nobody to ask, or too
        many ask already.
        """
        self.lapse(now)
        if self.owner is None or self.owner == owner:
            return False
        if owner not in self.asking:
            if len(self.asking) >= MOST_ASKING:
                return False
            self.asking.append(owner)
        return True

    def grant(self, owner: str, to: str, seconds: float, now: float) -> bool:
        """Hand it over to somebody who asks; False when it is not this owner's, or `to` does not ask."""
        self.lapse(now)
        if self.owner != owner or to not in self.asking:
            return False
        self.owner, self.expires = to, now + seconds
        self._forget(to)
        return True

    def take_over(self, owner: str, holder: str, seconds: float, now: float) -> bool:
        """Take it from this holder; False when another has it, or `owner` has not asked for it before."""
        self.lapse(now)
        if self.owner != holder or owner not in self.asking:
            return False
        self.owner, self.expires = owner, now + seconds
        self._forget(owner)
        return True

    def state(self, now: float) -> LeaseState:
        """How it stands."""
        self.lapse(now)
        left = 0.0 if self.owner is None else self.expires - now
        return LeaseState(self.owner, left, tuple(self.asking))

    def _forget(self, owner: str) -> None:
        if owner in self.asking:
            self.asking.remove(owner)


class ChassisLease:
    """The lease of one `Chassis`, as `chassis.lease`: the machine with a lock and a clock. Safe from any
    thread.

    Owners are names that others see: a program's, a person's. Nothing is enforced here.
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
        """Who has it now, None when it is free."""
        return self.state.holder

    @property
    def state(self) -> LeaseState:
        """Holder, seconds that are left, and who asks; also notices that it has lapsed."""
        with self._lock:
            lapsed = self._lease.lapse(self._clock())
            state = self._lease.state(self._clock())
        if lapsed:
            self._tell(state)
        return state

    def acquire(self, owner: str, seconds: float = DEFAULT_SECONDS) -> bool:
        """Take it when it is free, or keep it; False when another has it: `request` it then.

        Args:
            owner: A name that others see.
            seconds: Until it lapses, at most an hour; `renew` keeps it.

        Raises:
            ValueError: No name, or `seconds` makes no sense.
        """
        owner, seconds = _name(owner), _seconds(seconds)
        return self._change(lambda now: self._lease.acquire(owner, seconds, now))

    def renew(self, owner: str, seconds: float = DEFAULT_SECONDS) -> bool:
        """Keep it for another while; False when it is not this owner's any more.

        Raises:
            ValueError: No name, or `seconds` makes no sense.
        """
        owner, seconds = _name(owner), _seconds(seconds)
        with self._lock:  # nobody is told: what others see does not change
            return self._lease.renew(owner, seconds, self._clock())

    def shorten(self, owner: str, seconds: float) -> bool:
        """Let it lapse after so many seconds at most: its holder has gone; False when it is not this owner's.

        Raises:
            ValueError: No name, or `seconds` makes no sense.
        """
        owner, seconds = _name(owner), _seconds(seconds)
        with self._lock:
            return self._lease.shorten(owner, seconds, self._clock())

    def release(self, owner: str) -> bool:
        """Give it back, or take a question back; False when it was not this owner's."""
        return self._change(lambda now: self._lease.release(owner, now))

    def withdraw(self, owner: str) -> bool:
        """Take a question back, but keep the lease; False when nobody of that name asks."""
        return self._change(lambda now: self._lease.withdraw(owner))

    def request(self, owner: str) -> bool:
        """Ask the holder for it; False when it is free (`acquire` it), or too many ask already.

        Raises:
            ValueError: No name.
        """
        owner = _name(owner)
        return self._change(lambda now: self._lease.request(owner, now))

    def grant(self, owner: str, to: str, seconds: float = DEFAULT_SECONDS) -> bool:
        """Hand it over to somebody who asks; False when it is not this owner's, or `to` does not ask.

        Raises:
            ValueError: `seconds` makes no sense.
        """
        seconds = _seconds(seconds)
        return self._change(lambda now: self._lease.grant(owner, to, seconds, now))

    def take_over(self, owner: str, holder: str, seconds: float = DEFAULT_SECONDS) -> bool:
        """Take it from a holder that cannot be asked; False when another has it, or `owner` did not ask.

        What the holder has begun goes on until it is cancelled or replaced.

        Raises:
            ValueError: No name, or `seconds` makes no sense.
        """
        owner, seconds = _name(owner), _seconds(seconds)
        return self._change(lambda now: self._lease.take_over(owner, holder, seconds, now))

    def on(self, callback: Callable[[LeaseState], object]) -> Callable[[], None]:
        """Call `callback(state)` after each change, in the thread that changed it; returns what ends that.

        That it has lapsed is told when somebody looks next.
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
