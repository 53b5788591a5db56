"""From commands to the velocities that a drive sends: limits, ramp and lapse. Pure; times are arguments."""

from __future__ import annotations

import math
from dataclasses import dataclass

from rosproto.coercion import as_float
from rosproto.sentence import say
from woosh_pure.geometry import Velocity

DEFAULT_LINEAR = 0.3
"""m/s, where /driver_base/parameter is silent."""
DEFAULT_ANGULAR = 0.5
"""rad/s, where /driver_base/parameter is silent."""
_AFTER = 1e-3
"""Seconds after the end of a command at which to wake: never a moment before it."""


@dataclass(frozen=True, slots=True)
class DriveLimits:
    """Limits of a drive: speeds in m/s and rad/s, ramps in m/s² and rad/s²."""

    linear: float = DEFAULT_LINEAR
    angular: float = DEFAULT_ANGULAR
    acceleration: float = 0.5
    angular_acceleration: float = 1.5

    def check(self, velocity: Velocity) -> None:
        """Check that a velocity is finite and within the limits.

        Raises:
            ValueError: Which value, and what is allowed. Nothing is clamped.
        """
        if not all(map(math.isfinite, (velocity.vx, velocity.vy, velocity.wz))):
            raise ValueError(
                say("{velocity}: every value must be a finite number (m/s, rad/s)", velocity=velocity)
            )
        speed = math.hypot(velocity.vx, velocity.vy)
        if speed > self.linear * (1.0 + 1e-9):
            wrong = "{speed:.3f} m/s is more than the limit of {linear} m/s of this drive"
            raise ValueError(say(wrong, speed=speed, linear=self.linear))
        if abs(velocity.wz) > self.angular * (1.0 + 1e-9):
            wrong = "{wz:.3f} rad/s is more than the limit of {angular} rad/s of this drive"
            raise ValueError(say(wrong, wz=velocity.wz, angular=self.angular))


class Shaper:
    """Computes the velocity to send: the last command with a ramp, or zero if it has lapsed. Pure.

    One thread calls `next`; any other thread, also one that a signal handler has interrupted, calls
    `command`.
    """

    def __init__(self, limits: DriveLimits) -> None:
        self.limits = limits
        self.sent = Velocity()
        self._command = (Velocity(), -math.inf)  # with its expiry: one value, so that no lock is needed
        self._last: float | None = None

    def command(self, velocity: Velocity, now: float, valid_for: float) -> None:
        """Set a new command, valid for `valid_for` s.

        Raises:
            ValueError: Not finite, or out of the limits.
        """
        self.limits.check(velocity)
        valid_for = as_float(valid_for)
        if not (math.isfinite(valid_for) and 0.0 < valid_for <= 5.0):
            wrong = "valid_for={valid_for}: must be between 0 and 5 s; call again to continue"
            raise ValueError(say(wrong, valid_for=valid_for))
        self._command = (velocity, now + valid_for)

    def seconds_to_next(self, now: float, period: float) -> float:
        """Seconds until the next velocity is due: one `period`, or less if the command lapses before."""
        left = self._command[1] - now
        return left + _AFTER if self.sent != Velocity() and 0.0 <= left < period else period

    def next(self, now: float) -> Velocity:
        """The velocity to send at `now`. A lapsed command is zero at once, without a ramp."""
        w, until = self._command
        if now > until:
            self.sent, self._last = Velocity(), now
            return self.sent
        # The first call counts as one period of 20 Hz; a late one makes up for 0.2 s at most.
        dt = 0.05 if self._last is None else min(max(now - self._last, 0.0), 0.2)
        self._last = now
        step, turn = self.limits.acceleration * dt, self.limits.angular_acceleration * dt
        v = self.sent
        self.sent = Velocity(_ramp(v.vx, w.vx, step), _ramp(v.vy, w.vy, step), _ramp(v.wz, w.wz, turn))
        return self.sent


def _ramp(now: float, wanted: float, limit: float) -> float:
    if wanted == 0.0:
        return 0.0  # a stop is never delayed; the smooth topic brakes gently by itself
    return now + min(max(wanted - now, -limit), limit)
