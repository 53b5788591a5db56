"""Driving by velocity in asyncio: the block of `woosh_pure.velocity`, as `async with`."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from types import TracebackType

from rosproto.aio import SameProperty
from rosproto.transport import Deadline
from woosh_pure.aio.calls import ThreadCalls
from woosh_pure.connection.arguments import require_seconds
from woosh_pure.geometry import Velocity
from woosh_pure.velocity import drive as velocity

_SLICE, _VALID = 0.1, 0.3  # seconds, as the threaded `hold` has them


class Drive:
    """An open velocity block; as `woosh_pure.velocity.Drive`.

    A loop that is held up for longer than a command is valid lets the robot stop.

    Attributes:
        drive: The threaded one underneath.
        limits: What `set` accepts.
        topic: Where the velocity goes.
    """

    def __init__(self, drive: velocity.Drive) -> None:
        self.drive = drive
        self.limits, self.topic = drive.limits, drive.topic

    def __repr__(self) -> str:
        return f"<aio {repr(self.drive)[1:]}"

    active = SameProperty[bool](velocity.Drive.active, "drive")
    finished = SameProperty[bool](velocity.Drive.finished, "drive")
    sending = SameProperty[Velocity](velocity.Drive.sending, "drive")
    others = SameProperty[tuple[str, ...]](velocity.Drive.others, "drive")

    def set(
        self,
        vx: float,
        wz: float = 0.0,
        *,
        vy: float = 0.0,
        valid_for: float = 0.5,
        since: float | None = None,
    ) -> None:
        """Command a body velocity that lapses by itself. Does not wait.

        Args:
            vx: Forward speed, m/s, in base_link (REP 103: x forward).
            wz: Yaw rate, rad/s, counter-clockwise positive.
            vy: Speed to the left, m/s; only an omnidirectional base has it.
            valid_for: Seconds until a zero velocity follows, at most 5.
            since: When the command was made, by `time.monotonic()`, if it was on its way for a while;
                `valid_for` counts from then. None means now.

        Raises:
            ValueError: A value is not finite or exceeds `limits`. The robot goes on with the last command.
            ConnectionLost, MotionRefused: The drive is over, and why.
        """
        self.drive.set(vx, wz, vy=vy, valid_for=valid_for, since=since)

    async def hold(self, vx: float, wz: float = 0.0, *, vy: float = 0.0, seconds: float) -> None:
        """Keep a velocity for `seconds`, then zero; raises at once when the drive is over (see `set`).
        Cancelled, zero follows at once.

        Args:
            vx, wz, vy: As for `set`: m/s and rad/s, in base_link.
            seconds: How long; the ramp to the velocity is part of it.

        Raises:
            ValueError: A value is not finite or exceeds `limits`, or `seconds` is negative or not finite.
            ConnectionLost: The velocity topic has no subscriber any more, or the chassis has fallen silent.
            MotionRefused: The drive is over; `error.readiness` gives the reason.
        """
        deadline = Deadline(require_seconds(seconds))
        try:
            while rest := deadline.remaining():
                self.set(vx, wz, vy=vy, valid_for=_VALID)
                await asyncio.sleep(min(rest, _SLICE))
        except BaseException:
            if self.drive.active:
                self.set(0.0, 0.0)
            raise
        self.set(0.0, 0.0)

    def halt(self, why: str) -> None:
        """End the drive; zero follows at once, and it never resumes. Does not wait."""
        self.drive.halt(why)


class VelocityBlock:
    """What `velocity` gives: `async with robot.velocity(bypasses_protection=True) as drive:`."""

    def __init__(self, calls: ThreadCalls, make: Callable[[], velocity.Drive]) -> None:
        self._calls = calls
        self._make = make
        self._drive: velocity.Drive | None = None

    async def __aenter__(self) -> Drive:
        if self._drive is not None:
            raise RuntimeError("this drive has been used already; open a new one with robot.velocity(...)")
        self._drive = await self._calls.call(lambda: self._make().__enter__())
        return Drive(self._drive)

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        drive = self._drive
        if drive is None:
            return
        if kind is GeneratorExit:  # the loop was closed over the block
            self._calls.spawn(drive.abandon)
        else:
            await self._calls.finish(lambda: drive.__exit__(kind, error, trace))
