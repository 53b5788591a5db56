"""Motion by goals: tasks to marks, navigation to poses, precise steps. Each verb returns a handle at once."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from rosproto.coercion import as_float, require_number
from rosproto.logs import get_logger
from rosproto.sentence import say
from woosh_pure.components import Components
from woosh_pure.enums import Direction, ExecutionMode, StepMode, TaskType
from woosh_pure.geometry import Pose2D
from woosh_pure.hints import usage
from woosh_pure.motion.action_goal import NavigationHandle, StepHandle, start_navigation, start_steps
from woosh_pure.motion.steps import Step, radians_of
from woosh_pure.motion.task import TaskHandle, TaskOptions, TaskOrder, start_task
from woosh_pure.values.messages import as_pose

if TYPE_CHECKING:
    from typing_extensions import Unpack


_log = get_logger("woosh_pure.motion")


def _is_in_radians(degrees: float) -> bool:
    """Whether so many rad are one turn at most, and whole degrees (pi / 2) or these rounded (1.57)."""
    turned = abs(math.degrees(degrees))
    if round(degrees, 1) != degrees == round(degrees, 3):  # two or three decimals: about 15, 30, 45 ...
        return 7.0 < turned < 360.4 and abs(math.remainder(turned, 15.0)) < 0.35
    return 0.0 < turned < 360.01 and abs(math.remainder(turned, 1.0)) < 0.001


class MotionVerbs:
    """The part of `Chassis` that moves the robot under the chassis's own protection."""

    _components: Components

    # -- tasks -----------------------------------------------------------------------------------------------

    @usage("go_to_mark(name), or go_to(x, y, yaw) for a place in m and rad")
    def go_to_mark(
        self, mark: str, *, timeout: float | None = 300.0, check: bool = True, replace: bool = False
    ) -> TaskHandle:
        """Drive to a mark of the map (`/exec_task`, task type pick). Returns at once; `.wait()` for the
        arrival.

        Args:
            mark: Its name, as on the chassis's own map; marks cannot be listed over this interface.
            timeout: Default of the handle's `wait()`, s; None for ever.
            check: False sends it even when the known state speaks against moving.
            replace: True ends what this Chassis has under way that moves the base; it ends as replaced.

        Raises:
            MotionRefused: Not ready, another motion of this Chassis is under way, or the chassis refused.
            StaleState: `/robot_status` has no publisher: the end could not be seen.
            ValueError: The mark is empty, or `timeout` is not a time.
            ConnectionLost, RosTimeout, ServiceError: The chassis did not answer; a task that it may have
                begun was cancelled if possible.
        """
        return self.task(TaskType.PICK, mark, timeout=timeout, check=check, replace=replace)

    def task(
        self,
        task_type: TaskType,
        mark: str = "",
        *,
        poses: Sequence[Pose2D] = (),
        direction: Direction = Direction.UNDEFINED,
        type_number: int = 0,
        custom: int = 0,
        timeout: float | None = 300.0,
        check: bool = True,
        replace: bool = False,
    ) -> TaskHandle:
        """Run a task (`/exec_task`). Returns at once.

        Args:
            task_type: Pick, park, charge or carry.
            mark: Target mark; optional when poses are given.
            poses: The path, in the map, m and rad; with a single pose the chassis plans the path itself. With
                a mark the path must end there.
            direction: Load or unload, for carrying.
            type_number: A number of your own project.
            custom: A byte of your own project, -128 to 127.
            timeout: Default of the handle's `wait()`, s; None for ever.
            check: False sends it even when the known state speaks against moving.
            replace: True ends what this Chassis has under way that moves the base; it ends as replaced.

        Raises:
            MotionRefused: Not ready, another motion of this Chassis is under way, or the chassis refused;
                `error.readiness` says why.
            StaleState: The end could not be seen.
            ValueError: A number is not finite or out of range, or there is no target.
            ConnectionLost, RosTimeout, ServiceError: The chassis did not answer; a task that it may have
                begun was cancelled if possible.
        """
        way = [as_pose(pose).require_sensible() for pose in poses]
        order = TaskOrder(TaskType(task_type), mark, way, Direction(direction), type_number, custom)
        return start_task(self._components, order, timeout=timeout, check=check, replace=replace)

    def park(self, mark: str, **options: Unpack[TaskOptions]) -> TaskHandle:
        """Drive to a parking mark (`/exec_task`, task type park). Returns at once.

        Args:
            mark: Its name, as on the chassis's own map.
            options: `poses`, `type_number`, `custom`, `timeout`, `check` and `replace`: as for `task`, with
                its units and frames.

        Raises:
            MotionRefused: Not ready, another motion of this Chassis is under way, or the chassis refused.
            StaleState: The end could not be seen.
            ValueError: A number is not finite or out of range, or there is no target.
            ConnectionLost, RosTimeout, ServiceError: The chassis did not answer.
        """
        return self.task(TaskType.PARK, mark, direction=Direction.UNDEFINED, **options)

    def charge(self, mark: str, **options: Unpack[TaskOptions]) -> TaskHandle:
        """Drive to a charger and charge (`/exec_task`, task type charge). Returns at once.

        Args:
            mark: Its name, as on the chassis's own map.
            options: `poses`, `type_number`, `custom`, `timeout`, `check` and `replace`: as for `task`, with
                its units and frames.

        Raises:
            MotionRefused: Not ready, another motion of this Chassis is under way, or the chassis refused.
            StaleState: The end could not be seen.
            ValueError: A number is not finite or out of range, or there is no target.
            ConnectionLost, RosTimeout, ServiceError: The chassis did not answer.
        """
        return self.task(TaskType.CHARGE, mark, direction=Direction.UNDEFINED, **options)

    def carry(self, mark: str, direction: Direction, **options: Unpack[TaskOptions]) -> TaskHandle:
        """Drive to a mark and load or unload there (`/exec_task`, task type carry). Returns at once.

        Args:
            mark: Its name, as on the chassis's own map.
            direction: Load or unload.
            options: `poses`, `type_number`, `custom`, `timeout`, `check` and `replace`: as for `task`, with
                its units and frames.

        Raises:
            MotionRefused: Not ready, another motion of this Chassis is under way, or the chassis refused.
            StaleState: The end could not be seen.
            ValueError: A number is not finite or out of range, or there is no target.
            ConnectionLost, RosTimeout, ServiceError: The chassis did not answer.
        """
        return self.task(TaskType.CARRY, mark, direction=direction, **options)

    # -- navigation ------------------------------------------------------------------------------------------

    @usage("go_to(x, y, yaw) in m and rad; go_to_mark(name) for a mark, follow(pose) for a Pose2D")
    def go_to(
        self,
        x: float,
        y: float,
        yaw: float = 0.0,
        *,
        frame: str = "map",
        timeout: float | None = 300.0,
        check: bool = True,
        replace: bool = False,
    ) -> NavigationHandle:
        """Drive to a pose (`/move_base`). Returns at once.

        Args:
            x: m, in `frame`.
            y: m, in `frame`.
            yaw: Final heading, rad.
            frame: The map, or another frame the chassis knows a transform of.
            timeout: Default of the handle's `wait()`, s; None for ever.
            check: False sends it even when the known state speaks against moving.
            replace: True ends what this Chassis has under way that moves the base; it ends as replaced.

        Raises:
            MotionRefused: Not ready, or a velocity block or another motion of this Chassis is under way.
            RosTimeout: The action server is not there.
            ValueError: A number is not finite, or the yaw is more than one turn.
        """
        return self.follow([Pose2D(x, y, yaw, frame)], timeout=timeout, check=check, replace=replace)

    def follow(
        self,
        path: Sequence[Pose2D] | Pose2D,
        *,
        point_by_point: bool = False,
        timeout: float | None = 300.0,
        check: bool = True,
        replace: bool = False,
    ) -> NavigationHandle:
        """Drive along a path to its last pose (`/move_base`). Returns at once.

        Args:
            path: Poses in the map, m and rad; with a single one the chassis plans the path itself.
            point_by_point: Stop at every point instead of passing through.
            timeout: Default of the handle's `wait()`, s; None for ever.
            check: False sends it even when the known state speaks against moving.
            replace: True ends what this Chassis has under way that moves the base; it ends as replaced.

        Raises:
            MotionRefused: Not ready, or a velocity block or another motion of this Chassis is under way.
            RosTimeout: The action server is not there.
            ValueError: The path is empty, a number is not finite, or a yaw is more than one turn.
            FirmwareLimit: The chassis's definition does not know `point_by_point`; nothing was sent.
        """
        path = [path] if isinstance(path, Pose2D) else path
        if not path:
            raise ValueError("the path is empty; give at least the target pose")
        path = [*map(as_pose, path)]
        mode = ExecutionMode.POINT_BY_POINT if point_by_point else ExecutionMode.FREE
        return start_navigation(
            self._components, path, mode=mode, timeout=timeout, check=check, replace=replace
        )

    # -- precise moves ---------------------------------------------------------------------------------------

    @usage("move(metres), or rotate(angle, degrees=True); `velocity` for a speed that you hold")
    def move(
        self,
        distance: float,
        *,
        speed: float = 0.0,
        avoid: bool = True,
        timeout: float | None = None,
        check: bool = True,
        replace: bool = False,
    ) -> StepHandle:
        """Drive straight by `distance` (`/cmd_vel_control`). Returns at once.

        Args:
            distance: m along x of base_link, forward positive; at most 10 m.
            speed: m/s; 0 takes the chassis's 0.2 m/s.
            avoid: False switches the obstacle avoidance of this move off.
            timeout: Default of the handle's `wait()`, s; None derives it from way and speed.
            check: False sends it even when the known state speaks against moving.
            replace: True ends what this Chassis has under way that moves the base; it ends as replaced.

        Raises:
            MotionRefused: Not ready, or a velocity block or another motion of this Chassis is under way.
            ValueError: Not finite, 0, too far, or too fast.
            FirmwareLimit: The chassis's definition does not know this kind of step; nothing was sent.
            RosTimeout: The action server is not there.
        """
        step = Step.straight(distance, speed)
        return self.steps(step, avoid=avoid, timeout=timeout, check=check, replace=replace)

    @usage("rotate(angle, degrees=True), left(degrees) or right(degrees), rotate(angle) in rad")
    def rotate(
        self,
        angle: float,
        *,
        degrees: bool = False,
        speed: float = 0.0,
        several_turns: bool = False,
        avoid: bool = True,
        timeout: float | None = None,
        check: bool = True,
        replace: bool = False,
    ) -> StepHandle:
        """Turn in place by `angle`, counter-clockwise positive (`/cmd_vel_control`). Returns at once.

        Args:
            angle: rad, or degrees with `degrees=True`; at most 62.8318 rad.
            degrees: Whether `angle` is in degrees.
            speed: rad/s (always); 0 takes the chassis's 0.1 rad/s.
            several_turns: Required for more than one turn in rad: `rotate(90)` is usually meant in degrees.
            avoid: False switches the obstacle avoidance of this move off.
            timeout: Default of the handle's `wait()`, s; None derives it from angle and speed.
            check: False sends it even when the known state speaks against moving.
            replace: True ends what this Chassis has under way that moves the base; it ends as replaced.

        Raises:
            ValueError: Not finite, 0, too far, or more than a turn in rad without `several_turns`.
            MotionRefused: Not ready, or a velocity block or another motion of this Chassis is under way.
            FirmwareLimit: The chassis's definition does not know this kind of step; nothing was sent.
            RosTimeout: The action server is not there.
        """
        step, many = Step.turn(radians_of(angle) if degrees else angle, speed), several_turns or degrees
        if degrees and _is_in_radians(as_float(angle)):
            text = "if {degrees:.0f}° was meant: left and right take degrees, rotate(angle) rad"
            _log.warning("! %s: %s", str(step), say(text, degrees=math.degrees(angle)))
        return self.steps(
            step, avoid=avoid, timeout=timeout, several_turns=many, check=check, replace=replace
        )

    @usage("forward(metres), with a decimal point; forward(metres, speed=number) in m/s")
    def forward(self, metres: float, *, speed: float = 0.0) -> StepHandle:
        """`move`: drive straight, or back where `metres` is negative; speed in m/s. Returns at once."""
        return self.move(metres, speed=speed)

    @usage("left(degrees); left(degrees, speed=number) in rad/s")
    def left(self, degrees: float, *, speed: float = 0.0) -> StepHandle:
        """`rotate`: turn in place to the left, in degrees; speed in rad/s. Returns at once."""
        return self.rotate(degrees, degrees=True, speed=speed)

    @usage("right(degrees); right(degrees, speed=number) in rad/s")
    def right(self, degrees: float, *, speed: float = 0.0) -> StepHandle:
        """`rotate`: turn in place to the right, in degrees; speed in rad/s. Returns at once."""
        return self.rotate(-require_number(degrees, "degrees"), degrees=True, speed=speed)

    @usage("strafe(metres), to the left; strafe(metres, speed=number) in m/s")
    def strafe(
        self,
        distance: float,
        *,
        speed: float = 0.0,
        avoid: bool = True,
        timeout: float | None = None,
        check: bool = True,
        replace: bool = False,
    ) -> StepHandle:
        """Move sideways by `distance` (`/cmd_vel_control`); only omnidirectional bases can, others fail the
        goal. Returns at once.

        Args:
            distance: m along y of base_link, left positive; at most 10 m.
            speed: m/s; 0 takes the chassis's 0.2 m/s.
            avoid: False switches the obstacle avoidance of this move off.
            timeout: Default of the handle's `wait()`, s; None derives it from way and speed.
            check: False sends it even when the known state speaks against moving.
            replace: True ends what this Chassis has under way that moves the base; it ends as replaced.

        Raises:
            MotionRefused: Not ready, or a velocity block or another motion of this Chassis is under way.
            ValueError: Not finite, 0, too far, or too fast.
            FirmwareLimit: The chassis's definition does not know this kind of step; nothing was sent.
            RosTimeout: The action server is not there.
        """
        step = Step.lateral(distance, speed)
        return self.steps(step, avoid=avoid, timeout=timeout, check=check, replace=replace)

    def move_diagonal(
        self,
        distance: float,
        angle: float,
        *,
        degrees: bool = False,
        speed: float = 0.0,
        avoid: bool = True,
        timeout: float | None = None,
        check: bool = True,
        replace: bool = False,
    ) -> StepHandle:
        """Move in a direction without turning (`/cmd_vel_control`); only omnidirectional bases can,
        others fail the goal. Returns at once.

        Args:
            distance: m, in base_link; at most 10 m.
            angle: Direction in rad (or degrees), left of forward positive.
            degrees: Whether `angle` is in degrees.
            speed: m/s; 0 takes the chassis's 0.2 m/s.
            avoid: False switches the obstacle avoidance of this move off.
            timeout: Default of the handle's `wait()`, s; None derives it from way and speed.
            check: False sends it even when the known state speaks against moving.
            replace: True ends what this Chassis has under way that moves the base; it ends as replaced.

        Raises:
            MotionRefused: Not ready, or a velocity block or another motion of this Chassis is under way.
            ValueError: Not finite, 0, too far, or too fast.
            FirmwareLimit: The chassis's definition does not know this kind of step; nothing was sent.
            RosTimeout: The action server is not there.
        """
        toward = math.radians(require_number(angle, "angle")) if degrees else angle
        step = Step.diagonal(distance, toward, speed)
        return self.steps(step, avoid=avoid, timeout=timeout, check=check, replace=replace)

    def steps(
        self,
        steps: Iterable[Step] | Step,
        *,
        avoid: bool = True,
        timeout: float | None = None,
        several_turns: bool = False,
        check: bool = True,
        replace: bool = False,
    ) -> StepHandle:
        """Several precise moves as one goal (`/cmd_vel_control`). Returns at once.

        Args:
            steps: In order; m, rad, m/s, rad/s, in base_link (forward, left, counter-clockwise positive).
            avoid: False switches the obstacle avoidance off for all of them.
            timeout: Default of the handle's `wait()`, s; None derives it from distances and speeds.
            several_turns: Required for a step of more than one turn: such an angle is usually in degrees.
            check: False sends it even when the known state speaks against moving.
            replace: True ends what this Chassis has under way that moves the base; it ends as replaced.

        Raises:
            ValueError: Not finite, too far, too fast, more than a turn, or no steps.
            MotionRefused: Not ready, or a velocity block or another motion of this Chassis is under way.
            FirmwareLimit: The chassis's definition does not know this kind of step; nothing was sent.
            RosTimeout: The action server is not there.
        """
        steps = (steps,) if isinstance(steps, Step) else tuple(steps)
        turns = [step.data for step in steps if isinstance(step, Step) and step.mode is StepMode.ROTATE]
        if not several_turns and any(abs(turn) > 2.0 * math.pi + 1e-6 for turn in turns):
            raise ValueError(
                say(
                    "{max:.2f} rad is more than one turn; for degrees, pass degrees=True, for many turns "
                    "say several_turns=True",
                    max=max(turns, key=abs),
                )
            )
        return start_steps(
            self._components, tuple(steps), avoid=avoid, timeout=timeout, check=check, replace=replace
        )
