"""`RosHandlers`: what the simulated chassis does for service requests, command messages and action goals."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from rosproto.codec import DynamicMessage
from woosh_pure.enums import NavigationMode, StepControlMode, StepMode, TaskCommand, TaskType
from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.maps.gridmap import grid_from_message, grid_message
from woosh_pure.motion.steps import Step
from woosh_pure.sim.avoidance import NavigationSettings
from woosh_pure.sim.message_builders import fill_plan
from woosh_pure.sim.motions import Motion, MotionState, PathMotion, StepMotion
from woosh_pure.sim.tasks import TaskRequest
from woosh_pure.values.messages import message_type, pose_of, stamped_pose

if TYPE_CHECKING:
    from woosh_pure.sim.chassis import SimulatedChassis
    from woosh_pure.sim.graph import RobotGoal

Feedback = Callable[[Motion], DynamicMessage]
Result = Callable[[bool], "DynamicMessage | None"]
_TF_CACHE, _PLANNER_PATIENCE = 10.0, 5.0  # s; defaults of tf2 and of move_base


def _why_refused(messages: Sequence[DynamicMessage], now: float) -> str:
    """Why noetic's move_base would not drive to one of these geometry_msgs/PoseStamped; "" if it would.

    Source: move_base.cpp, isQuaternionValid and goalToGlobalFrame; tf2 buffer_core.cpp, validateFrameId.

    Args:
        messages: For its target; that it is the same for each pose of a path is assumed.
        now: The robot's time.
    """
    for message in messages:
        q, frame = message.pose.orientation, message.header.frame_id
        length = q.x**2 + q.y**2 + q.z**2 + q.w**2
        if not _finite(q.x, q.y, q.z, q.w) or length < 1e-6 or 2.0 * (q.x**2 + q.y**2) / length > 1e-3:
            return "Aborting on goal because it was sent with an invalid quaternion"
        if not frame:
            return "tf2 frame_ids cannot be empty"
        if frame.startswith("/"):
            return f"Invalid argument \"{frame}\": tf2 frame_ids cannot start with a '/'"
        stamp = message.header.stamp.to_sec()
        if frame != "map" and stamp and not now - _TF_CACHE <= stamp <= now + _PLANNER_PATIENCE:
            return (
                f"Lookup would require extrapolation: {frame} is not known at time {stamp:.3f}, now {now:.3f}"
            )
    return ""


def _poses(messages: Iterable[DynamicMessage]) -> list[Pose2D]:
    return [pose_of(m.pose, m.header.frame_id) for m in messages]


def _new(type_name: str, **fields: Any) -> DynamicMessage:
    return message_type(type_name)(**fields)


def _finite(*numbers: float) -> bool:
    return all(map(math.isfinite, numbers))


class RosHandlers:
    """The handlers, called in the library's threads; each holds the world's lock briefly."""

    def __init__(self, sim: SimulatedChassis) -> None:
        self._sim = sim
        self._world = sim.world
        self.services = {
            "/exec_task": self.exec_task,
            "/start_localization": self.start_localization,
            "/move_base/enable_costmaps": self.enable_costmaps,
            "/aic_map_server/get_map": self.get_map,
            "/set_map": self.set_map,
            "/move_base/make_plan": self.make_plan,
            "/move_base/clear_costmaps": self.clear_costmaps,
            "/init_pose": self.init_pose,
            "/woosh_init": self.woosh_init,
        }
        self.topics: dict[str, Callable[[DynamicMessage], object]] = {
            "/base_cmd_vel": partial(self._velocity, smooth=False),
            "/smooth_cmd_vel": partial(self._velocity, smooth=True),
            "/key_cmd_vel": partial(self._velocity, smooth=True),
            "/initialpose": self._tell_pose,
        }
        self.actions = {
            "/move_base": self.move_base,
            "/cmd_vel_control": self.step_control,
            "/navigation_mode": self.navigation_mode,
        }
        self.checks: dict[str, Callable[[DynamicMessage], str | None]] = {}

    # -- services --------------------------------------------------------------------------------------------

    def exec_task(self, request: DynamicMessage) -> dict[str, object]:
        """/exec_task."""
        with self._sim.lock:
            way = self._in_map(request.poses)
            reply = self._world.tasks.request(
                TaskRequest(
                    TaskCommand(request.task_exect),
                    request.task_id,
                    TaskType(request.task_type),
                    request.mark_no,
                    way,
                )
            )
        # The reply may arrive after the status.
        time.sleep(self._sim.reply_delay)
        return {"success": reply.success, "message": reply.message, "statusCode": reply.code}

    def start_localization(self, request: DynamicMessage) -> dict[str, object]:
        """/start_localization."""
        with self._sim.lock:
            self._world.run_localization(bool(request.data))
        return {"success": True, "message": ""}

    def init_pose(self, request: DynamicMessage) -> dict[str, object]:
        """woosh_msgs/InitPose (its name is assumed)."""
        return {"success": self._tell_pose(request.initial_pose)}

    def woosh_init(self, request: DynamicMessage) -> dict[str, object]:
        """woosh_msgs/WooshInit (its name, and that it starts the localisation, are assumed)."""
        with self._sim.lock:
            self._world.run_localization(True)
            located = self._world.located
        return {"success": located, "message": "" if located else "position unknown"}

    def enable_costmaps(self, request: DynamicMessage) -> dict[str, object]:
        """/move_base/enable_costmaps."""
        with self._sim.lock:
            self._world.costmaps_enabled = bool(request.data)
        return {"success": True, "message": ""}

    def clear_costmaps(self, request: DynamicMessage) -> dict[str, object]:
        """/move_base/clear_costmaps."""
        with self._sim.lock:
            self._world.clear_costmaps()
        return {}

    def get_map(self, request: DynamicMessage) -> dict[str, object]:
        """/aic_map_server/get_map."""
        with self._sim.lock:
            grid = self._world.map_seen
        return {"map": grid_message(grid)}

    def set_map(self, request: DynamicMessage) -> dict[str, object]:
        """/set_map."""
        try:
            grid = grid_from_message(request.map)
            pose = pose_of(request.initial_pose.pose.pose, "map").require_finite()
        except ValueError:
            return {"success": False}
        with self._sim.lock:
            self._world.set_map(grid, pose)
        return {"success": True}

    def make_plan(self, request: DynamicMessage) -> dict[str, object]:
        """/move_base/make_plan."""
        plan = message_type("nav_msgs/Path")()
        with self._sim.lock:
            if not request.start.header.frame_id:  # as move_base: from where the robot is
                request.start = stamped_pose(self._world.believed_pose)
            # The planner takes poses of the map only (navfn_ros.cpp, makePlan).
            frames = {request.start.header.frame_id, request.goal.header.frame_id}
            known = frames == {"map"} and _finite(request.tolerance)
            ends = self._in_map([request.start, request.goal]) if known else None
            path = None if ends is None else self._world.plan(ends[0], ends[1], max(0.0, request.tolerance))
            fill_plan(path or [], plan, self._sim.now)
        return {"plan": plan}

    def _in_map(self, messages: Sequence[DynamicMessage]) -> list[Pose2D] | None:
        """The poses in the map; None if one cannot be converted. Called with the world locked."""
        poses = _poses(messages)
        if _why_refused(messages, self._sim.now):
            return None
        if not all(_finite(pose.x, pose.y, pose.yaw) for pose in poses):
            return None
        found = [self._world.localization.in_map(pose) for pose in poses]
        good = [pose for pose in found if pose is not None]
        return good if len(good) == len(poses) else None

    # -- topics ----------------------------------------------------------------------------------------------

    def _velocity(self, message: DynamicMessage, *, smooth: bool) -> None:
        velocity = Velocity(message.linear.x, message.linear.y, message.angular.z)
        with self._sim.lock:
            self._world.command_velocity(velocity, smooth=smooth)

    def _tell_pose(self, message: DynamicMessage) -> bool:
        pose = pose_of(message.pose.pose, "map")
        if not _finite(pose.x, pose.y, pose.yaw):
            return False
        with self._sim.lock:
            return self._world.initial_pose(pose)

    # -- actions ---------------------------------------------------------------------------------------------

    def move_base(self, goal: RobotGoal) -> None:
        """/move_base."""
        target, path = goal.goal.target_pose, goal.goal.poses
        with self._sim.lock:
            refused = _why_refused([target, *path], self._sim.now)
            way = self._in_map(path or [target])
        if refused or way is None:
            frames = ", ".join(sorted({pose.header.frame_id for pose in (target, *path)}))
            unknown = f"a pose is not finite, or there is no transform from {frames} to map"
            goal.abort(text=refused or unknown)
            return
        with self._sim.lock:
            motion = self._world.navigate(
                "move_base",
                way,
                keep_path=bool(path),
                point_by_point=goal.goal.execution_mode == 1,
            )
        self._run_motion(goal, motion, self._navigation_feedback, lambda ok: None)

    def _navigation_feedback(self, motion: Motion) -> DynamicMessage:
        assert isinstance(motion, PathMotion)
        where = stamped_pose(self._world.believed_pose)
        return _new("woosh_msgs/MoveBaseFeedback", base_position=where, nav_state=len(motion.path))

    def step_control(self, goal: RobotGoal) -> None:
        """/cmd_vel_control."""
        message = goal.goal
        mode = StepControlMode(message.mode)
        steps = [Step(StepMode(s.executeMode), s.data, s.speed, s.angle) for s in message.stepControl]
        good = all(_finite(s.data, s.speed, s.angle) and s.mode in tuple(StepMode) for s in steps)
        with self._sim.lock:
            motion, done = self._step_motion(mode, steps if good else [], bool(message.useAvoid))
        if motion is None:
            self._answer_step_command(goal, mode, done)
            return
        self._run_motion(goal, motion, self._step_feedback, lambda ok: self._step_result(motion, ok))

    def _answer_step_command(self, goal: RobotGoal, mode: StepControlMode, done: bool) -> None:
        """Answer a goal without motion: pause, cancel, or resume while nothing is paused."""
        result = _new("woosh_msgs/StepControlResult", result=1 if done else -1)
        if not done:
            goal.abort(result, text="nothing to do")
            return
        if mode is StepControlMode.PAUSE:
            self._describe_pause(result)
        goal.succeed(result)

    def _describe_pause(self, result: DynamicMessage) -> None:
        """Add the progress of the paused step, after the robot has stopped."""
        sim, world = self._sim, self._world
        with sim.lock:
            end = world.time + 5.0
            while not world.body.velocity.is_standing(1e-3, 1e-3) and world.time < end and not sim.closing:
                sim.lock.wait(0.1)
            if world.paused_step is not None:
                result.executeMode = int(world.paused_step.current.mode)
                result.percent = world.paused_step.percent

    def _step_motion(
        self, mode: StepControlMode, steps: list[Step], avoid: bool
    ) -> tuple[Motion | None, bool]:
        world = self._world
        if mode is StepControlMode.EXECUTE:
            return world.step_control(steps, avoid=avoid), True
        if mode is StepControlMode.PAUSE:
            return None, world.pause_step()
        if mode is StepControlMode.RESUME:
            return world.resume_step(steps, avoid=avoid), False
        if isinstance(world.motion, StepMotion):
            world.end_motion(world.motion, MotionState.CANCELLED, 120301000041)
        return None, True

    def _step_feedback(self, motion: Motion) -> DynamicMessage:
        assert isinstance(motion, StepMotion)
        mode = int(motion.current.mode)
        return _new("woosh_msgs/StepControlFeedback", feedback=1, executeMode=mode, percent=motion.percent)

    def _step_result(self, motion: Motion, ok: bool) -> DynamicMessage:
        assert isinstance(motion, StepMotion)
        mode, code = int(motion.current.mode), 1 if ok else -1
        return _new("woosh_msgs/StepControlResult", result=code, executeMode=mode, percent=motion.percent)

    def _run_motion(self, goal: RobotGoal, motion: Motion, feedback: Feedback, result: Result) -> None:
        """Wait until a motion ends or its client cancels it; cancel the motion if this fails."""
        try:
            self._wait_for_end(goal, motion, feedback, result)
        finally:
            with self._sim.lock:
                if motion.state is MotionState.RUNNING:
                    self._world.end_motion(motion, MotionState.CANCELLED)

    def _wait_for_end(self, goal: RobotGoal, motion: Motion, feedback: Feedback, result: Result) -> None:
        sim = self._sim
        last = 0.0
        while True:
            with sim.lock:
                if not motion.state.is_final and not goal.cancel_arrived() and not sim.closing:
                    sim.lock.wait(0.1)
                state, code = motion.state, motion.code
                report = feedback(motion) if time.monotonic() - last > 0.1 else None
                if goal.cancel_arrived() and not state.is_final:
                    self._preempt(motion)
                    outcome = result(False)
                    break
                if state.is_final or sim.closing:
                    outcome = result(state is MotionState.DONE)
                    break
            if report is not None:
                last = time.monotonic()
                goal.publish_feedback(report)
        if goal.cancel_arrived() and state is not MotionState.DONE:
            goal.preempted(outcome, text="preempted")
        elif state is MotionState.DONE:
            goal.succeed(outcome)
        elif state is MotionState.REPLACED:
            goal.abort(outcome, text="replaced by another command")
        else:
            goal.abort(outcome, text=f"status code {code}")

    def _preempt(self, motion: Motion) -> None:
        # A pause arrives as a new goal that preempts this one, so the remaining steps are kept.
        if isinstance(motion, StepMotion):
            if self._world.motion is motion:
                self._world.pause_step()
        else:
            self._world.end_motion(motion, MotionState.CANCELLED)

    def navigation_mode(self, goal: RobotGoal) -> None:
        """/navigation_mode."""
        message = goal.goal
        mode = NavigationMode(message.navigation_mode)
        if mode is NavigationMode.WAIT_THEN_AVOID and not message.waiting_timeout > 0.0:
            mode = NavigationMode.PRECISE_AVOIDANCE
        if not mode.known or not _finite(message.waiting_timeout, message.max_speed):
            goal.abort(_new("woosh_msgs/NavigationModeResult", result=-1), text="mode not known")
            return
        with self._sim.lock:
            self._world.navigation = NavigationSettings(mode, message.waiting_timeout, message.max_speed)
        goal.succeed(_new("woosh_msgs/NavigationModeResult", result=1))

    def accessory(self, action_type: str, goal: RobotGoal) -> None:
        """Lift, roller, tractor, docking ...: succeed after two simulated seconds (assumed)."""
        sim = self._sim
        with sim.lock:
            end = self._world.time + 2.0
            while self._world.time < end and not goal.cancel_arrived() and not sim.closing:
                sim.lock.wait(0.1)
        if goal.cancel_arrived():
            goal.preempted(_success(action_type, ok=False), text="cancelled")
        else:
            goal.succeed(_success(action_type))


def _success(action_type: str, *, ok: bool = True) -> DynamicMessage:
    """A result message with the success value of its definition (SUCCESS, or 1)."""
    result = message_type(f"{action_type}Result")()
    if hasattr(result, "result"):
        result.result = getattr(type(result), "SUCCESS", 1) if ok else -1
    return result
