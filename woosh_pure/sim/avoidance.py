"""Obstacles of the simulated navigation: `CollisionMap` finds them; `Avoidance` waits, plans another path,
drives off or brakes. Pure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from woosh_pure.enums import NavigationMode
from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.sim.body import integrate
from woosh_pure.sim.motions import Motion, MotionState, PathMotion, StepMotion
from woosh_pure.sim.planner import Obstacle

if TYPE_CHECKING:
    from woosh_pure.sim.world import World

_SIGHT = 4.0  # m


class CollisionMap:
    """Walls and obstacles, and whether a round robot would touch them.

    Attributes:
        obstacles: Obstacles that are not on the map.
        seen_obstacles: Those that the costmaps know.
    """

    def __init__(self, walls: GridMap, radius: float) -> None:
        self._walls = walls
        self._radius = radius  # of the robot, m
        self.obstacles: list[Obstacle] = []
        self.seen_obstacles: list[Obstacle] = []

    def update_seen(self, pose: Pose2D) -> None:
        """Add the obstacles in sight, and remove those that are gone."""

        def in_sight(obstacle: Obstacle) -> bool:
            return math.hypot(obstacle[0] - pose.x, obstacle[1] - pose.y) < _SIGHT + obstacle[2]

        kept = [each for each in self.seen_obstacles if each in self.obstacles or not in_sight(each)]
        new = [each for each in self.obstacles if in_sight(each) and each not in kept]
        self.seen_obstacles = kept + new

    def touches(self, x: float, y: float, *, more: float = 0.0, known: bool = False) -> bool:
        """Whether the robot would touch something at a place; outside the map is a wall.

        Args:
            x, y: m in the map.
            more: Margin added to the robot's radius, m.
            known: Check walls and the obstacles of the costmaps only.
        """
        radius = self._radius + more
        obstacles = self.seen_obstacles if known else self.obstacles
        if any(math.hypot(ox - x, oy - y) < r + radius for ox, oy, r in obstacles):
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
        """Whether the straight line between two places is free of known obstacles, with a margin of `more` m,
        checked every `step` m.
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


_STEP_BLOCKED, _STEP_BLOCK_TIMEOUT = 130701000021, 130701000032
_NAV_BLOCKED, _NAV_FAILED = 130104000011, 130104000042


@dataclass(frozen=True, slots=True)
class NavigationSettings:
    """The settings of /navigation_mode."""

    mode: NavigationMode = NavigationMode.FUZZY_AVOIDANCE
    waiting_timeout: float = 0.0
    max_speed: float = 0.0


class Avoidance:
    """Limits the velocity of a running motion."""

    def __init__(self, world: World) -> None:
        self._world = world

    def way_to(self, goal: Pose2D, *, too_close: bool = False) -> list[Pose2D] | None:
        """A path from here around the known obstacles; None if there is none.

        If the robot is too close to something for the planner's cells, or `too_close`, it first drives away
        straight.
        """
        planner, collisions, here = self._world.planner, self._world.collisions, self._world.body.pose
        path = planner.plan(here, goal, collisions.seen_obstacles)
        free = planner.is_free(here.x, here.y, collisions.seen_obstacles)
        clear = partial(collisions.is_clear, step=0.005)
        if path is None or (not too_close and (free or all(clear(a, b) for a, b in pairwise(path[:4])))):
            return path
        for k in range(16 * 5):
            turn, away = (k % 16) * math.pi / 8.0, 0.1 * (1 + k // 16)
            place = Pose2D(here.x + away * math.cos(turn), here.y + away * math.sin(turn))
            if planner.is_free(place.x, place.y, collisions.seen_obstacles) and clear(here, place):
                rest = planner.plan(place, goal, collisions.seen_obstacles)
                return path if rest is None else [here, *rest]
        return path

    def velocity(self, motion: Motion, dt: float) -> tuple[Velocity, bool]:
        """The velocity of a running motion for the next `dt` s, and whether to brake hard."""
        if self._blocked(motion, dt):
            return Velocity(), True
        wanted = motion.command(self._world.body, dt)
        if isinstance(motion, StepMotion) and not motion.avoid:
            return wanted, False
        if self.leaves_room(wanted, dt):
            if wanted.vx and isinstance(motion, PathMotion):
                motion.too_close_for = 0.0
            return wanted, False
        if not self._world.body.velocity.is_standing(0.01, math.inf):
            return Velocity(), True
        if isinstance(motion, PathMotion) and abs(wanted.wz) < 0.1:
            # It has turned, and there is no room ahead.
            self._find_another_way(motion, dt)
        return Velocity(0.0, 0.0, wanted.wz), False

    def leaves_room(self, wanted: Velocity, dt: float) -> bool:
        """Whether the base, after `dt` s of a commanded velocity, can still brake hard without touching a
        known obstacle.

        A goal may be replaced, cancelled or paused at any speed, and the robot must not hit a known obstacle
        then. So before each velocity the stop after it is simulated step by step. If that stop would touch
        something, the robot brakes now, which the check of the step before has shown to be possible.
        (move_base's local planners discard such velocities, too.)
        """
        body, touches = self._world.body, self._world.collisions.touches
        velocity = body.approached(body.velocity, wanted, dt)
        size = math.hypot(velocity.vx, velocity.vy)
        if size == 0.0:
            return True  # a round robot can turn in place
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

    def _blocked(self, motion: Motion, dt: float) -> bool:
        if isinstance(motion, StepMotion):
            return motion.avoid and self._step_blocked(motion, dt)
        return isinstance(motion, PathMotion) and self._path_blocked(motion, dt)

    def _step_blocked(self, motion: StepMotion, dt: float) -> bool:
        d = motion.current.direction()
        ahead = min(0.25, motion.rest + 0.1)  # what is beyond the end of the step does not hold it
        if not (d.vx or d.vy) or not self._world.collisions.obstructed(self._world.body.pose, d, ahead):
            motion.blocked_for = 0.0
            return False
        return self._wait_for_room(motion, dt, _STEP_BLOCKED, _STEP_BLOCK_TIMEOUT)

    def _path_blocked(self, motion: PathMotion, dt: float) -> bool:
        body, collisions, navigation = self._world.body, self._world.collisions, self._world.navigation
        # A standing robot may turn away from an obstacle.
        ahead = 0.0 if body.velocity.vx < 0.01 and motion.blocked_for == 0.0 else 0.5
        if not collisions.seen_obstacles or not collisions.obstructed(body.pose, Velocity(1.0), ahead):
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
        """Plan a new path now and every half second, because the robot is too close to something to go on."""
        if motion.too_close_for == 0.0:
            self._world.report(_NAV_BLOCKED)
        if round(motion.too_close_for / dt) % 25 == 0:
            path = self.way_to(motion.goal, too_close=True)
            motion.path = motion.path if path is None else path[1:]
        motion.too_close_for += dt
        if motion.too_close_for > self._world.settings.obstacle_patience:
            motion.end(MotionState.FAILED, _NAV_FAILED)

    def _wait_for_room(self, motion: Motion, dt: float, blocked: int, failed: int) -> bool:
        if motion.blocked_for == 0.0:
            self._world.report(blocked)
        motion.blocked_for += dt
        waits = self._world.navigation.mode is NavigationMode.STOP_AND_WAIT and isinstance(motion, PathMotion)
        if motion.blocked_for > self._world.settings.obstacle_patience and not waits:
            motion.end(MotionState.FAILED, failed)
        return True
