"""What surrounds the simulated robot, and what its navigation does about it: wait, plan another way, drive
off, or brake. Pure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import pairwise
from typing import Protocol

import numpy as np

from woosh_pure.enums import NavigationMode
from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.sim.body import Body, integrate
from woosh_pure.sim.motions import Motion, MotionState, PathMotion, StepMotion
from woosh_pure.sim.planner import Planner
from woosh_pure.sim.settings import Settings

Obstacle = tuple[float, float, float]
"""A round obstacle: x, y, radius in m in the map."""

_SIGHT = 4.0  # m


class Surroundings:
    """Walls and things, and whether a round robot touches them.

    Attributes:
        things: Obstacles that are not on the map.
        seen: Those of them that the costmaps know.
    """

    def __init__(self, walls: GridMap, radius: float) -> None:
        self._walls = walls
        self._radius = radius  # of the robot, m
        self.things: list[Obstacle] = []
        self.seen: list[Obstacle] = []

    def look(self, pose: Pose2D) -> None:
        """Note the obstacles in sight, and forget those that have gone."""

        def in_sight(thing: Obstacle) -> bool:
            return math.hypot(thing[0] - pose.x, thing[1] - pose.y) < _SIGHT + thing[2]

        self.seen = [thing for thing in self.seen if thing in self.things or not in_sight(thing)]
        self.seen += [thing for thing in self.things if in_sight(thing) and thing not in self.seen]

    def touches(self, x: float, y: float, *, more: float = 0.0, known: bool = False) -> bool:
        """Whether the robot, standing there, would touch something; outside of the map is a wall.

        Args:
            x, y: m in the map.
            more: By how much it is taken to be larger, m.
            known: Look at walls and what the costmaps know, not at all that is there.
        """
        radius = self._radius + more
        things = self.seen if known else self.things
        if any(math.hypot(ox - x, oy - y) < r + radius for ox, oy, r in things):
            return True
        grid = self._walls
        row, column = grid.cell_of(x, y)
        reach = math.ceil(radius / grid.resolution)
        r0, r1, c0, c1 = row - reach, row + reach + 1, column - reach, column + reach + 1
        if r0 < 0 or c0 < 0 or r1 > grid.height or c1 > grid.width:
            return True
        window = grid.cells[r0:r1, c0:c1] > 50
        return bool(window.any()) and bool((window & _disc(reach, radius / grid.resolution)).any())

    def obstructed(self, pose: Pose2D, direction: Velocity, ahead: float) -> bool:
        """Whether an obstacle is within `ahead` m in a direction of the robot's own axes."""
        for k in range(1, math.ceil(ahead / 0.1) + 1):
            reach = min(ahead, 0.1 * k)
            there = pose.transformed(direction.vx * reach, direction.vy * reach, 0.0)
            if self.touches(there.x, there.y):
                return True
        return False

    def is_clear(self, a: Pose2D, b: Pose2D, *, more: float = 0.0, step: float = 0.025) -> bool:
        """Whether the robot, larger by `more` m, touches nothing that it knows on the straight way from one
        place to another, looked at every `step` m.
        """
        dx, dy = b.x - a.x, b.y - a.y
        parts = max(1, math.ceil(math.hypot(dx, dy) / step))
        return not any(
            self.touches(a.x + dx * k / parts, a.y + dy * k / parts, more=more, known=True)
            for k in range(parts + 1)
        )


@lru_cache(maxsize=64)
def _disc(reach: int, radius: float) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    offsets = np.arange(-reach, reach + 1)
    result: np.ndarray[tuple[int, ...], np.dtype[np.bool_]] = (
        offsets[:, None] ** 2 + offsets[None, :] ** 2 <= radius**2
    )
    return result


class Touch(Protocol):
    """`Surroundings.touches`."""

    def __call__(self, x: float, y: float, *, more: float = 0.0, known: bool = False) -> bool:
        """Whether the robot would touch something at x, y."""


def leaves_room_to_stop(body: Body, wanted: Velocity, dt: float, touches: Touch) -> bool:
    """Whether the base, after `dt` s of a commanded velocity, can brake hard and touches nothing it knows.

    The navigation gives out no velocity from which it could not stop. A goal may be replaced at any speed,
    cancelled, or paused, and none of it makes the robot run into what it knows: before each velocity is
    passed on, the stop that would have to follow it is looked at, step by step, as the base would do it.
    Where that stop would touch something the robot brakes now; that it can is what was looked at one step
    before.
    (move_base's local planners sort out such velocities, too.)
    """
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


_STEP_BLOCKED, _STEP_BLOCK_TIMEOUT = 130701000021, 130701000032
_NAV_BLOCKED, _NAV_FAILED = 130104000011, 130104000042


@dataclass(frozen=True, slots=True)
class NavigationSettings:
    """What /navigation_mode has set."""

    mode: NavigationMode = NavigationMode.FUZZY_AVOIDANCE
    waiting_timeout: float = 0.0
    max_speed: float = 0.0


class NavigationWorld(Protocol):
    """What the avoidance needs of the world it drives in; `woosh_pure.sim.world.World` is one."""

    settings: Settings
    body: Body
    planner: Planner
    around: Surroundings
    navigation: NavigationSettings

    def report(self, code: int) -> None:
        """Queue a number for /status_code."""


class Avoidance:
    """Decides for a running motion which velocity it may have."""

    def __init__(self, world: NavigationWorld) -> None:
        self._world = world

    def way_to(self, goal: Pose2D, *, cramped: bool = False) -> list[Pose2D] | None:
        """A path from here, around the obstacles the costmaps know; None when there is none.

        Where the robot stands too near to something for the cells of the planner, or was found to be cramped,
        it first drives off from it, straight.
        """
        planner, around, here = self._world.planner, self._world.around, self._world.body.pose
        path = planner.plan(here, goal, around.seen)
        free = planner.is_free(here.x, here.y, around.seen)
        clear = partial(around.is_clear, step=0.005)
        if path is None or (not cramped and (free or all(clear(a, b) for a, b in pairwise(path[:4])))):
            return path
        for k in range(16 * 5):
            turn, away = (k % 16) * math.pi / 8.0, 0.1 * (1 + k // 16)
            place = Pose2D(here.x + away * math.cos(turn), here.y + away * math.sin(turn))
            if planner.is_free(place.x, place.y, around.seen) and clear(here, place):
                rest = planner.plan(place, goal, around.seen)
                return path if rest is None else [here, *rest]
        return path

    def velocity(self, motion: Motion, dt: float) -> tuple[Velocity, bool]:
        """The velocity of a running motion for the next `dt` s, and whether to brake hard for it."""
        if self._blocked(motion, dt):
            return Velocity(), True
        wanted = motion.command(self._world.body, dt)
        if isinstance(motion, StepMotion) and not motion.avoid:
            return wanted, False
        if self.leaves_room(wanted, dt):
            if wanted.vx and isinstance(motion, PathMotion):
                motion.cramped_for = 0.0
            return wanted, False
        if not self._world.body.velocity.is_standing(0.01, math.inf):
            return Velocity(), True
        if isinstance(motion, PathMotion) and abs(wanted.wz) < 0.1:  # turned as it should, and no room ahead
            self._find_another_way(motion, dt)
        return Velocity(0.0, 0.0, wanted.wz), False

    def leaves_room(self, wanted: Velocity, dt: float) -> bool:
        """Whether the robot could still stop in front of everything after `dt` s of this velocity."""
        return leaves_room_to_stop(self._world.body, wanted, dt, self._world.around.touches)

    def _blocked(self, motion: Motion, dt: float) -> bool:
        if isinstance(motion, StepMotion):
            return motion.avoid and self._step_blocked(motion, dt)
        return isinstance(motion, PathMotion) and self._path_blocked(motion, dt)

    def _step_blocked(self, motion: StepMotion, dt: float) -> bool:
        d = motion.current.direction()
        if not (d.vx or d.vy) or not self._world.around.obstructed(self._world.body.pose, d, 0.25):
            motion.blocked_for = 0.0
            return False
        return self._wait_for_room(motion, dt, _STEP_BLOCKED, _STEP_BLOCK_TIMEOUT)

    def _path_blocked(self, motion: PathMotion, dt: float) -> bool:
        body, around, navigation = self._world.body, self._world.around, self._world.navigation
        # Standing, it may turn away from what is in front of it.
        ahead = 0.0 if body.velocity.vx < 0.01 and motion.blocked_for == 0.0 else 0.5
        if not around.seen or not around.obstructed(body.pose, Velocity(1.0), ahead):
            motion.blocked_for = 0.0
            return False
        patience = {
            NavigationMode.STOP_AND_WAIT: math.inf,
            NavigationMode.WAIT_THEN_AVOID: navigation.waiting_timeout,
        }
        if (
            motion.blocked_for >= patience.get(navigation.mode, 0.0)
            and int(motion.blocked_for / dt) % 25 == 0
        ):
            path = self.way_to(motion.goal)
            if path is not None:
                motion.path = path[1:]
                motion.blocked_for = 0.0
                return False
        return self._wait_for_room(motion, dt, _NAV_BLOCKED, _NAV_FAILED)

    def _find_another_way(self, motion: PathMotion, dt: float) -> None:
        """It stands too near to something to go on: plan from here, now and every half second."""
        if motion.cramped_for == 0.0:
            self._world.report(_NAV_BLOCKED)
        if round(motion.cramped_for / dt) % 25 == 0:
            path = self.way_to(motion.goal, cramped=True)
            motion.path = motion.path if path is None else path[1:]
        motion.cramped_for += dt
        if motion.cramped_for > self._world.settings.obstacle_patience:
            motion.end(MotionState.FAILED, _NAV_FAILED)

    def _wait_for_room(self, motion: Motion, dt: float, blocked: int, failed: int) -> bool:
        if motion.blocked_for == 0.0:
            self._world.report(blocked)
        motion.blocked_for += dt
        waits = self._world.navigation.mode is NavigationMode.STOP_AND_WAIT and isinstance(motion, PathMotion)
        if motion.blocked_for > self._world.settings.obstacle_patience and not waits:
            motion.end(MotionState.FAILED, failed)
        return True
