"""Driving by one page: its dead-man switch, its velocity drive, and the lease that the drive needs."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Coroutine, Sequence

from rosproto.errors import RosError
from rosproto.sentence import say
from woosh_pure.connection.call_scope import CallScope
from woosh_pure.errors import MotionRefused
from woosh_pure.web.context import WebContext
from woosh_pure.web.goals import command
from woosh_pure.web.http_errors import Problem, problem_of
from woosh_pure.web.live.deadman import DeadManSwitch, Verdict
from woosh_pure.web.live.frame_pacing import BadMessage, FrameSender
from woosh_pure.web.robot import Robot
from woosh_pure.web.snapshot import reasons_part

MAX_ROUND_TRIP = 0.4
"""Longest time from a frame to its acknowledgement when a drive begins. The travel time of the first press
itself is unknown."""


class PageDriving:
    """Applies the page's driving messages. Only `watch` waits, so that the next beat or stop is not delayed.

    Used in the event loop only.

    Args:
        context: The web context: whether driving is allowed, and threads to open and end drives.
        robot: The robot.
        name: The page's name, shown to others.
        outgoing: Sends the page the state of its drive.
        start: Runs a coroutine until it ends or the connection does.

    Attributes:
        confirmed: Whether the person has read and confirmed the warning.
    """

    def __init__(
        self,
        context: WebContext,
        robot: Robot,
        name: str,
        outgoing: FrameSender,
        start: Callable[[Coroutine[object, object, None]], None],
    ) -> None:
        self._context, self._robot, self._name = context, robot, name
        self._tell, self._round_trip, self._start = outgoing.tell, outgoing.round_trip, start
        self.confirmed = False
        self._dead_man = DeadManSwitch()
        self._presses = 0
        self._press = CallScope()  # of the newest press
        self._driving = False
        self._drive_entry = 0

    def gone(self) -> None:
        """End the drive of a page that has disconnected."""
        self._dead_man.end("gone")
        if self._driving:
            self._end_drive("gone")

    # -- the lease -------------------------------------------------------------------------------------------

    def ask_lease(self, op: object, to: object) -> None:
        """Request the lease, give it back, grant it, or keep it: then the request of `to` is refused.

        Raises:
            BadMessage: `op` is none of these.
        """
        lease, me = self._robot.chassis.lease, self._name
        if op == "ask":
            if not lease.acquire(me):
                lease.request(me)
        elif op == "give":
            self.give()
        elif op == "keep":
            if lease.renew(me) and isinstance(to, str):
                lease.withdraw(to)
        elif op == "grant":
            to = to or next(iter(lease.state.asking), "")
            if isinstance(to, str) and lease.grant(me, to):
                self._apply(self._dead_man.end("no lease"))
        else:
            raise BadMessage(say("op={op!r:.40}: expected ask, give, keep or grant", op=op))

    def give(self) -> None:
        """End the drive, and give the lease back."""
        self._apply(self._dead_man.end("no lease"))
        self._robot.chassis.lease.release(self._name)

    # -- the dead-man switch ---------------------------------------------------------------------------------

    def press(self, seq: int, at: float, vx: float, wz: float) -> None:
        """The person begins to hold the control."""
        refusal = self._refusal()
        if refusal is not None:
            self._tell_drive("refused", *refusal)
            return
        call = self._robot.chassis.request()  # the drive may wait for a thread, and a stop may come meanwhile
        verdict = self._dead_man.press(seq, at, vx, wz, time.monotonic())
        if verdict.act == "open":
            self._press = call
        self._apply(verdict)

    def beat(self, seq: int, at: float, vx: float, wz: float) -> None:
        """The person still holds the control."""
        now = time.monotonic()
        self._apply(self._dead_man.beat(seq, at, vx, wz, now), now)
        self._keep_lease()

    def release(self) -> None:
        """The person lets go."""
        self._apply(self._dead_man.end("released"))

    async def watch(self) -> None:
        """Check for silence, and while a drive is being opened for a stop by anybody, every 50 ms."""
        while True:
            await asyncio.sleep(0.05)
            if self._dead_man.held:
                self._apply(self._dead_man.tick(time.monotonic()))
            if self._dead_man.state == "opening" and self._press.overtaken:
                self._apply(self._dead_man.end("stopped"))

    def _keep_lease(self) -> None:
        if self._dead_man.held and not self._robot.chassis.lease.renew(self._name):
            self._apply(self._dead_man.end("no lease"))

    def _refusal(self) -> tuple[str, str] | None:
        if not self._context.allow_driving:
            return "not allowed", "driving is off; it is allowed by starting the server with --allow-driving"
        if self._robot.unreachable:
            return "not connected", self._robot.unreachable
        if self._robot.chassis.lease.holder != self._name:
            return "no lease", "ask for the lease first: one person drives at a time"
        if not self.confirmed:
            return "not confirmed", "read and confirm the warning first"
        trip = self._round_trip()
        if trip > MAX_ROUND_TRIP:
            return "slow link", f"the network takes {trip:.1f} s: nobody can drive through that"
        driver = self._robot.manual_drive.driver
        if driver not in (None, self._name):
            return "busy", f"{driver} drives, or has just let go"
        return None

    # -- the drive -------------------------------------------------------------------------------------------

    def _apply(self, verdict: Verdict, now: float | None = None) -> None:
        """Carry out a verdict of the dead-man switch without waiting; `now` is the time of the verdict."""
        if verdict.act == "drive":
            try:
                self._robot.manual_drive.steer(verdict.vx, verdict.wz, verdict.valid_for, now)
            except (RosError, ValueError) as error:
                self._drive_failed(error)
        elif verdict.act == "open":
            self._tell_drive("opening")
            self._presses += 1
            self._start(self._open(self._presses, self._press))
        elif verdict.act == "zero":
            self._end_drive(verdict.reason)
        elif verdict.reason:
            self._tell_drive("refused", verdict.reason, "press again")

    def _tell_drive(self, state: str, reason: str = "", text: str = "", **more: object) -> None:
        self._tell({"t": "drive", "state": state, "reason": reason, "text": text, **more})

    async def _open(self, press: int, call: CallScope) -> None:
        """Open a drive for one press, and end it again if another press has come meanwhile."""
        manual_drive, name = self._robot.manual_drive, self._name

        def begin() -> None:
            with call:
                manual_drive.open(name)

        opening = self._context.drives.start(begin)
        try:
            await asyncio.shield(opening)
        except asyncio.CancelledError:  # the page disconnected while the drive was being opened
            opening.add_done_callback(lambda done: self._abandon(done, "the page disconnected"))
            raise
        except Exception as error:
            if press == self._presses:
                problem = problem_of(error)
                reason = problem.kind if isinstance(error, Problem) else "refused"
                self._dead_man.end(reason)
                more = {"kind": problem.kind, "reasons": _reasons(error)}
                self._tell_drive("refused", reason, problem.text, **more)
            return
        if press != self._presses:
            self._abandon(opening, "the control was released")
            return
        self._driving = True
        entry = self._robot.journal.begin(name, command("drive"))
        now = time.monotonic()
        verdict = self._dead_man.opened(now)
        if self._dead_man.state == "driving":
            self._tell_drive("driving", limits=manual_drive.limits)
        self._drive_entry = entry
        self._apply(verdict, now)

    def _abandon(self, opening: asyncio.Future[None], why: str) -> None:
        """End an abandoned drive, but only if it was opened: an open drive may be another client's."""
        if not opening.cancelled() and opening.exception() is None:
            self._context.drives.start(self._robot.manual_drive.finish, why)

    def _end_drive(self, reason: str, text: str = "", reasons: Sequence[object] = ()) -> None:
        """Send zero, then note the end in the journal and notify the page."""
        if not self._driving:
            if reason:
                self._tell_drive("ended", reason, text)
            return
        self._driving = False
        why = text or say("the control on the page: {reason}", reason=reason)
        self._robot.manual_drive.halt(why)
        self._robot.journal.end(self._drive_entry, "done", say("ended: {why}", why=say(text or reason)))
        self._tell_drive("ended", reason, text, reasons=list(reasons))
        self._context.drives.start(self._robot.manual_drive.finish, why)

    def _drive_failed(self, error: Exception) -> None:
        """Handle a drive that the robot, a stop or a lost link has ended."""
        self._dead_man.end("over")
        self._end_drive("over", str(error), _reasons(error))


def _reasons(error: Exception) -> list[dict[str, object]]:
    return reasons_part(error.reasons) if isinstance(error, MotionRefused) else []
