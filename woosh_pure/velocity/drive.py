"""Driving by velocity: a block that always ends in zero.

A velocity topic passes by the chassis's obstacle avoidance, collision detection and limits. So a velocity
exists only inside `with chassis.velocity(bypasses_protection=True) as drive:`. `Drive` and its sending thread
are here; limits, ramp and lapse are in `shaper`, the reasons why a drive ends by itself in `end_conditions`.

When this process is killed, the watchdog sends zero, if there is one (`stopping/watchdog_client.py`). Without
it the behaviour of the chassis is not documented: assume that it continues with the last velocity until it is
stopped. The simulated chassis does that (`Settings.on_silence`).
"""

from __future__ import annotations

import math
import threading
import time
from contextlib import ExitStack
from types import TracebackType

from rosproto.coercion import as_float
from rosproto.errors import ConnectionLost, RosError
from rosproto.logs import get_logger
from rosproto.sentence import say
from rosproto.transport import Deadline
from rosproto.watchdog import ROUNDS
from woosh_pure.components import Components
from woosh_pure.connection.arguments import require_seconds
from woosh_pure.connection.other_drivers import OtherDriver, other_drivers
from woosh_pure.errors import MotionRefused
from woosh_pure.geometry import Velocity
from woosh_pure.stopping.stop_executor import SLICE, Flag
from woosh_pure.velocity.end_conditions import EndConditions, Heartbeat
from woosh_pure.velocity.shaper import DriveLimits, Shaper

logger = get_logger("woosh_pure.velocity")
_RATE = 20.0
_LOOK_AROUND = 2.0  # seconds between two checks for other drivers
_LOOK_AGAIN = 0.5  # seconds until another driver is checked again: two counts show whether it sends


class Drive:
    """An open velocity block; made by `Chassis.velocity`. Use it in a `with` statement.

    Attributes:
        limits: What `set` accepts.
        topic: Where the velocity goes.
    """

    def __init__(
        self,
        components: Components,
        topic: str,
        limits: DriveLimits,
        feedback_timeout: float | None,
        *,
        since: int,
        check: bool = True,
        share: bool = False,
    ) -> None:
        feedback_timeout = as_float(feedback_timeout)
        if feedback_timeout is not None and not (math.isfinite(feedback_timeout) and feedback_timeout > 0.0):
            wrong = "feedback_timeout={feedback_timeout}: expected more than 0 s, or None for no feedback"
            raise ValueError(say(wrong, feedback_timeout=feedback_timeout))
        self._components = components
        self._since = since  # `ActiveMotions.since` of the verb
        self._check, self._share = check, share
        self.topic = topic
        self.limits = limits
        self._feedback_timeout = feedback_timeout
        self._shaper = Shaper(limits)
        # State that other threads change is a `Flag` or a single attribute, so `halt` works without a lock,
        # also in a signal handler.
        self._over = Flag()
        self._sent_zeros = Flag()
        self._held: list[str] = []  # the publisher, until it is released
        self._entered = False
        self._others: tuple[OtherDriver, ...] = ()
        self._error: Exception | None = None
        self._told = False  # whether the error was raised to the caller
        self._thread = threading.Thread(target=self._run, name="woosh:drive", daemon=True)

    def __repr__(self) -> str:
        state = "over" if self._over.is_set else "open" if self._entered else "not entered"
        sent = self.sending
        return f"<Drive {self.topic}, {state}: {sent.vx:g} {sent.vy:g} m/s, {sent.wz:g} rad/s>"

    def __enter__(self) -> Drive:
        if self._entered:
            raise MotionRefused("this drive has been used already; open a new one with chassis.velocity(...)")
        self._entered = True
        components = self._components
        with ExitStack() as undo:  # Ctrl-C included: a drive that did not open accepts no velocity
            undo.callback(self._over.set)
            publisher = components.velocity.acquire(self.topic)
            self._held.append(self.topic)
            undo.callback(self._release)
            self._require_alone()
            publisher.wait_for_connection(timeout=components.connection.timeout)
            if self._feedback_timeout is not None:
                components.feeds.require_heard("velocity", 3.0)
            components.watchdog_client.drive(self.topic)
            # Readiness may have changed since `chassis.velocity(...)` was called.
            components.readiness_state.require_ready(say("velocity"), self._check)
            components.velocity.begin(self.topic)
            components.motions.add_drive(self, self._since, check=self._check)
            undo.callback(components.motions.remove_drive, self)
            threading.Thread(target=self._look_around, name="woosh:drivers", daemon=True).start()
            heartbeat = None
            if self._feedback_timeout is None:
                heartbeat = Heartbeat(components.connection.open_node(), publisher, self._over)
                heartbeat.start()
            self._end_conditions = EndConditions(
                components.readiness_state,
                components.feeds.get("velocity"),
                publisher,
                self._feedback_timeout,
                heartbeat,
                check=self._check,
            )
            self._thread.start()
            undo.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._over.is_set = True  # without a call: no stack may be left, see `immediate_stop`
        self._over.set()
        # A second Ctrl-C may interrupt this: closing the Chassis, or the end of the program, finishes it.
        self.finish(2.0)
        if kind is None and self._error is not None and not self._told:
            raise self._error

    def set(
        self,
        vx: float,
        wz: float = 0.0,
        *,
        vy: float = 0.0,
        valid_for: float = 0.5,
        since: float | None = None,
    ) -> None:
        """Command a body velocity that lapses by itself.

        Call again before `valid_for` has passed to keep moving.

        Args:
            vx: Forward speed, m/s, in base_link (REP 103: x forward).
            wz: Yaw rate, rad/s, counter-clockwise positive.
            vy: Speed to the left, m/s; only an omnidirectional base has it.
            valid_for: Seconds until a zero velocity follows, at most 5.
            since: When the command was made, by `time.monotonic()`, if it was on its way for a while (through
                a network, a queue): `valid_for` counts from then. None means now.

        Raises:
            ValueError: A value is not finite or exceeds `limits`. The robot goes on with the last command.
            ConnectionLost: Nobody subscribes to the velocity topic any more, or the chassis has fallen
                silent.
            MotionRefused: The drive is over: `stop()` was called, the block was left, or the robot was
                stopped by other means (emergency stop, manual mode, a severe fault); `error.readiness` tells.
        """
        now = time.monotonic()  # before anything can delay this thread, or a delay would prolong the command
        made = now if since is None else min(as_float(since), now)
        if not math.isfinite(made):
            raise ValueError(
                say("since={since}: expected a time by time.monotonic(), or None for now", since=since)
            )
        self._raise_if_over()
        self._shaper.command(Velocity(vx, vy, wz), made, valid_for)

    def hold(self, vx: float, wz: float = 0.0, *, vy: float = 0.0, seconds: float) -> None:
        """Keep a velocity for `seconds`, then zero; raises at once when the drive is over (see `set`).

        Args:
            vx, wz, vy: As for `set`: m/s and rad/s, in base_link.
            seconds: How long; the ramp to the velocity is part of it.

        Raises:
            ValueError: A value is not finite or exceeds `limits`, or `seconds` is negative or not finite.
            ConnectionLost: The velocity topic has no subscriber any more, or the chassis has fallen silent.
            MotionRefused: The drive is over; `error.readiness` gives the reason.
        """
        deadline = Deadline(require_seconds(seconds))
        while rest := deadline.remaining():
            self.set(vx, wz, vy=vy, valid_for=0.3)
            if self._over.wait(min(rest, 0.1)):
                self._raise_if_over()
        self.set(0.0, 0.0)

    @property
    def active(self) -> bool:
        """False when the drive is over, for whatever reason."""
        return self._thread.is_alive() and not self._over.is_set

    @property
    def sending(self) -> Velocity:
        """The velocity sent last."""
        return self._shaper.sent

    def halt(self, why: str) -> None:
        """End the drive; zero follows at once, and it never resumes. Does not wait."""
        why = say(why)
        self._end(
            MotionRefused(say("the drive is over: {why}; open a new one with chassis.velocity(...)", why=why))
        )

    @property
    def end_due(self) -> bool:
        """Whether it is over and has not sent all of its zeros yet."""
        return self._over.is_set and not self._sent_zeros.is_set

    def end_now(self, why: str) -> None:
        """End it, and write the first zero in this thread: the sending thread may be delayed."""
        self.halt(why)
        self._components.velocity.write_zero(self.topic)

    def end_again(self) -> None:
        """Write zero once more."""
        self._components.velocity.write_zero(self.topic)

    def finish(self, timeout: float = 1.0) -> None:
        """Wait, with a bound, until the zeros of a drive that is over have been sent."""
        deadline = Deadline(timeout)
        if self._thread is not threading.current_thread():
            while not self.finished and not deadline.expired:
                self._sent_zeros.wait(deadline.at_most(SLICE).remaining() or 0.0)
        if not self.finished:
            self._components.velocity.zero(self.topic)
        else:
            self._components.motions.remove_drive(self)

    def abandon(self) -> None:
        """End the drive of a cancelled asyncio task; wait, with a time limit, for its zeros."""
        self.halt("the task that drove was cancelled")
        self.finish(2.0)

    @property
    def finished(self) -> bool:
        """True when it is over and its zeros have been sent."""
        return self._over.is_set and (self._sent_zeros.is_set or not self._thread.is_alive())

    @property
    def others(self) -> tuple[str, ...]:
        """Nodes that can send velocities, too, as last seen: looked for every 2 s, each newcomer is logged
        as a warning, and one that is seen to send ends the drive. The robot's own nodes are left out.
        """
        return tuple(driver.node for driver in self._others)

    def _raise_if_over(self) -> None:
        if self._error is not None:
            self._told = True
            raise self._error
        if not self._entered or self._over.is_set:
            raise MotionRefused("a velocity can be set only inside `with chassis.velocity(...) as drive:`")

    def _require_alone(self) -> None:
        self._others = other_drivers(self._components.connection.open_node())
        for driver in self._others:
            if not (driver.on_robot or self._share):
                raise MotionRefused(
                    say(
                        "velocity refused, nothing was sent: {why}; the robot would obey both in turn. End "
                        "that program; or share (share=True, `woosh drive --share`) if it is silent while "
                        "you drive",
                        why=driver.sentence(),
                    )
                )
            logger.warning("%s: %s", self.topic, driver.sentence())

    def _look_around(self) -> None:
        while not self._over.wait(_LOOK_AGAIN if self._others else _LOOK_AROUND):
            try:
                found = other_drivers(self._components.connection.open_node())
            except RosError:
                continue  # the drive goes on without the master: open links do not need it
            before, self._others = {driver.node: driver for driver in self._others}, found
            for driver in found:
                self._look_at(driver, before.get(driver.node))

    def _look_at(self, driver: OtherDriver, before: OtherDriver | None) -> None:
        """Warn of a program that can send; one that does send ends the drive: the robot would obey both."""
        if self._check and driver.has_sent_since(before):
            self._end(
                MotionRefused(
                    say(
                        "the drive is over: {why}; the robot would obey both in turn, and obeys that program "
                        "now: watch it, and end that program before you drive again",
                        why=driver.sentence(sends=True),
                    )
                )
            )
        elif before is None:
            logger.warning("! %s: %s; end one of the two programs", self.topic, driver.sentence())

    def _end(self, error: Exception) -> None:
        if self._error is None and not self._over.is_set:
            self._error = error
        self._over.set()

    def _run(self) -> None:
        try:
            while not self._over.wait(self._shaper.seconds_to_next(time.monotonic(), 1.0 / _RATE)):
                problem = self._end_conditions.problem(self.sending)
                if problem is not None:
                    if isinstance(problem, ConnectionLost):
                        self._components.velocity.zero_is_due(self.topic)
                    while self._end_conditions.awaits_code(problem) and not self._over.is_set:
                        self._components.velocity.zero(self.topic)
                        time.sleep(0.02)
                        problem = self._end_conditions.with_code(problem)
                    self._end(problem)
                    break
                velocity = self._shaper.next(time.monotonic())
                if not self._over.is_set:  # the checks above may have taken long
                    self._components.velocity.publish(self.topic, velocity)
        except Exception as error:  # the drive must always end with a zero
            self._end(ConnectionLost(say("the drive is over: sending failed: {error}", error=error)))
        finally:
            try:
                self._send_zeros()
            finally:
                self._sent_zeros.set()

    def _send_zeros(self) -> None:
        for _ in range(ROUNDS):
            self._components.velocity.zero(self.topic)
            time.sleep(0.02)
        try:
            self._components.velocity.end(self.topic)
        finally:
            self._release()

    def _release(self) -> None:
        """Release the publisher, once."""
        try:
            self._components.velocity.release(self._held.pop())
        except IndexError:
            pass  # already released
