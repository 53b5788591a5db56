"""`CallScope`: one call of a verb that was asked for in one place, and is carried out in a thread later.

`woosh_pure.aio`, the web server and the fleet vehicle call the verbs in threads. A `stop` that comes before
such a thread begins must prevent the motion as well, so the scope has the number of stops at the time when
the call was asked for. A cancelled asyncio task cannot interrupt the thread, but it can mark the call as
unwanted here. Then a motion that the call is preparing does not begin, and one that it has begun is ended.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextvars import ContextVar, Token
from types import TracebackType
from typing import TYPE_CHECKING

from rosproto.logs import get_logger
from rosproto.node import Cancellation
from rosproto.sentence import say
from woosh_pure.errors import MotionRefused

if TYPE_CHECKING:
    from woosh_pure.stopping.active_motions import ActiveMotions

logger = get_logger("woosh_pure.aio")
_here: ContextVar[CallScope | None] = ContextVar("call_scope", default=None)


class CallScope:
    """One call, and the goals and velocity blocks that it has begun: `with scope:` carries it out. Safe from
    any thread.

    Args:
        motions: The `ActiveMotions` of the Chassis that is called, which makes the scope in `request`.
        stops: Number of its stops now, when the call is asked for.
        own_stops: The numbers of those that were made within it, which do not overtake it.

    Attributes:
        motions, stops, own_stops: As given.
        things: The goals and velocity blocks.
        calling: Ends the service call that is waiting for its reply.
    """

    def __init__(
        self, motions: ActiveMotions | None = None, stops: int = 0, own_stops: set[int] | None = None
    ) -> None:
        self.motions, self.stops = motions, stops
        self.own_stops: set[int] = set() if own_stops is None else own_stops
        self.things: list[object] = []
        self.calling = Cancellation()
        self._lock = threading.Lock()
        self._ends: list[tuple[str, Callable[[], object]]] = []
        self._unwanted = False
        self._before: list[Token[CallScope | None]] = []

    def __enter__(self) -> CallScope:
        self._before.append(_here.set(self))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        _here.reset(self._before.pop())

    def renewed(self) -> CallScope:
        """Return the scope of another call of the same caller, asked for now. Stops within the one do not
        overtake the other."""
        return CallScope(self.motions, 0 if self.motions is None else self.motions.stops, self.own_stops)

    @property
    def overtaken(self) -> bool:
        """Whether somebody else has stopped the Chassis since the call was asked for. Does not wait."""
        return self.motions is not None and self.overtaken_at(self.motions.stops)

    def overtaken_at(self, stops: int) -> bool:
        """Whether somebody else had stopped it when the number of stops was `stops`."""
        return any(number not in self.own_stops for number in range(self.stops + 1, stops + 1))

    def __bool__(self) -> bool:
        """True when something was begun."""
        return bool(self._ends)

    def add(self, thing: object, what: str, end: Callable[[], object]) -> None:
        """Add a motion that is about to begin.

        Args:
            thing: The goal or the velocity block.
            what: Its description.
            end: Ends it, in bounded time.

        Raises:
            MotionRefused: The call was cancelled.
        """
        with self._lock:
            self.require_wanted(what)
            self.things.append(thing)
            self._ends.append((what, end))

    def require_wanted(self, what: str) -> None:
        """Check that the call is still wanted.

        Raises:
            MotionRefused: The call was cancelled.
        """
        if self._unwanted:
            raise MotionRefused(
                say("{what}: the task that asked for it was cancelled; nothing was sent", what=what)
            )

    def refuse(self) -> None:
        """Prevent further motions from beginning. Does not wait."""
        with self._lock:
            self._unwanted = True
        self.calling.cancel()

    def end(self) -> None:
        """Prevent further motions, and end those under way. Failures are logged; `close` tries again."""
        self.refuse()
        for what, end in self._ends:
            try:
                end()
            except Exception as error:  # no caller receives it, and the others must end, too
                logger.warning("! %s: its task was cancelled, and it may go on: %s", what, error)


def current() -> CallScope | None:
    """The scope of what this thread, or this asyncio task, carries out; None outside of any."""
    return _here.get()
