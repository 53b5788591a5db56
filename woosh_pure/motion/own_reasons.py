"""`OwnReasons`: whether the robot itself tells why a motion failed.

A robot may also call a motion failed that somebody else has stopped or replaced. Only a code of its own, such
as "no way to the target", tells the two apart.
"""

from __future__ import annotations

import math
import time

from woosh_pure.faults import StatusCode

_BEFORE_SECONDS, _AFTER_SECONDS = 1.0, 0.5
_CODES = {
    *(130101000011, 130101000021, 130101000031, 130101000051),  # no way to the target
    *(130104000042, 130104000092, 130104000102),  # navigation failed
    *(130603000012, 130603000032, 130603000042, 130603000052),  # the same in a narrow passage
    *(130701000012, 130701000032),  # a move by steps failed
}
"""Codes of /status_code by which the robot itself tells why it did not get there."""


class OwnReasons:
    """Takes the codes of /status_code in: pass `note` to the feed `status_code` before the motion begins."""

    def __init__(self) -> None:
        self._at = -math.inf

    def note(self, code: StatusCode) -> None:
        """Take in a code."""
        if code.code in _CODES:
            self._at = time.monotonic()

    def told(self) -> bool:
        """Whether the robot tells just now that it cannot get there; the code comes on another link than the
        end, before or after it.
        """
        end = time.monotonic()
        while self._at < end - _BEFORE_SECONDS and time.monotonic() < end + _AFTER_SECONDS:
            time.sleep(0.01)
        return self._at >= end - _BEFORE_SECONDS
