"""Manual driving of one robot, one velocity block at a time. Any thread can end a drive, and it always ends
with zero velocity.
"""

from __future__ import annotations

import math
import threading
import time

from rosproto.errors import RosError
from rosproto.sentence import say
from woosh_pure.chassis import Chassis
from woosh_pure.velocity.drive import Drive
from woosh_pure.web.http_errors import Problem

MAX_LINEAR, MAX_ANGULAR = 0.3, 0.5
"""Highest velocities of a page, m/s and rad/s. Lower limits of the chassis apply, too."""
ZEROS_SECONDS = 2.5
"""Seconds for which a new press waits for the zeros of the last drive; `finish` takes two."""


class ManualDrive:
    """Safe from any thread. `open` and `finish` block for a while; `steer` and `halt` do not.

    Attributes:
        driver: The name of the client that drives or is about to; None if there is none.
        ended: When the last drive ended, by `time.monotonic()`.
    """

    def __init__(self, chassis: Chassis) -> None:
        self._chassis = chassis
        self._lock = threading.Condition()
        self.driver: str | None = None
        self.ended = -math.inf
        self._drive: Drive | None = None
        self._closed = ""

    @property
    def limits(self) -> dict[str, float]:
        """The limits of the open drive, or else the most that a page may drive."""
        drive = self._drive
        linear, angular = (MAX_LINEAR, MAX_ANGULAR)
        if drive is not None:
            linear, angular = drive.limits.linear, drive.limits.angular
        return {"vx": linear, "wz": angular}

    def open(self, driver: str) -> None:
        """Open a velocity block for a driver.

        Raises:
            Problem: Another client drives, or the server is ending.
            RosError, ValueError: `Chassis.velocity` has refused.
        """
        with self._lock:  # a new press waits for the zeros of the last drive
            self._lock.wait_for(lambda: self._closed or self.driver != driver, ZEROS_SECONDS)
            if self._closed or self.driver is not None:
                raise Problem(409, self._closed or say("{driver} drives now", driver=self.driver), "busy")
            self.driver = driver
        try:
            drive = self._begin()
        except BaseException:
            self._release(None)
            raise
        with self._lock:
            self._drive, closed = drive, self._closed
        if closed:
            self.finish(closed)
            raise Problem(409, closed, "busy")

    def _begin(self) -> Drive:
        velocity = self._chassis.velocity
        try:
            drive = velocity(bypasses_protection=True, max_linear=MAX_LINEAR, max_angular=MAX_ANGULAR)
        except ValueError:  # the chassis's own limits are lower
            known = velocity(bypasses_protection=True).limits  # of a block that is never entered
            drive = velocity(
                bypasses_protection=True,
                max_linear=min(MAX_LINEAR, known.linear),
                max_angular=min(MAX_ANGULAR, known.angular),
            )
        return drive.__enter__()

    def _release(self, drive: Drive | None) -> None:
        with self._lock:
            if self._drive is drive:
                self._drive, self.driver, self.ended = None, None, time.monotonic()
                self._lock.notify_all()

    def steer(self, vx: float, wz: float, valid_for: float, since: float | None = None) -> None:
        """Drive for another `valid_for` seconds, counted from `since` by `time.monotonic()`. Velocities are
        reduced to the limits.

        Raises:
            RosError: The drive is over; the message says why.
        """
        drive = self._drive
        if drive is None:
            return
        linear, angular = drive.limits.linear, drive.limits.angular
        drive.set(
            math.copysign(min(abs(vx), linear), vx),
            math.copysign(min(abs(wz), angular), wz),
            valid_for=valid_for,
            since=since,
        )

    def halt(self, why: str) -> None:
        """End the drive without waiting: its thread sends zero at once."""
        drive = self._drive
        if drive is not None:
            drive.halt(why)

    def finish(self, why: str) -> None:
        """End the drive, and wait a bounded time until its zeros have been sent."""
        drive = self._drive
        try:
            if drive is not None:
                drive.halt(why)
                drive.finish(2.0)
        except RosError:
            pass  # the link is lost: zero will be the first message when it is back
        finally:
            if drive is not None:
                self._release(drive)

    def close(self, why: str) -> None:
        """End the drive without waiting, and allow no other."""
        with self._lock:
            self._closed = why
            self._lock.notify_all()
        self.halt(why)
