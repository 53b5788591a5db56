"""A motion inside one call: asked for, judged, begun, watched, and ended with the call.

The call lasts as long as the motion. It ends the motion when it is cancelled, as when the host cancels it, its
stream is closed, or stdin ends; when a limit is broken on the way; when its time is up; when a person takes the
lease. The process's own end is the watchdog's.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, Protocol

import anyio
from anyio.to_thread import run_sync
from mcp.server.mcpserver import Context
from mcp.server.mcpserver.exceptions import ToolError
from pydantic import BaseModel, Field

from rosproto.errors import RosError
from rosproto.sentence import both, say, shown
from woosh_pure.geometry import Pose2D
from woosh_pure.mcp import texts
from woosh_pure.mcp.limits import Limits
from woosh_pure.missions import Phase
from woosh_pure.outcome import OutcomeKind
from woosh_pure.readings import known_path
from woosh_pure.reasons import Ready
from woosh_pure.web.goals import Command
from woosh_pure.web.http_errors import Problem, for_clients, problem_of

if TYPE_CHECKING:
    from woosh_pure.missions import MissionHandle
    from woosh_pure.web.goals import Goal
    from woosh_pure.web.robot import Robot

OWNER = "assistant"
"""The name by which an assistant holds the lease, and stands in the journal."""
CURRENT = "2026-07-28"
"""The first revision of the protocol in which a closed stream over HTTP ends its call."""
LEASE_SECONDS, TICK, STALE_SECONDS, CANCEL_SECONDS, PROGRESS_SECONDS = 5.0, 0.05, 2.0, 5.0, 1.0
CONFIRM = ("always", "when-possible", "never")
Confirming = Literal["always", "when-possible", "never"]
_WORDS = {
    OutcomeKind.ARRIVED: "reached",
    OutcomeKind.REJECTED: "refused",
    OutcomeKind.FAILED: "failed",
    OutcomeKind.CONNECTION_LOST: "not known",
}
"""The others are "stopped"."""


class Confirm(BaseModel):
    """What a person answers before the robot moves."""

    allow: bool = Field(description="Let the robot move")


class Place(BaseModel):
    """A place in the robot's map."""

    x_m: float
    y_m: float
    heading_deg: float = Field(description="counter-clockwise from the map's x axis")


class Result(BaseModel):
    """Base of what tools return."""

    note: str = texts.DATA


class Moved(Result):
    """How a motion ended. Only "reached" is success."""

    outcome: Literal["reached", "refused", "stopped", "failed", "not known"]
    sentence: str = Field(description="what happened, and what to do next")
    pose: Place | None = Field(description="where the robot is now; null if not known")
    metres: float = Field(description="driven in this call, m, by its pose")
    seconds: float


def place_of(pose: Pose2D | None) -> Place | None:
    """A pose as tools return it."""
    if pose is None or not all(map(math.isfinite, (pose.x, pose.y, pose.yaw))):
        return None
    return Place(x_m=round(pose.x, 3), y_m=round(pose.y, 3), heading_deg=round(pose.yaw_degrees, 1))


def can_ask(ctx: Context[Any, Any]) -> bool:
    """Whether the client can put a question to its person."""
    asks = ctx.client_capabilities.elicitation if ctx.client_capabilities else None
    return asks is not None and (asks.form is not None or asks.url is None)


class Ride(Protocol):
    """Something under way that a call has begun."""

    @property
    def done(self) -> bool:
        """Whether it has ended."""

    @property
    def progress(self) -> str:
        """How far it has come."""

    def end(self) -> None:
        """End it now; blocks until the robot confirms, in a bounded time."""

    def result(self) -> tuple[str, str]:
        """The word and the sentence of its end."""


class GoalRide:
    """A goal of the chassis."""

    def __init__(self, goal: Goal) -> None:
        self.goal = goal

    @property
    def done(self) -> bool:
        return self.goal.done

    @property
    def progress(self) -> str:
        return shown(str(self.goal.handle.progress))

    def end(self) -> None:
        self.goal.handle.cancel(CANCEL_SECONDS)

    def result(self) -> tuple[str, str]:
        outcome = self.goal.outcome
        if outcome is None:
            return "not known", self.goal.error or "its end is not known"
        return _WORDS.get(outcome.kind, "stopped"), for_clients(str(outcome))


class MissionRide:
    """A mission. A person who takes it over has paused it; it is not ended then."""

    def __init__(self, robot: Robot, handle: MissionHandle) -> None:
        self.robot, self.handle = robot, handle

    @property
    def done(self) -> bool:
        run = self.handle.run
        return run is not None and run.phase.over

    @property
    def progress(self) -> str:
        run = self.handle.run
        if run is None:
            return say("queued")
        where = say(
            "{phase}, step {number} of {count}", phase=run.phase, number=run.at + 1, count=len(run.steps)
        )
        return both(where, run.question.text) if run.question else where

    def end(self) -> None:
        self.robot.chassis.missions.stop(by=OWNER)

    def result(self) -> tuple[str, str]:
        run = self.handle.run
        if run is None or not run.phase.over:
            return "not known", "the mission has not ended"
        words = {Phase.DONE: "reached", Phase.FAILED: "failed"}
        return words.get(run.phase, "stopped"), both(str(run.phase), *([run.reason] if run.reason else []))


@dataclass(frozen=True)
class Wanted:
    """A motion that a tool asks for.

    Attributes:
        what: The command, for the question, the journal and the page.
        start: Begins it; blocks.
        target: Where it would lead from a pose; None if that is not known.
        straight: Whether it leads there in a straight line.
        check: What else speaks against it, "" if nothing does.
    """

    what: Command
    start: Callable[[], Ride]
    target: Callable[[Pose2D], Pose2D | None] = field(default=lambda here: None)
    straight: bool = False
    check: Callable[[Pose2D | None], str] = field(default=lambda here: "")
    mission: bool = False


class Mover:
    """Carries out the motions of one server, one at a time for each robot.

    Args:
        limits: The limits of each motion.
        confirm: Whether a person is asked before each motion.
    """

    def __init__(self, limits: Limits, confirm: Confirming) -> None:
        self.limits, self.confirm = limits, confirm
        self._busy: set[str] = set()

    def client_refusal(self, ctx: Context[Any, Any]) -> str:
        """Why this client may not move anything; "" if it may."""
        if ctx.headers is not None and (ctx.protocol_version or "") < CURRENT:
            return say(
                "over HTTP, only clients of protocol {current} or later may move the robot: with an older one, "
                "nobody sees that the client is gone; use stdio, or a newer client",
                current=CURRENT,
            )
        if self.confirm == "always" and not can_ask(ctx):
            return say(
                "a person has to agree to each motion, and this client cannot ask (elicitation); the person who "
                "runs the server decides that with --confirm"
            )
        return ""

    def must_ask(self, ctx: Context[Any, Any]) -> bool:
        """Whether this client is to ask its person."""
        return self.confirm != "never" and can_ask(ctx)

    async def carry_out(self, robot: Robot, wanted: Wanted, ctx: Context[Any, Any], agreed: bool) -> Moved:
        """Carry out a motion to its end, whatever that is."""
        trip = _Trip(robot)
        why = self.client_refusal(ctx) or ("" if agreed else say("the person who was asked has not agreed"))
        if not why and robot.name in self._busy:
            why = say("another call moves this robot now; wait for it, or stop it")
        if why:
            return trip.refused(wanted, why)
        self._busy.add(robot.name)
        try:
            return await self._carry_out(robot, wanted, ctx, trip)
        finally:
            self._busy.discard(robot.name)

    async def _carry_out(self, robot: Robot, wanted: Wanted, ctx: Context[Any, Any], trip: _Trip) -> Moved:
        call = robot.chassis.request()  # a stop from here on prevents it
        lease, ride = robot.chassis.lease, None
        try:
            if why := await run_sync(partial(self._refusal, robot, wanted, trip), abandon_on_cancel=True):
                return trip.refused(wanted, why)
            if not lease.acquire(OWNER, LEASE_SECONDS):
                return trip.refused(wanted, say("{holder} commands this robot now", holder=lease.holder))

            def start() -> Ride:
                with call:
                    return wanted.start()

            try:
                ride = await run_sync(start, abandon_on_cancel=not wanted.mission)
            except (RosError, ValueError, Problem) as error:
                problem = problem_of(error)
                refused = problem.status in (409, 422, 404)
                return trip.moved("refused" if refused else "not known", problem.text)
            why = await self._watch(robot, wanted, ride, ctx, trip)
            if why and not ride.done:
                robot.journal.note(OWNER, wanted.what, "stopped", why)
                if not (wanted.mission and lease.holder not in (None, OWNER)):
                    with anyio.CancelScope(shield=True):
                        await run_sync(partial(_end, ride))
                for _ in range(round(2.0 / TICK)):
                    if ride.done:
                        break
                    await anyio.sleep(TICK)
            word, sentence = ride.result()
            return trip.moved(
                "stopped" if why and word != "not known" else word, both(why, sentence) if why else sentence
            )
        finally:
            if ride is None or not ride.done:
                with anyio.CancelScope(shield=True):
                    await run_sync(call.end if ride is None or not wanted.mission else partial(_end, ride))
            lease.release(OWNER)

    def _refusal(self, robot: Robot, wanted: Wanted, trip: _Trip) -> str:
        """Why the motion is refused now; "" if it is not. Blocks."""
        robot.require_connection()
        robot.listen()
        readiness = robot.chassis.readiness()
        if readiness.answer is not Ready.YES:
            return shown(str(readiness))
        here = trip.begin()
        try:
            target = None if here is None else wanted.target(here)
        except ValueError as error:
            return str(error)
        why = wanted.check(here)
        if not why and not wanted.mission:
            why = self.limits.refusal(here, target, straight=wanted.straight)
        return why

    async def _watch(
        self, robot: Robot, wanted: Wanted, ride: Ride, ctx: Context[Any, Any], trip: _Trip
    ) -> str:
        """Wait for the end of a motion; why it must be ended before, "" if it has ended."""
        begun = due = time.monotonic()
        while not ride.done:
            now = time.monotonic()
            if now - begun > self.limits.max_seconds:
                return say("its {seconds:g} s are over", seconds=self.limits.max_seconds)
            if why := _taken_over(robot, wanted) or trip.look(self.limits, now - begun):
                return why
            if now >= due:
                due = now + PROGRESS_SECONDS
                robot.chassis.lease.renew(OWNER, LEASE_SECONDS)
                with anyio.move_on_after(TICK):  # a host that reads nothing must not hold the watch up
                    await ctx.report_progress(round(now - begun, 2), message=texts.data(ride.progress))
            await anyio.sleep(TICK)
        return ""


def _end(ride: Ride) -> None:
    """End a ride; one whose end is not confirmed is told as not known."""
    try:
        ride.end()
    except RosError:
        pass


def _taken_over(robot: Robot, wanted: Wanted) -> str:
    """Who else has taken the lease, as a reason to end; "" if nobody has."""
    lease = robot.chassis.lease
    holder = lease.holder
    if holder is None and not wanted.mission:  # it lapsed while this process was held up
        lease.acquire(OWNER, LEASE_SECONDS)
        holder = lease.holder
    ours = (None, OWNER, robot.chassis.missions.owner) if wanted.mission else (None, OWNER)
    return "" if holder in ours else say("{holder} has taken the robot over", holder=holder)


class _Trip:
    """Where a robot is and was since a call has begun."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.begun = time.monotonic()
        self.start: Pose2D | None = None
        self._last: Pose2D | None = None
        self._metres = 0.0
        self._fast = 0

    def begin(self) -> Pose2D | None:
        """Note where it starts; wait a moment for its first pose."""
        try:
            self.robot.chassis.pose.wait(STALE_SECONDS, new=False)
        except RosError:
            return None
        self.start = self._last = self._here()
        return self.start

    def _here(self) -> Pose2D | None:
        reading = self.robot.feed("pose").known
        return None if reading is None or reading.age > STALE_SECONDS else reading.value

    def look(self, limits: Limits, seconds: float) -> str:
        """Why the limits are broken now, `seconds` after the begin of the motion; "" if they are not."""
        here = self._here()
        if here is not None:
            self._metres += 0.0 if self._last is None else self._last.distance_to(here)
            self._last = here
        velocity = self.robot.feed("velocity").known
        fast = velocity is not None and limits.too_fast(math.hypot(velocity.value.vx, velocity.value.vy))
        self._fast = self._fast + 1 if fast else 0
        if self._fast > 3:
            return say("it drives faster than the {most:g} m/s that are allowed", most=limits.max_speed)
        if not limits.by_place:
            return ""
        if here is None or self.start is None:
            return say("where the robot is has not been heard for {seconds:g} s", seconds=STALE_SECONDS)
        if why := limits.leaves(self.start, [here]):
            return both(say("it has left its limits"), why)
        plan = self.robot.feed("plan").known
        way = known_path(self.robot.chassis) if plan is not None and plan.age < seconds else []
        why = limits.leaves(self.start, way)
        return both(say("its planned way leads out of its limits"), why) if why else ""

    def moved(self, outcome: Any, sentence: str) -> Moved:
        """The result of the call."""
        sentence = texts.data(shown(say(sentence)), 1000)
        seconds = round(time.monotonic() - self.begun, 2)
        here = place_of(self._here() or self._last)
        return Moved(
            outcome=outcome, sentence=sentence, pose=here, metres=round(self._metres, 2), seconds=seconds
        )

    def refused(self, wanted: Wanted, why: str) -> Moved:
        """The result of a motion that has not begun; the journal has it, too."""
        self.robot.journal.note(OWNER, wanted.what, "refused", why)
        return self.moved("refused", say("refused, nothing has moved: {why}", why=say(why)))


def tool_error(error: Exception) -> ToolError:
    """An error for the assistant, in words; an unexpected one is logged, and its text stays here."""
    return ToolError(texts.data(shown(problem_of(error).text), 1000))
