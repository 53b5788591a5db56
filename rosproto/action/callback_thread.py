"""The thread that runs the callbacks of an action client in order."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from rosproto.logs import get_logger

_log = get_logger("rosproto.action")

MOST_WAITING = 100


class CallbackThread:
    """Calls functions in order, in a separate thread that starts with the first call.

    Status, result and feedback arrive in three threads. Callbacks run in this one, in the order of the goal's
    states, one at a time, and without a lock held, so they may call anything.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._ready = threading.Condition()
        self._queue: deque[Callable[[], object]] = deque()
        self._thread: threading.Thread | None = None
        self._closed = False

    @property
    def is_current(self) -> bool:
        """True when called from a callback."""
        return threading.current_thread() is self._thread

    def call(self, function: Callable[[], object], *, droppable: bool = False) -> bool:
        """Queue a call of `function`.

        Args:
            function: Called without arguments.
            droppable: Drop the call when `MOST_WAITING` are queued.

        Returns:
            False if it will not be called: dropped, or after `close`.
        """
        with self._ready:
            if self._closed or (droppable and len(self._queue) >= MOST_WAITING):
                return False
            self._queue.append(function)
            if self._thread is None:
                self._thread = threading.Thread(
                    target=self._run, name=f"rosproto:action callbacks {self._name}", daemon=True
                )
                self._thread.start()
            self._ready.notify()
        return True

    def close(self, timeout: float = 1.0) -> None:
        """Stop after the current call; wait for that call unless called from it."""
        with self._ready:
            self._closed = True
            self._queue.clear()
            self._ready.notify()
        if self._thread is not None and not self.is_current:
            self._thread.join(timeout)

    def _run(self) -> None:
        while True:
            with self._ready:
                while not self._queue and not self._closed:
                    self._ready.wait()
                if self._closed:
                    return
                function = self._queue.popleft()
            try:
                function()
            except BaseException:  # sys.exit() would end this thread and prevent later callbacks
                _log.exception("! %s: a callback raised", self._name)
