"""What the simulated navigation does about obstacles: wait, plan another way, drive off, or brake. Pure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Protocol

from woosh_pure.enums import NavigationMode
from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.sim.body import Body
from woosh_pure.sim.braking import leaves_room_to_stop
from woosh_pure.sim.motions import Motion, MotionState, PathMotion, StepMotion
from woosh_pure.sim.planner import Planner
from woosh_pure.sim.settings import Settings
from woosh_pure.sim.surroundings import Surroundings

__all__ = ["Avoidance", "NavigationSettings", "NavigationWorld"]

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
