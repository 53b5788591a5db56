"""`Background`: an answer of the robot, asked for in a thread of its own, so that nobody waits for it."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from typing import Generic, TypeVar

from rosproto.errors import RosError
from rosproto.logs import get_logger

T = TypeVar("T")
_PAUSE = 5.0
_log = get_logger("woosh_pure.robot_api")


class Background(Generic[T]):
    """Asks one question at a time, and only while somebody wants to know. From any thread.

    Args:
        ask: Asks the robot; raises a `RosError` if there is no answer.
        fresh: Seconds after which it is asked again; at least five if there was no answer.

    Attributes:
        answer: The newest answer; None before the first one.
    """

    def __init__(self, ask: Callable[[], T], fresh: float) -> None:
        self._ask, self._fresh = ask, fresh
        self._lock = threading.Lock()
        self._due = 0.0
        self._tried = threading.Event()
        self._answered = -math.inf
        self.answer: T | None = None

    @property
    def age(self) -> float:
        """Seconds since the newest answer came; infinity before the first one."""
        return time.monotonic() - self._answered

    def want(self, wait: float = 0.0) -> T | None:
        """Return the newest answer; begin to ask if it is not fresh. The end of the first attempt is waited
        for `wait` seconds, that of a later one is not."""
        with self._lock:
            if time.monotonic() >= self._due:
                threading.Thread(target=self._run, name="woosh:robot api", daemon=True).start()
                self._due = math.inf
        self._tried.wait(wait)
        return self.answer

    def ask_again(self, seconds: float = 0.0) -> None:
        """Ask after so many seconds, if somebody wants to know then."""
        with self._lock:
            self._due = time.monotonic() + seconds

    def _run(self) -> None:
        pause = max(self._fresh, _PAUSE)
        try:
            answer = self._ask()
            self.answer, self._answered, pause = answer, time.monotonic(), self._fresh
        except RosError as error:
            _log.debug("= nothing by the Robot API: %s", error)
        finally:
            self.ask_again(pause)
            self._tried.set()
