"""`CallScope`: the motions that one call of a verb has begun, so that a cancelled asyncio task can end them.

`woosh_pure.aio` calls the verbs in threads. A cancelled task cannot interrupt such a thread, but it can mark
the call as unwanted here. Then a motion that the call is preparing does not begin, and one that it has begun
is ended.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rosproto.logs import get_logger
from rosproto.node import Cancellation
from rosproto.sentence import say
from woosh_pure.errors import MotionRefused

logger = get_logger("woosh_pure.aio")
_here = threading.local()


class CallScope:
    """Goals and velocity blocks that one call has begun. Safe from any thread.

    Attributes:
        things: The goals and velocity blocks.
        calling: Ends the service call that is waiting for its reply.
    """

    def __init__(self) -> None:
        self.things: list[object] = []
        self.calling = Cancellation()
        self._lock = threading.Lock()
        self._ends: list[tuple[str, Callable[[], object]]] = []
        self._unwanted = False

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


@contextmanager
def call_scope(scope: CallScope) -> Iterator[None]:
    """Add motions that this thread begins within the block to `scope`."""
    before, _here.scope = current(), scope
    try:
        yield
    finally:
        _here.scope = before


def current() -> CallScope | None:
    """The scope of this thread; None outside `call_scope`."""
    return getattr(_here, "scope", None)
