"""The braking distance of the simulated navigation: it gives out no velocity from which it could not stop.

A goal may be replaced at any speed, cancelled, or paused, and none of it makes the robot run into what it
knows: before each velocity is passed on, the stop that would have to follow it is looked at, step by step, as
the base would do it. Where that stop would touch something the robot brakes now; that it can is what was
looked at one step before. (move_base's local planners sort out such velocities, too.) Pure.
"""

from __future__ import annotations

import math
from typing import Protocol

from woosh_pure.geometry import Velocity
from woosh_pure.sim.body import Body, integrate

__all__ = ["Touch", "leaves_room_to_stop"]


class Touch(Protocol):
    """`Surroundings.touches`."""

    def __call__(self, x: float, y: float, *, more: float = 0.0, known: bool = False) -> bool:
        """Whether the robot would touch something at x, y."""


def leaves_room_to_stop(body: Body, wanted: Velocity, dt: float, touches: Touch) -> bool:
    """Whether the base, after `dt` s of a commanded velocity, can brake hard and touches nothing it knows."""
    velocity = body.approached(body.velocity, wanted, dt)
    size = math.hypot(velocity.vx, velocity.vy)
    if size == 0.0:
        return True  # a round robot turns in its own place
    reach = size * size / (2.0 * body.limits.hard_acceleration) + 2.0 * size * dt + 0.1
    if not touches(body.pose.x, body.pose.y, more=reach, known=True):
        return True
    pose = body.pose
    while velocity.vx or velocity.vy:
        pose = integrate(pose, velocity, dt)
        if touches(pose.x, pose.y, known=True):
            return False
        velocity = body.approached(velocity, Velocity(), dt, hard=True)
    return True
