"""Driving by velocity in asyncio: the block of `woosh_pure.velocity`, as `async with`."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from types import TracebackType
from typing import Any, Concatenate, ParamSpec

from rosproto.coercion import as_float
from rosproto.sentence import say
from rosproto.transport import Deadline
from woosh_pure.aio.calls import ThreadCalls, like, same
from woosh_pure.geometry import Velocity
from woosh_pure.velocity import drive as velocity
from woosh_pure.velocity.shaper import DriveLimits

P = ParamSpec("P")
_SLICE, _VALID = 0.1, 0.3  # seconds, as the threaded `hold` has them


def _at_once(method: Callable[Concatenate[Any, P], None]) -> Callable[Concatenate[Drive, P], None]:
    """The same method as that of the threaded drive, which does not wait."""

    def call(self: Drive, /, *args: P.args, **kwargs: P.kwargs) -> None:
        method(self.drive, *args, **kwargs)

    return like(method, call)


class Drive:
    """An open velocity block; as `woosh_pure.velocity.Drive`.

    A loop that is held up for longer than a command is valid lets the robot stop.

    Attributes:
        drive: The threaded one underneath.
    """

    def __init__(self, drive: velocity.Drive) -> None:
        self.drive = drive

    def __repr__(self) -> str:
        return f"<aio {repr(self.drive)[1:]}"

    limits: DriveLimits = same("drive.limits", "What `set` accepts.")
    topic: str = same("drive.topic", "Where the velocity goes.")
    active: bool = same("drive.active", velocity.Drive.active)
    finished: bool = same("drive.finished", velocity.Drive.finished)
    sending: Velocity = same("drive.sending", velocity.Drive.sending)
    others: tuple[str, ...] = same("drive.others", velocity.Drive.others)
    set = _at_once(velocity.Drive.set)
    halt = _at_once(velocity.Drive.halt)

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
        seconds = as_float(seconds)
        if not (math.isfinite(seconds) and seconds >= 0.0):
            raise ValueError(
                say("seconds={seconds}: expected a finite number of at least 0", seconds=seconds)
            )
        deadline = Deadline(seconds)
        try:
            while rest := deadline.remaining():
                self.set(vx, wz, vy=vy, valid_for=_VALID)
                await asyncio.sleep(min(rest, _SLICE))
        except BaseException:
            if self.drive.active:
                self.set(0.0, 0.0)
            raise
        self.set(0.0, 0.0)


class VelocityBlock:
    """What `velocity` gives: `async with robot.velocity(bypasses_protection=True) as drive:`."""

    def __init__(self, calls: ThreadCalls, make: Callable[[], velocity.Drive]) -> None:
        self._calls = calls
        self._make = make
        self._drive: velocity.Drive | None = None

    async def __aenter__(self) -> Drive:
        if self._drive is not None:
            raise RuntimeError("this drive was used before; open a new one with robot.velocity(...)")
        self._drive = await self._calls.call(lambda: self._make().__enter__())
        return Drive(self._drive)

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        drive = self._drive
        if drive is None:
            return
        if kind is GeneratorExit:  # the loop was closed over the block
            self._calls.let_go(drive.abandon)
        else:
            await self._calls.finish(lambda: drive.__exit__(kind, error, trace))
