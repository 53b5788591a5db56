"""`World`: the simulated robot in its site, stepped by `step(dt)`. Pure: no sockets, threads or clocks.

Not modelled: slipping, payload, slopes, doors and lifts, other robots, traffic control, camera optics, radio.
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from rosproto.sentence import say
from woosh_pure.enums import RobotMode, RobotState, TaskState, TaskType, WorkMode
from woosh_pure.faults import ActiveFaults
from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.motion.steps import Step
from woosh_pure.sim.avoidance import Avoidance, CollisionMap, NavigationSettings
from woosh_pure.sim.body import Body, Localization
from woosh_pure.sim.motions import Motion, MotionState, PathMotion, StepMotion
from woosh_pure.sim.planner import Obstacle, Planner
from woosh_pure.sim.settings import Settings
from woosh_pure.sim.site import Site, built_in_site, not_free
from woosh_pure.sim.tasks import TaskMachine
from woosh_pure.values.state import RobotStatus


class SimulatedBattery:
    """A 24 V, 40 Ah battery that drains by time and driving, and charges at the dock or by cable.

    Attributes:
        percent: Charge, 0 to 100, with fractions.
        charging: Whether current flows in.
        automatic: Whether a task has started charging (charge mode 1).
        rate: Time factor of draining and charging, for tests.
        current: A; negative while it drains.
    """

    FULL_AH = 40.0

    def __init__(self, percent: float = 87.0, rate: float = 1.0) -> None:
        self.percent = percent
        self.charging = False
        self.automatic = False
        self.rate = rate
        self.current = -1.5

    def step(self, dt: float, velocity: Velocity) -> None:
        """Advance by `dt` s."""
        speed = math.hypot(velocity.vx, velocity.vy) + 0.3 * abs(velocity.wz)
        self.current = 15.0 if self.charging else -(1.5 + 8.0 * speed)
        change = self.current * dt / 3600.0 / self.FULL_AH * 100.0 * self.rate
        self.percent = min(100.0, max(0.0, self.percent + change))

    @property
    def voltage(self) -> float:
        """Voltage, V."""
        return 22.4 + 0.05 * self.percent + (0.6 if self.charging else 0.0)

    @property
    def capacity(self) -> float:
        """Remaining charge, Ah."""
        return self.FULL_AH * self.percent / 100.0


_CLEARANCE = 0.05  # distance of planned paths from obstacles, m
_LOST = 130103000012
_INITIALISED, _NOT_INITIALISED = 140200000000, 140201000022
_NAV_REACHED = 130104000041
_ESTOP, _ESTOP_RELEASED, _BUMPER, _BUMPER_RELEASED = 110201000013, 110201000000, 110202000013, 110202000000


class World:
    """The true state of robot and site, and the robot's own estimates.

    Attributes:
        time: Simulated seconds since power-up.
        body, battery, tasks, site: The parts.
        collisions: Walls and obstacles.
        motion: The motion under way; None if there is none.
        localization: The robot's estimated pose.
        avoidance: The obstacle avoidance of the navigation.
        emergency_stop, cable_plugged, robot_mode: States that the methods set.
        work_mode: TASK; a test may assign another one, in which tasks are refused.
    """

    def __init__(self, site: Site | None = None, settings: Settings | None = None) -> None:
        self.settings = settings or Settings()
        self.site = site or built_in_site()
        self.time = 0.0
        self.tasks = TaskMachine(self)
        self.avoidance = Avoidance(self)
        self._reports: list[int] = []
        self._power_up()

    def _power_up(self) -> None:
        self.random = random.Random(self.settings.seed)
        self.planner = Planner(self.site.grid, self.settings.radius, _CLEARANCE)
        start = self.settings.start or self._free_place(self.site.start)
        self.body = Body(start, self.settings.limits, self.random, self.settings.drift)
        self.battery = SimulatedBattery(self.settings.battery_percent, self.settings.battery_rate)
        self.tasks.power_up()
        self.map_seen: GridMap = self.site.grid
        self.collisions = CollisionMap(self.site.grid, self.settings.radius)
        self.costmaps_enabled = True
        self.navigation = NavigationSettings()
        self.motion: Motion | None = None
        self.paused_step: StepMotion | None = None
        self.emergency_stop = False
        self.cable_plugged = False
        self.docked = False
        self.bumper = False
        self.robot_mode = RobotMode.AUTOMATIC
        self.work_mode = WorkMode.TASK
        self.localization = Localization(self.body, self.settings.located, self.report)
        self._command = Velocity()
        self._command_smooth = True
        self._command_time = -math.inf
        self._holding = True  # the base brakes after a motion; False after a commanded velocity
        self._faults = ActiveFaults()
        self.last_code = _INITIALISED if self.located else _NOT_INITIALISED

    def _free_place(self, wanted: Pose2D) -> Pose2D:
        """The free place nearest to the start, which may be inside a wall of a user's map.

        Raises:
            ValueError: The map has no free place for the robot.
        """
        grid = self.site.grid
        place = self.planner.nearest_free(wanted.x, wanted.y, math.inf)
        if place is None:
            raise ValueError(
                say(
                    "a robot of {radius} m radius finds no free place on this map of {width:.1f} x "
                    "{height:.1f} m",
                    radius=self.settings.radius,
                    width=grid.width * grid.resolution,
                    height=grid.height * grid.resolution,
                )
            )
        stays = self.planner.is_free(wanted.x, wanted.y)
        return wanted if stays else replace(wanted, x=place[0], y=place[1])

    @property
    def obstacles(self) -> list[Obstacle]:
        """The obstacles that are not on the map; the list may be changed."""
        return self.collisions.obstacles

    # -- reported states -------------------------------------------------------------------------------------

    def report(self, code: int) -> None:
        """Queue a code for /status_code."""
        self._reports.append(code)
        self._faults.receive(code)
        self.last_code = code

    def take_reports(self) -> list[int]:
        """Return and clear the queued codes."""
        reports, self._reports = self._reports, []
        return reports

    @property
    def robot_state(self) -> RobotState:
        """`robot_state` of /robot_status."""
        if not self.located:
            return RobotState.UNINITIALISED
        if self.emergency_stop or self.bumper:
            return RobotState.FAULT
        if self.tasks.busy:
            return RobotState.IN_TASK
        if self.battery.charging:
            return RobotState.CHARGING
        parked = self.tasks.task_type is TaskType.PARK and self.tasks.state is TaskState.COMPLETED
        return RobotState.PARKING if parked and self.motion is None else RobotState.IDLE

    def status(self) -> RobotStatus:
        """The content of /robot_status, without the time."""
        t = self.tasks
        return RobotStatus(
            t.task_id, t.task_type, t.state, t.action_type, t.action_state, self.robot_state, self.robot_mode,
            self.work_mode, t.wait_id, t.dest, t.message, 0,
        )  # fmt: skip

    @property
    def located(self) -> bool:
        """Whether the robot is localised."""
        return self.localization.located

    @property
    def believed_pose(self) -> Pose2D:
        """The robot's estimated pose."""
        return self.localization.pose

    # -- commands --------------------------------------------------------------------------------------------

    def command_velocity(self, velocity: Velocity, *, smooth: bool) -> None:
        """Handle a message of /smooth_cmd_vel or /base_cmd_vel."""
        if not all(map(math.isfinite, (velocity.vx, velocity.vy, velocity.wz))):
            self.report(140801000091)
            return
        self._command = velocity
        self._command_smooth = smooth
        self._command_time = self.time
        self._holding = self._holding and velocity.is_standing(0.0, 0.0)

    def navigate(
        self, owner: str, target: Sequence[Pose2D], *, keep_path: bool = False, point_by_point: bool = False
    ) -> Motion:
        """Drive to the last pose of `target`, with `keep_path` over the others; return the motion."""
        path = [self.body.pose, *target] if keep_path else self.avoidance.way_to(target[-1])
        motion = PathMotion(owner, path or [target[-1]], self._speed(), point_by_point=point_by_point)
        motion.clear = partial(self.collisions.is_clear, more=0.03)
        refused = self.cannot_move()
        if refused or path is None:
            motion.end(MotionState.FAILED, refused or 130101000021)
            self.report(motion.code)
            return motion
        self.report(130104000000)
        self._start(motion)
        return motion

    def _speed(self) -> float:
        return self.navigation.max_speed if self.navigation.max_speed > 0 else self.settings.navigation_speed

    def step_control(self, steps: Sequence[Step], *, avoid: bool) -> Motion:
        """Start a list of steps."""
        motion = StepMotion(steps, avoid=avoid)
        refused = self.cannot_move(needs_location=False)
        if not refused and (not steps or not all(map(self._reachable, steps))):
            refused = 120301000032
        if refused:
            motion.end(MotionState.FAILED, refused)
            self.report(refused)
        else:
            self._start(motion)
        return motion

    def _reachable(self, step: Step) -> bool:
        sideways = abs(step.direction().vy) > 1e-6
        return step.in_range and (self.body.limits.omnidirectional or not sideways)

    def pause_step(self) -> bool:
        """Pause the running step goal; the rest is kept for `resume_step`."""
        if not isinstance(self.motion, StepMotion):
            return self.paused_step is not None
        self.motion.pause()
        self.paused_step, self.motion = self.motion, None
        return True

    def resume_step(self, steps: Sequence[Step], *, avoid: bool) -> Motion | None:
        """Resume after a pause: with the given steps, or without any, with the rest of the paused ones."""
        paused, self.paused_step = self.paused_step, None
        if paused is None:
            return None
        return self.step_control(steps or paused.remaining_steps(), avoid=avoid)

    def end_motion(self, motion: Motion, state: MotionState, code: int = 0) -> None:
        """End a motion."""
        motion.end(state, code)
        if self.motion is motion:
            self.motion = None
            self._brake_to_stand()

    def plan(self, start: Pose2D, goal: Pose2D, tolerance: float = 0.0) -> list[Pose2D] | None:
        """A path on the map around the obstacles of the costmaps."""
        return self.planner.plan(start, goal, self.collisions.seen_obstacles, tolerance)

    def clear_costmaps(self) -> None:
        """Remove all obstacles from the costmaps; those in sight return with the next step."""
        self.collisions.seen_obstacles = []

    def set_map(self, grid: GridMap, pose: Pose2D) -> None:
        """Set the map for localisation and planning, and the robot's pose in it. The real walls do not
        change."""
        self.map_seen = grid
        self.planner = Planner(grid, self.settings.radius, _CLEARANCE)
        self.initial_pose(pose)

    def initial_pose(self, pose: Pose2D) -> bool:
        """Localise from a pose hint; see `Localization.apply_pose_hint`."""
        return self.localization.apply_pose_hint(pose)

    def run_localization(self, on: bool) -> None:
        """Start or stop the localisation, for /start_localization."""
        if on:
            self.localization.start()
        elif self.localization.running:
            self.lose_localization()
            self.localization.running = False

    # -- events of the robot ---------------------------------------------------------------------------------

    def press_emergency_stop(self) -> None:
        """Stop everything at once; the task fails (assumed)."""
        self.emergency_stop = True
        self.report(_ESTOP)
        self._abort_all(_ESTOP, "emergency stop")

    def release_emergency_stop(self) -> None:
        """Release the emergency stop; nothing resumes by itself."""
        self.emergency_stop = False
        self.report(_ESTOP_RELEASED)

    def lose_localization(self) -> None:
        """Lose the localisation; navigation and tasks fail."""
        self.localization.lose()
        if self.motion is not None and self.motion.owner != "step":
            self.end_motion(self.motion, MotionState.FAILED, _LOST)
        self.tasks.fail("localisation lost")

    def set_mode(self, mode: RobotMode) -> None:
        """Turn the key switch of the robot."""
        self.robot_mode = mode
        codes = {
            RobotMode.AUTOMATIC: 140802000051,
            RobotMode.MANUAL: 140802000061,
            RobotMode.MAINTENANCE: 140802000071,
        }
        self.report(codes.get(mode, 140802000041))
        if mode is not RobotMode.AUTOMATIC:
            self._abort_all(140801000081, "switched to manual")

    def plug_cable(self, plugged: bool = True) -> None:
        """Plug the charging cable in or out. With the cable the robot does not drive, and motions fail
        (assumed)."""
        self.cable_plugged = plugged
        if plugged:
            self._abort_all(140801000261, "charging cable plugged in")
        self.battery.charging, self.battery.automatic = plugged, False

    def enter_dock(self) -> None:
        """Dock at a charger and charge."""
        self.docked = self.battery.charging = self.battery.automatic = True
        self.report(140501000000)

    def leave_dock(self) -> None:
        """Leave the charger."""
        if self.docked:
            self.docked = self.battery.charging = False

    def release_bumper(self) -> None:
        """Release the bumper after a collision."""
        self.bumper = False
        self.report(_BUMPER_RELEASED)

    def interrupt(self, why: str) -> None:
        """End what is under way, because somebody has taken hold of the robot."""
        self._abort_all(_LOST, why)

    def reset(self) -> None:
        """Power up again after `interrupt`, and report the end of every fault; the time goes on."""
        for fault in self._faults.active:
            self.report(fault.code - fault.code % 1_000_000)  # what is normal again in its submodule
        self._power_up()
        self.report(self.last_code)

    def teleport(self, x: float, y: float, yaw: float | None = None) -> None:
        """Carry the robot to a place (m and rad in the map) and localise it; what is under way fails.

        Raises:
            ValueError: A number is not finite, or the robot would touch something there.
        """
        pose = Pose2D(x, y, self.body.pose.yaw if yaw is None else yaw).require_sensible()
        if self.collisions.touches(pose.x, pose.y):
            where = "x {x:g}, y {y:g} (with the robot's radius of {radius:g} m)"
            place = say(where, x=x, y=y, radius=self.settings.radius)
            raise ValueError(not_free(place, self.site.grid))
        self.interrupt("carried to another place")
        self.leave_dock()
        if self.bumper:
            self.release_bumper()
        self.body.block()
        self.body.pose = pose
        self.localization.running = True
        self.initial_pose(pose)

    def _abort_all(self, code: int, why: str) -> None:
        self._command = Velocity()
        if self.motion is not None:
            self.end_motion(self.motion, MotionState.FAILED, code)
        self.paused_step = None
        self.tasks.fail(why)

    # -- time ------------------------------------------------------------------------------------------------

    def step(self, dt: float) -> None:
        """Advance by `dt` simulated seconds, at most 0.05."""
        self.time += dt
        if self.costmaps_enabled:
            self.collisions.update_seen(self.body.pose)
        wanted, hard = self._next_velocity(dt)
        self.body.approach(wanted, dt, hard=hard)
        self._move(dt)
        if self.motion is not None:
            self.motion.update(self.body, dt)
            if self.motion.state.is_final:
                self._finish_motion(self.motion)
        elif self.paused_step is not None:
            self.paused_step.coast(self.body, dt)
        self.battery.step(dt, self.body.velocity)
        self.tasks.step(dt)

    def _next_velocity(self, dt: float) -> tuple[Velocity, bool]:
        if self.emergency_stop or self.bumper:
            return Velocity(), True
        commanded = self._active_command()
        # A new velocity overrides a motion ("bypasses state limits").
        fresh = self.time - self._command_time < 0.5 and not commanded.is_standing(0.0, 0.0)
        if fresh or (self.motion is None and not self._holding):
            return commanded, not self._command_smooth
        if self.motion is None or self.motion.state is not MotionState.RUNNING:
            return Velocity(), not (self._command_smooth and self.avoidance.leaves_room(Velocity(), dt))
        return self.avoidance.velocity(self.motion, dt)

    def _active_command(self) -> Velocity:
        silent = self.time - self._command_time > self.settings.silence_seconds
        if silent and self.settings.on_silence == "stop":
            return Velocity()
        return self._command

    def _move(self, dt: float) -> None:
        there = self.body.moved(dt)
        moving = not self.body.velocity.is_standing(0.0, math.inf)
        if moving and self.collisions.touches(there.x, there.y):
            if not self.collisions.touches(self.body.pose.x, self.body.pose.y) or not self.bumper:
                self.bumper = True
                self.report(_BUMPER)
                self._abort_all(_BUMPER, "bumper")
            self.body.block()
            return
        self.body.advance(dt)

    def _start(self, motion: Motion) -> None:
        if self.motion is not None:
            self.end_motion(self.motion, MotionState.REPLACED, 120301000202)
        self.paused_step = None
        self._command = Velocity()
        self.leave_dock()
        self.motion = motion

    def _finish_motion(self, motion: Motion) -> None:
        self.motion = None
        self._brake_to_stand()
        if isinstance(motion, PathMotion) and motion.state is MotionState.DONE:
            motion.code = _NAV_REACHED
        if motion.code:
            self.report(motion.code)

    def _brake_to_stand(self) -> None:
        self._command = Velocity()
        self._command_smooth = self._holding = True

    def cannot_move(self, *, needs_location: bool = True) -> int:
        """The code of why the robot cannot move now; 0 if it can."""
        if self.emergency_stop:
            return _ESTOP
        if self.bumper:
            return _BUMPER
        if self.robot_mode is not RobotMode.AUTOMATIC:
            return 140801000081
        if self.cable_plugged:
            return 140801000261
        return 140201000022 if needs_location and not self.located else 0
