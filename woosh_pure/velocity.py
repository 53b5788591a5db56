"""Driving by velocity: a block that always ends in zero.

A velocity topic passes by the chassis's obstacle avoidance, collision detection and limits. So a velocity
exists only inside `with chassis.velocity(bypasses_protection=True) as drive:`. The shaping of commands
(`Shaper`) is pure; the thread that sends at a steady rate is in `Drive`.

What happens when this process is killed: nothing here can run then. The chassis's own behaviour remains,
which is not documented; assume that it drives on with the last velocity until something stops it. The
simulated chassis does that (`Settings.on_silence`).
"""

from __future__ import annotations

import atexit
import math
import threading
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rosproto.errors import ConnectionLost

from .errors import MotionRefused
from .geometry import Velocity

if TYPE_CHECKING:
    from types import TracebackType

    from .core import Core
    from .feed import Feed

__all__ = ["DEFAULT_ANGULAR", "DEFAULT_LINEAR", "Drive", "DriveLimits", "Shaper"]

DEFAULT_LINEAR = 0.3
"""m/s, where /driver_base/parameter is silent."""
DEFAULT_ANGULAR = 0.5
"""rad/s, where /driver_base/parameter is silent."""
_RATE = 20.0
_ZEROS = 5


@dataclass(frozen=True, slots=True)
class DriveLimits:
    """What a drive accepts: m/s, rad/s, and the ramp in m/s² and rad/s²."""

    linear: float = DEFAULT_LINEAR
    angular: float = DEFAULT_ANGULAR
    acceleration: float = 0.5
    angular_acceleration: float = 1.5

    def check(self, velocity: Velocity) -> None:
        """Refuse what is not finite or too fast.

        Raises:
            ValueError: Which value, and what is allowed. Nothing is clamped.
        """
        if not all(map(math.isfinite, (velocity.vx, velocity.vy, velocity.wz))):
            raise ValueError(f"{velocity}: every value must be a finite number (m/s, rad/s)")
        speed = math.hypot(velocity.vx, velocity.vy)
        if speed > self.linear * (1.0 + 1e-9):
            raise ValueError(f"{speed:.3f} m/s is more than the limit of {self.linear} m/s of this drive")
        if abs(velocity.wz) > self.angular * (1.0 + 1e-9):
            raise ValueError(
                f"{velocity.wz:.3f} rad/s is more than the limit of {self.angular} rad/s of this drive"
            )


class Shaper:
    """What to send now: the last command, ramped, and zero when it was not refreshed. Pure; times are
    given."""

    def __init__(self, limits: DriveLimits) -> None:
        self.limits = limits
        self.sent = Velocity()
        self._wanted = Velocity()
        self._until = -math.inf
        self._last: float | None = None

    def command(self, velocity: Velocity, now: float, valid_for: float) -> None:
        """A new command, valid for `valid_for` s.

        Raises:
            ValueError: Not finite, or out of the limits.
        """
        self.limits.check(velocity)
        if not (math.isfinite(valid_for) and 0.0 < valid_for <= 5.0):
            raise ValueError(f"valid_for={valid_for}: must be between 0 and 5 s; call again to go on longer")
        self._wanted, self._until = velocity, now + valid_for

    @property
    def wanted(self) -> Velocity:
        """The last command."""
        return self._wanted

    def lapsed(self, now: float) -> bool:
        """True when the last command is no longer valid."""
        return now > self._until

    def next(self, now: float) -> Velocity:
        """The velocity to send at `now`. A lapsed command is zero at once, without a ramp."""
        if self.lapsed(now):
            self.sent, self._last = Velocity(), now
            return self.sent
        dt = 0.05 if self._last is None else min(max(now - self._last, 0.0), 0.2)
        self._last = now
        step, turn = self.limits.acceleration * dt, self.limits.angular_acceleration * dt
        v, w = self.sent, self._wanted
        self.sent = Velocity(_ramp(v.vx, w.vx, step), _ramp(v.vy, w.vy, step), _ramp(v.wz, w.wz, turn))
        return self.sent


def _ramp(now: float, wanted: float, most: float) -> float:
    if wanted == 0.0:
        return 0.0  # a stop is never delayed; the smooth topic brakes gently by itself
    return now + min(max(wanted - now, -most), most)


class Drive:
    """An open velocity block; made by `Chassis.velocity`. Use it in a `with` statement.

    Attributes:
        limits: What `set` accepts.
        topic: Where the velocity goes.
    """

    def __init__(
        self,
        core: Core,
        topic: str,
        limits: DriveLimits,
        feedback_timeout: float | None,
        *,
        check: bool = True,
    ) -> None:
        self._core = core
        self._check = check
        self.topic = topic
        self.limits = limits
        if feedback_timeout is not None and not (math.isfinite(feedback_timeout) and feedback_timeout > 0.0):
            raise ValueError(
                f"feedback_timeout={feedback_timeout}: expected more than 0 s, or None for no feedback"
            )
        self._feedback_timeout = feedback_timeout
        self._beat: Feed[Velocity] = core.feed("velocity")
        self._shaper = Shaper(limits)
        self._lock = threading.Lock()
        self._over = threading.Event()
        self._entered = False
        self._error: Exception | None = None
        self._told = False  # whether the caller has seen it
        self._thread = threading.Thread(target=self._run, name="woosh:drive", daemon=True)

    def __enter__(self) -> Drive:
        if self._entered:
            raise MotionRefused("this drive was used before; open a new one with chassis.velocity(...)")
        self._entered = True
        try:
            self._publisher = self._core.velocity_publisher(self.topic)
            self._core.require_connection(self._publisher, self.topic)
            self._require_feedback()
            # What has become known since `chassis.velocity(...)` was called counts, too.
            self._core.require_ready("velocity", self._check)
            self._core.remember_drive(self, self._check)
        except BaseException:
            self._over.set()  # a drive that was not opened takes no velocity
            raise
        atexit.register(self._at_exit)
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._over.set()
        try:
            self._thread.join(2.0)
            self._core.zero(self.topic)
        finally:
            atexit.unregister(self._at_exit)
            self._core.forget_drive(self)
        if kind is None and self._error is not None and not self._told:
            raise self._error

    def set(self, vx: float, wz: float = 0.0, *, vy: float = 0.0, valid_for: float = 0.5) -> None:
        """Command a body velocity that lapses by itself.

        Call again before `valid_for` has passed to keep moving.

        Args:
            vx: Forward speed, m/s, in base_link (REP 103: x forward).
            wz: Yaw rate, rad/s, counter-clockwise positive.
            vy: Speed to the left, m/s; only an omnidirectional base has it.
            valid_for: Seconds until a zero velocity follows, at most 5.

        Raises:
            ValueError: A value is not finite or exceeds `limits`. The robot goes on with the last command.
            ConnectionLost: Nobody subscribes to the velocity topic any more, or the chassis has fallen
                silent.
            MotionRefused: The drive is over: `stop()` was called, the block was left, or the robot was
                stopped by other means (emergency stop, manual mode, a severe fault); `error.readiness` tells.
        """
        self._raise_if_over()
        velocity = Velocity(float(vx), float(vy), float(wz))
        with self._lock:
            self._shaper.command(velocity, time.monotonic(), valid_for)

    def hold(self, vx: float, wz: float = 0.0, *, vy: float = 0.0, seconds: float) -> None:
        """Keep a velocity for `seconds`, then zero; raises at once when the drive is over (see `set`).

        Args:
            vx, wz, vy: As for `set`: m/s and rad/s, in base_link.
            seconds: How long; the ramp to the velocity is part of it.

        Raises:
            ValueError: As `set`; or `seconds` is negative or not finite.
            ConnectionLost, MotionRefused: As `set`.
        """
        if not (math.isfinite(seconds) and seconds >= 0.0):
            raise ValueError(f"seconds={seconds}: expected a finite number of at least 0")
        end = time.monotonic() + seconds
        while (rest := end - time.monotonic()) > 0.0:
            self.set(vx, wz, vy=vy, valid_for=0.3)
            if self._over.wait(min(rest, 0.1)):
                self._raise_if_over()
        self.set(0.0, 0.0)

    @property
    def active(self) -> bool:
        """False when the drive is over, for whatever reason."""
        return self._thread.is_alive() and not self._over.is_set()

    @property
    def sending(self) -> Velocity:
        """The velocity sent last."""
        with self._lock:
            return self._shaper.sent

    def halt(self, why: str) -> None:
        """End the drive from outside; zero follows at once and nothing resumes."""
        self._end(MotionRefused(f"the drive is over: {why}; open a new one with chassis.velocity(...)"))

    def finish(self, timeout: float = 1.0) -> None:
        """Wait, with a bound, until the zeros of a drive that is over have been sent."""
        if self._thread.is_alive() and self._thread is not threading.current_thread():
            self._thread.join(timeout)

    def _raise_if_over(self) -> None:
        if self._error is not None:
            self._told = True
            raise self._error
        if not self._entered or self._over.is_set():
            raise MotionRefused("a velocity exists only inside `with chassis.velocity(...) as drive:`")

    def _require_feedback(self) -> None:
        if self._feedback_timeout is not None:
            self._core.require_heard("velocity", 3.0)

    def _end(self, error: Exception) -> None:
        with self._lock:
            if self._error is None and not self._over.is_set():
                self._error = error
            self._over.set()

    def _lost(self) -> str | None:
        if self._publisher.connections == 0:
            return f"{self.topic}: nobody subscribes any more"
        beat = self._beat.known
        age = None if beat is None else beat.age
        if self._feedback_timeout is not None and (age is None or age > self._feedback_timeout):
            return f"/odom_twist has been silent for more than {self._feedback_timeout} s"
        return None

    def _blocked(self) -> bool:
        """End the drive when the robot is stopped by other means: releasing its button must not resume it."""
        readiness = self._core.known_readiness()
        if readiness.ready or not self._check:
            return False
        self._end(
            MotionRefused(
                "the drive is over and does not resume by itself; open a new one when the robot is ready",
                readiness=readiness,
            )
        )
        return True

    def _run(self) -> None:
        try:
            while not self._over.wait(1.0 / _RATE):
                if self._blocked():
                    break
                lost = self._lost()
                if lost is not None:
                    self._core.zero_is_due(self.topic)
                    self._end(
                        ConnectionLost(
                            f"the drive is over: {lost}; nothing resumes by itself, check the network"
                        )
                    )
                    break
                with self._lock:
                    velocity = self._shaper.next(time.monotonic())
                self._core.publish_velocity(self.topic, velocity)
        except Exception as error:  # whatever it is, the drive must not end without a zero
            self._end(ConnectionLost(f"the drive is over: sending failed: {error}"))
        finally:
            self._send_zeros()

    def _send_zeros(self) -> None:
        for _ in range(_ZEROS):
            self._core.zero(self.topic)
            time.sleep(0.02)
        self._core.flush(self.topic)

    def _at_exit(self) -> None:
        # Orderly exit with the block still open in some thread: zero goes out before the interpreter ends.
        self._over.set()
        self._thread.join(1.0)
        self._core.zero(self.topic)
