"""A motion inside one call: judged, begun, watched, and ended with the call.

The call lasts as long as the motion. It ends the motion when it is cancelled (by the host, a closed stream,
the end of stdin), a limit is broken, its time is up, or a person takes the lease. The watchdog ends it when
the process dies.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import anyio
from anyio.to_thread import run_sync
from mcp.server.mcpserver import Context
from pydantic import BaseModel, Field

from rosproto.errors import RosError
from rosproto.sentence import both, say, shown
from woosh_pure.geometry import Pose2D
from woosh_pure.mcp import texts
from woosh_pure.mcp.limits import SPEED_SLACK, Limits
from woosh_pure.missions import Phase
from woosh_pure.outcome import OutcomeKind
from woosh_pure.readings import known_path
from woosh_pure.reasons import Readiness, ReasonKey
from woosh_pure.web.http_errors import Problem, for_clients, problem_of

if TYPE_CHECKING:
    from woosh_pure.missions import MissionHandle
    from woosh_pure.web.goals import Goal
    from woosh_pure.web.robot import Robot

OWNER = "assistant"
"""The name by which an assistant holds the lease, and stands in the journal."""
CURRENT = "2026-07-28"
"""The first revision of the protocol in which a closed stream over HTTP ends its call."""
LEASE_SECONDS, TICK, STALE_SECONDS, END_SECONDS, PROGRESS_SECONDS = 5.0, 0.05, 2.0, 3.0, 1.0
BRAKE_SECONDS = 0.4
"""At its present velocity the robot goes on for about so long when a limit ends its motion."""
Confirming = Literal["always", "when-possible", "never"]
Word = Literal["reached", "refused", "stopped", "failed", "not known"]
_WORDS: dict[object, Word] = {
    OutcomeKind.ARRIVED: "reached",
    OutcomeKind.REJECTED: "refused",
    OutcomeKind.FAILED: "failed",
    OutcomeKind.CONNECTION_LOST: "not known",
    Phase.DONE: "reached",
    Phase.FAILED: "failed",
}
"""Every other end is "stopped"."""
NOT_AGREED = "the person who was asked has not agreed"
CANNOT_ASK = (
    "a person has to agree to each motion, and this client cannot ask one (elicitation); who runs the server "
    "may change that by --confirm"
)


class Confirm(BaseModel):
    """What a person answers before the robot moves."""

    allow: bool = Field(description="Let the robot move")


class Place(BaseModel):
    """A place in the robot's map."""

    x_m: float
    y_m: float
    heading_deg: float = Field(description="counter-clockwise from the x axis")


class Result(BaseModel):
    """Base of what tools return."""

    note: str = texts.DATA


class Moved(Result):
    """How a motion ended. Only "reached" is success."""

    outcome: Word
    sentence: str = Field(description="what happened, and what to do next")
    pose: Place | None = Field(description="where the robot is now; null if not known")
    metres: float = Field(description="driven in this call, m")
    seconds: float


def place_of(pose: Pose2D | None) -> Place | None:
    """A pose as tools return it."""
    if pose is None or not all(map(math.isfinite, (pose.x, pose.y, pose.yaw))):
        return None
    return Place(x_m=round(pose.x, 3), y_m=round(pose.y, 3), heading_deg=round(pose.yaw_degrees, 1))


class GoalRide:
    """A goal of the chassis under way."""

    def __init__(self, goal: Goal) -> None:
        self.goal = goal

    @property
    def done(self) -> bool:
        """Whether it has ended."""
        return self.goal.done

    @property
    def progress(self) -> str:
        """How far it has come."""
        return str(self.goal.handle.progress)

    def result(self) -> tuple[Word, str]:
        """The word and the sentence of its end."""
        if (outcome := self.goal.outcome) is None:
            return "not known", self.goal.error or say("its end is not confirmed")
        return _WORDS.get(outcome.kind, "stopped"), for_clients(str(outcome))


class MissionRide:
    """A mission under way."""

    def __init__(self, handle: MissionHandle) -> None:
        self.handle = handle

    @property
    def done(self) -> bool:
        """Whether it has ended."""
        return (run := self.handle.run) is not None and run.phase.over

    @property
    def progress(self) -> str:
        """Its step, and its question."""
        if (run := self.handle.run) is None:
            return ""
        where = say("step {number} of {count}", number=run.at + 1, count=len(run.steps))
        return both(where, run.question.text) if run.question else where

    def result(self) -> tuple[Word, str]:
        """The word and the sentence of its end."""
        if (run := self.handle.run) is None or not run.phase.over:
            return "not known", say("the mission has not ended")
        return _WORDS.get(run.phase, "stopped"), both(str(run.phase), *([run.reason] if run.reason else []))


Ride = GoalRide | MissionRide


@dataclass(frozen=True)
class Wanted:
    """A motion that a tool asks for.

    Attributes:
        start: Begins it; blocks.
        target: Where it leads from a pose, None if not known.
        straight: Whether it leads there in a straight line.
        check: What else speaks against it from a pose, "" if nothing does.
        end: Ends a mission; None for a goal.
    """

    start: Callable[[], Ride]
    target: Callable[[Pose2D], Pose2D | None] = lambda here: None
    straight: bool = False
    check: Callable[[Pose2D | None], str] = lambda here: ""
    end: Callable[[], object] | None = None


def asks(ctx: Context[Any, Any], confirm: Confirming) -> bool:
    """Whether a call asks the client's person."""
    asks = ctx.client_capabilities.elicitation if ctx.client_capabilities else None
    return confirm != "never" and asks is not None and (asks.form is not None or asks.url is None)


def client_refusal(ctx: Context[Any, Any], confirm: Confirming) -> str:
    """Why a client may not move anything; "" if it may."""
    if ctx.headers is not None and (ctx.protocol_version or "") < CURRENT:
        older = (
            "over HTTP, a client of a protocol before {current} may not move the robot, because nobody sees "
        )
        return say(older + "that it is gone; use stdio, or a newer client", current=CURRENT)
    return "" if confirm != "always" or asks(ctx, confirm) else CANNOT_ASK


class Motion:
    """One call that moves a robot: what it does, and where the robot was since.

    Args:
        robot, wanted, limits: What is to move, how, and within which limits.
        moving: Names of the robots that move in a call: one call moves a robot at a time.
    """

    def __init__(self, robot: Robot, wanted: Wanted, limits: Limits, moving: set[str]) -> None:
        self._robot, self._wanted, self._limits, self._moving = robot, wanted, limits, moving
        self._lease, self._call = robot.chassis.lease, robot.chassis.request()
        self._begun = self._started = time.monotonic()
        self._ride: Ride | None = None
        self._beginning = threading.Lock()
        self._start: Pose2D | None = None
        self._last: Pose2D | None = None
        self._metres, self._fast, self._plans = 0.0, 0, -1

    async def go(self, ctx: Context[Any, Any], why: str) -> tuple[Word, str]:
        """Begin it, unless there is a reason why not; watch it; end it. Return the word and the sentence."""
        if why or self._robot.name in self._moving:
            return "refused", why or "another call moves this robot now; wait for it, or stop it"
        self._moving.add(self._robot.name)
        try:
            try:
                if why := await run_sync(self._refusal, abandon_on_cancel=True):
                    return "refused", why
                ride = await run_sync(self._begin, abandon_on_cancel=self._wanted.end is None)
            except (RosError, ValueError, Problem) as error:
                problem = problem_of(error)
                return "refused" if problem.status in (404, 409, 422) else "not known", problem.text
            if why := await self._watch(ride, ctx):
                await self._end()
            word, sentence = ride.result()
            if not why:
                return word, sentence
            return "not known" if word == "not known" else "stopped", both(why, sentence)
        finally:
            await self._end()
            self._lease.release(OWNER)
            self._moving.discard(self._robot.name)

    def _refusal(self) -> str:
        """Why the motion is refused now; "" if it is not. Blocks."""
        robot, wanted = self._robot, self._wanted
        robot.require_connection()
        robot.listen()
        reasons = robot.chassis.readiness().reasons
        # After an earlier refusal or failure it may be asked again, as by the verbs: else nothing ends that.
        now = Readiness(tuple(one for one in reasons if one.key != ReasonKey.REFUSED))
        if not now.ready:
            return str(now)
        try:
            robot.chassis.pose.wait(STALE_SECONDS, new=False)
        except RosError:
            pass  # judged by the limits
        here = self._start = self._last = self._here()
        why = wanted.check(here)
        if not why and wanted.end is None:
            target = None if here is None else wanted.target(here)
            why = self._limits.refusal(here, target, straight=wanted.straight)
        if why or self._lease.acquire(OWNER, LEASE_SECONDS):
            return why
        return say("{holder} commands this robot now", holder=self._lease.holder)

    def _begin(self) -> Ride:
        with self._beginning, self._call:
            self._started = time.monotonic()
            self._ride = self._wanted.start()
            return self._ride

    def _stop(self) -> None:
        self._call.end()
        if self._wanted.end:
            with self._beginning:  # a mission that is just beginning ends, too
                if self._ride is not None:
                    self._wanted.end()

    async def _watch(self, ride: Ride, ctx: Context[Any, Any]) -> str:
        """Wait for the end of a motion; why it must end before, "" if it has ended."""
        due, over = self._started, self._started + self._limits.max_seconds
        while not ride.done:
            now = time.monotonic()
            if now > over:
                return say("its {seconds:g} s are over", seconds=self._limits.max_seconds)
            if why := self._taken_over() or self._broken(now):
                return why
            if now >= due:
                due = now + PROGRESS_SECONDS
                self._lease.renew(OWNER, LEASE_SECONDS)
                progress = texts.data(shown(ride.progress))
                with anyio.move_on_after(TICK):  # a host that reads nothing must not hold up this watch
                    await ctx.report_progress(round(now - self._started, 2), message=progress)
            await anyio.sleep(TICK)
        return ""

    async def _end(self) -> None:
        """End what has not ended, and wait for that. A mission that a person has taken over is paused."""
        if self._ride and (self._ride.done or (self._wanted.end and self._taken_over())):
            return
        with anyio.CancelScope(shield=True):
            # A limiter of its own: an end waits for no thread that a reading call holds.
            await run_sync(self._stop, limiter=anyio.CapacityLimiter(1))
            until = time.monotonic() + END_SECONDS
            while self._ride and not self._ride.done and time.monotonic() < until:
                await anyio.sleep(TICK)

    def _taken_over(self) -> str:
        """Who else has the lease, as a reason to end; "" if nobody has."""
        holder = self._lease.holder
        if holder is None and self._wanted.end is None:  # it lapsed while this process was held up
            self._lease.acquire(OWNER, LEASE_SECONDS)
        mission = self._robot.chassis.missions.owner if self._wanted.end else OWNER
        return (
            ""
            if holder in (None, OWNER, mission)
            else say("{holder} has taken the robot over", holder=holder)
        )

    def _here(self) -> Pose2D | None:
        reading = self._robot.feed("pose").known
        return None if reading is None or reading.age > STALE_SECONDS else reading.value

    def _broken(self, now: float) -> str:
        """Which limit is broken on the way; "" if none is."""
        limits, here, velocity = self._limits, self._here(), self._robot.feed("velocity").known
        if here is not None:
            self._metres += here.distance_to(self._last or here)
            self._last = here
        speed = 0.0 if velocity is None else math.hypot(velocity.value.vx, velocity.value.vy)
        self._fast = self._fast + 1 if speed > (limits.max_speed or math.inf) + SPEED_SLACK else 0
        if self._fast > 3:
            return say("it drives faster than the {maximum:g} m/s that are allowed", maximum=limits.max_speed)
        if not limits.by_place:
            return ""
        if here is None or self._start is None:
            return say("its place has not been heard for {seconds:g} s", seconds=STALE_SECONDS)
        plan, way = self._robot.feed("plan"), [here]
        if plan.count != self._plans and plan.known and plan.known.age < now - self._started:
            self._plans, way = plan.count, known_path(self._robot.chassis)
        ahead = here
        if velocity is not None:
            vx, vy = velocity.value.vx, velocity.value.vy
            ahead = here.transformed(vx * BRAKE_SECONDS, vy * BRAKE_SECONDS, 0.0)
        why = limits.leaves(self._start, [here, ahead]) or limits.leaves(self._start, way)
        return both(say("it leaves its limits"), why) if why else ""

    def moved(self, outcome: Word, sentence: str) -> Moved:
        """The result of the call."""
        return Moved(
            outcome=outcome,
            sentence=texts.data(shown(say(sentence)), 1000),
            pose=place_of(self._here() or self._last),
            metres=round(self._metres, 2),
            seconds=round(time.monotonic() - self._begun, 2),
        )
