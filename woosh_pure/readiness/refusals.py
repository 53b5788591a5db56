"""Refused and failed motions, remembered until their cause is shown to be over. Pure.

A cause from before we connected (a pressed emergency stop, a bumper that was hit) may never appear on a
topic. Its only trace is that a motion is refused. So the refusal is remembered, and readiness lists it as a
reason.
"""

from __future__ import annotations

import re
import threading
from dataclasses import dataclass, replace

from woosh_pure.enums import RobotState
from woosh_pure.faults.codes import FaultLevel, StatusCode, decode_status_code
from woosh_pure.reasons import Reason, ReasonKey

__all__ = ["Refusals"]

_CODE = re.compile(r"(?<!\d)\d{12}(?!\d)")
_STOPPED = (RobotState.FAULT, RobotState.MAPPING)
_SAYS_NOTHING = (None, RobotState.UNDEFINED, RobotState.UNINITIALISED)


@dataclass(frozen=True, slots=True)
class _Refusal:
    at: float
    reason: Reason
    sources: frozenset[tuple[int, int, int, int]]


class Refusals:
    """The newest refusal of one chassis. Safe from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._last: _Refusal | None = None

    def note(self, text: str, at: float, state: RobotState | None = None) -> None:
        """Remember that a motion was refused or has failed.

        Args:
            text: Which motion, and the chassis's words for why.
            at: When, by the monotonic clock.
            state: The robot's state reported along with it; None when it was not.
        """
        severe = [code for code in _codes(text) if code.level is FaultLevel.SEVERE]
        blocking = bool(severe) or state in _STOPPED
        doubt = not blocking and state in _SAYS_NOTHING
        reason = Reason(ReasonKey.REFUSED, text, blocking, doubt)
        with self._lock:
            self._last = _Refusal(at, reason, frozenset(code.source for code in severe))

    def end(self) -> None:
        """Forget the refusal: the robot has moved since."""
        with self._lock:
            self._last = None

    def end_before(self, moment: float) -> None:
        """Forget a refusal from before this moment, at which the robot reported that it is over."""
        with self._lock:
            if self._last is not None and self._last.at < moment:
                self._last = None

    def doubt(self) -> None:
        """Its cause may be over: the robot may have been started again."""
        with self._lock:
            if self._last is not None:
                self._last = replace(self._last, reason=self._last.reason.doubted())

    def receive(self, code: StatusCode) -> None:
        """Take in a status code; one that ends a fault also ends the refusal because of it."""
        if not code.known or code.level is not FaultLevel.NORMAL:
            return
        depth = 4 if code.submodule else 3
        with self._lock:
            last = self._last
            if last is not None and any(s[:depth] == code.source[:depth] for s in last.sources):
                self._last = None

    def reasons(self) -> tuple[Reason, ...]:
        """The remembered refusal as reasons, for a `Readiness`."""
        with self._lock:
            return () if self._last is None else (self._last.reason,)


def _codes(text: str) -> list[StatusCode]:
    return [decode_status_code(int(number)) for number in _CODE.findall(text)]
