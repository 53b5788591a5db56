"""Goals of action servers: motions, handles, and the functions that send navigation and step goals."""

from __future__ import annotations

import functools
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any

import rosproto
from rosproto.action import GoalHandle as SentGoal
from rosproto.codec import DynamicMessage
from rosproto.errors import ConnectionLost, RosError
from rosproto.logs import get_logger
from rosproto.sentence import both, say
from rosproto.transport import Deadline
from woosh_pure.components import Components
from woosh_pure.connection.connection import FinalMessage
from woosh_pure.connection.firmware_limits import require_goal
from woosh_pure.enums import ExecutionMode, StepControlMode, StepMode
from woosh_pure.errors import MotionRefused
from woosh_pure.faults import Faults, with_words
from woosh_pure.geometry import Pose2D
from woosh_pure.interface.schema import Row
from woosh_pure.motion.motion import GoalHandle, Motion
from woosh_pure.motion.progress import PlannedWay
from woosh_pure.motion.steps import Step, check_goal, check_steps, locate_step, step_goal
from woosh_pure.outcome import OutcomeKind
from woosh_pure.values.messages import message_type, require_finite, stamped_pose

logger = get_logger("woosh_pure.goal")

_TURN_SECONDS = 10.0  # seconds; a pause waits five for its answer

# actionlib_msgs/GoalStatus
_SUCCEEDED, _PREEMPTED, _ABORTED, _REJECTED, _RECALLED = 3, 2, 4, 5, 8
_NOT_BEGUN = (
    "the robot did not begin it: a newer goal came, or the last goal was from a program whose clock is "
    "ahead of the robot's, which then takes no goal until its clock has passed that one's stamp"
)


class ActionMotion(Motion[Any]):
    """A goal of any action server; its reports are the feedback messages.

    Attributes:
        result: The result message, None before the end.
    """

    def __init__(self, components: Components, name: str, goal_text: str, *, drives: bool = False) -> None:
        super().__init__(components, goal_text, server=name)
        self._drives = drives
        self._goal: SentGoal | None = None
        self._given_up: float | None = None  # when, by the monotonic clock

    @property
    def drives(self) -> bool:
        return self._drives

    def begin(
        self, message: DynamicMessage, since: int | None = None, *, check: bool = True, replace: bool = False
    ) -> None:
        """Send the goal. It is registered first, so that `stop` in another thread finds it.

        Args:
            message: The goal message.
            since: `ActiveMotions.since` of the verb; None takes its present value.
            check: False sends it even beside an open velocity block or another motion of ours.
            replace: True ends any other motion of ours.

        Raises:
            FirmwareLimit: The chassis's definition cannot express this; nothing was sent.
            MotionRefused: `stop` was called in the meantime, or another motion of ours is under way.
        """
        motions = self.components.motions
        since = motions.since if since is None else since
        client = self.components.clients.action(self.server)
        require_goal(client, message)
        cancel_job = self.cancel_job()
        start_cancel = partial(motions.executor.put, cancel_job)
        goal_id = self._new_goal_id(client)
        try:
            motions.add_goal(self, since, check=check, replace=replace)
            self.send(lambda: self._send_to(client, message, goal_id))
        except Exception as error:
            self.finish(OutcomeKind.CANCELLED, say("not sent: {error}", error=error))
            motions.forget_replacing(self)
            raise
        except BaseException:  # Ctrl-C: the handle is not returned, so the goal must be ended here
            start_cancel()  # must be first: see `stop_executor`
            motions.executor.hold(cancel_job)
            raise

    def _new_goal_id(self, client: rosproto.ActionClient) -> str:
        """Make the goal's id and register it at the watchdog before the goal is sent."""
        goal_id = client.new_goal_id()
        self.components.watchdog_client.goal(self, self.server, goal_id)
        return goal_id

    def _send_to(self, client: rosproto.ActionClient, message: DynamicMessage, goal_id: str) -> None:
        if self.asked:
            raise MotionRefused(
                say("{goal}: it was stopped before it was sent; nothing was sent", goal=self.description)
            )
        self._goal = client.send_goal(
            message, feedback=self._on_feedback, transition=self._on_transition, goal_id=goal_id
        )
        if self.asked:  # meanwhile, by a thread that did not have this goal yet
            self._goal.cancel()

    @property
    def result(self) -> Any:
        return None if self._goal is None else self._goal.result

    def _on_feedback(self, goal: SentGoal, feedback: DynamicMessage) -> None:
        self._advance(feedback)

    def _on_transition(self, *arguments: object) -> None:
        self.check()

    def request_cancel(self, timeout: float) -> None:
        self.await_sent(timeout)
        if self._goal is not None:
            self._goal.cancel()
        elif not self.being_sent:
            self.finish(OutcomeKind.CANCELLED, "it was never sent")

    def write_cancel(self) -> None:
        goal = self._goal
        if goal is not None:  # otherwise the sending thread checks `asked`
            goal.cancel_at_once()

    def cancel_confirmed(self, timeout: float) -> bool:
        # A cancel is a message: it may be sent and not arrive.
        deadline = Deadline(timeout)
        while not self._has_ended():
            if deadline.expired:
                return False
            time.sleep(0.02)
        return True

    @property
    def final_message(self) -> FinalMessage | None:
        goal = self._goal
        if goal is None:
            return None
        return FinalMessage(f"{self.server}/cancel", message_type("actionlib_msgs/GoalID")(id=goal.goal_id))

    def _has_ended(self) -> bool:
        """Whether the server has reported the end, or the goal was never sent."""
        return self._goal is None or (self._goal.done and self._cannot_arrive())

    def repeat_cancel(self) -> None:
        if self.may_go_on and self._has_ended():
            self.see_end()
        else:
            self.write_cancel()

    def _cannot_arrive(self) -> bool:
        """Whether an abandoned goal can no longer reach the chassis; known once that is heard again."""
        beat = self.components.feeds.get("velocity").known
        return self._given_up is None or (beat is not None and beat.received > self._given_up)

    def check(self) -> None:
        goal = self._goal
        if goal is None:
            return
        if self.over.is_set:
            if self.may_go_on and self._has_ended():
                self.see_end()
        elif goal.done:
            if not self._is_held(goal):
                self._settle(int(goal.status), goal.text or "", goal.result)
        elif (error := goal.connection_error) is not None:
            self.finish(OutcomeKind.CONNECTION_LOST, str(error))
            # A goal that never arrived must not begin when the network is back.
            if goal.give_up():
                self._given_up = time.monotonic()

    def _is_held(self, goal: SentGoal) -> bool:
        """Whether the end of that goal on the server is not the end of this motion."""
        return False

    def _settle(self, status: int, text: str, result: DynamicMessage) -> None:
        if status == _SUCCEEDED:
            self._succeeded(text, result)
        elif status in (_PREEMPTED, _RECALLED):
            kind = OutcomeKind.CANCELLED if self.asked else OutcomeKind.REPLACED
            if status == _RECALLED and kind is OutcomeKind.REPLACED:
                text = both(text, say(_NOT_BEGUN)) if text else say(_NOT_BEGUN)
            self.finish(kind, text, status)
        elif status == _REJECTED:
            self.finish(OutcomeKind.REJECTED, self._reason(text), status)
        elif status == _ABORTED:
            self.finish(OutcomeKind.FAILED, self._reason(text), status)
        else:
            self.finish(
                OutcomeKind.CONNECTION_LOST, text or "the action server no longer knows the goal", status
            )

    def _succeeded(self, text: str, result: DynamicMessage) -> None:
        self.finish(OutcomeKind.ARRIVED, text)

    def _reason(self, text: str) -> str:
        try:
            faults = self.components.readiness_state.active_faults()
        except ConnectionLost:  # the Chassis was closed meanwhile
            faults = Faults()
        told = [str(fault) for fault in faults if text != f"status code {fault.code}"]
        known = [with_words(text), *told] if text else told
        return both(*known) if known else ""


class ActionHandle(GoalHandle[Any]):
    """A goal of any action server; its reports are the feedback messages."""

    _motion: ActionMotion

    @property
    def result(self) -> Any:
        """The result message, None before the end."""
        return self._motion.result


class NavigationHandle(ActionHandle):
    """A goal of /move_base under way."""


def start_navigation(
    components: Components,
    path: Sequence[Pose2D],
    *,
    mode: ExecutionMode,
    timeout: float | None,
    check: bool,
    replace: bool,
) -> NavigationHandle:
    """Send a goal to /move_base: the last pose is the target, the poses before it are the path."""
    since = components.motions.since
    for pose in path:
        pose.require_sensible()
    motion = ActionMotion(components, "/move_base", say("navigation to {where}", where=path[-1]), drives=True)
    components.readiness_state.require_ready(motion.description, check)
    goal = message_type("woosh_msgs/MoveBaseGoal")()
    goal.target_pose = stamped_pose(path[-1])
    goal.poses = [stamped_pose(pose) for pose in path] if len(path) > 1 else []
    goal.execution_mode = int(mode)
    motion.way = PlannedWay(components.feeds)
    handle = NavigationHandle(motion, timeout)
    motion.begin(goal, since, check=check, replace=replace)
    return handle


def start_action(
    components: Components,
    row: Row,
    goal: DynamicMessage,
    *,
    timeout: float | None,
    check: bool,
    replace: bool,
) -> ActionHandle:
    """Send a goal of any kind; one that moves the base is checked like the motion verbs."""
    since = components.motions.since
    described = say("goal of {action}", action=row.name)
    require_finite(goal, described)
    if getattr(goal, "stepControl", ()):
        check_goal(goal)
    if row.moves_base:
        components.readiness_state.require_ready(described, check)
    motion = ActionMotion(components, row.name, described, drives=row.moves_base)
    handle = ActionHandle(motion, timeout)
    motion.begin(goal, since, check=check, replace=replace)
    return handle


class _Part:
    """What one goal of a step move has to do: the whole move, or what remained of it after a pause.

    Feedback of an earlier part may be called back after the next one was sent, so each has its own progress.

    Attributes:
        steps: Its steps.
        done_before: Percent of the whole that was done before it.
        place: Index and percent of the step under way; one value, so that no lock is needed.
        goal_id: The id of its goal.
    """

    def __init__(self, steps: tuple[Step, ...], done_before: float = 0.0) -> None:
        self.steps, self.done_before = steps, done_before
        self.place = (0, 0.0)
        self.goal_id = ""

    def overall(self) -> float:
        """Percent of the whole move that is done, with equal weight for each step."""
        index, percent = self.place
        share = (index * 100.0 + percent) / len(self.steps)
        return self.done_before + (100.0 - self.done_before) * share / 100.0

    def remaining(self) -> _Part:
        """The part that remains of it."""
        index, percent = self.place
        steps = (self.steps[index].rest(percent), *self.steps[index + 1 :])
        return _Part(steps, self.overall())


class StepMotion(ActionMotion):
    """A goal of /cmd_vel_control, or several: after a pause, what remains is sent as another one."""

    def __init__(self, components: Components, steps: tuple[Step, ...], avoid: bool) -> None:
        super().__init__(components, "/cmd_vel_control", _in_a_row(steps))
        components.feeds.get("pose").open()
        self._part = _Part(steps)
        self._avoid = avoid
        # The goal that a pause of ours ends on the server. It is noted before the pause is sent, so whoever
        # sees that end sees this as well.
        self._held: SentGoal | None = None
        # One pause or resume at a time. No stop, cancel or wait takes it.
        self._turn = threading.Lock()

    @property
    def _paused(self) -> bool:
        return self._held is not None and self._held is self._goal

    @property
    def drives(self) -> bool:
        return not self._paused

    def _come(self, here: Pose2D | None) -> tuple[float, float]:
        left = (abs(step.data) for step in self.remaining() if step.mode is not StepMode.ROTATE)
        return self._part.overall(), sum(left)

    def _new_goal_id(self, client: rosproto.ActionClient) -> str:
        self._part.goal_id = super()._new_goal_id(client)
        return self._part.goal_id

    def _on_feedback(self, goal: SentGoal, feedback: DynamicMessage) -> None:
        part = self._part
        if goal.goal_id != part.goal_id:
            return  # of the part before a pause
        mode, percent = StepMode(feedback.executeMode), float(feedback.percent)
        part.place = locate_step(part.steps, *part.place, mode, percent)
        self._advance(feedback)

    def remaining(self) -> tuple[Step, ...]:
        """The remaining steps, by the last report."""
        return self._part.remaining().steps

    def pause(self) -> None:
        """See `StepHandle.pause`."""
        ended = say("{goal}: it has ended and cannot be paused", goal=self.description)
        with self._in_turn():
            if self.done:
                raise MotionRefused(ended)
            goal = self._held = self._goal
            try:
                client = self.components.clients.action(self.server)
                result = client.send_goal(step_goal(StepControlMode.PAUSE, (), self._avoid)).wait(5.0)
                if result.result != 1:
                    raise MotionRefused("it reports that nothing was paused")
            except RosError as error:
                self._held = None
                if self.done:  # the server reports the end before it answers the pause
                    raise MotionRefused(ended) from error
                unconfirmed = "{goal}: the chassis did not confirm the pause: {why}"
                raise MotionRefused(say(unconfirmed, goal=self.description, why=error)) from error
            # A goal that was recalled never began, and the result is of an earlier part.
            if goal is not None and int(goal.status) != _RECALLED:
                self._refine(result)

    def _refine(self, result: DynamicMessage) -> None:
        """Use the position of the pause in the chassis's result, which is more exact than the last report.

        These numbers are not documented, so they are used only if they fit the step under way.
        """
        part = self._part
        index, percent = part.place
        if int(result.executeMode) == part.steps[index].mode and percent <= result.percent < 100.0:
            part.place = (index, float(result.percent))

    def resume(self) -> None:
        """See `StepHandle.resume`."""
        with self._in_turn():
            if not self._paused:
                raise MotionRefused(say("{goal}: it is not paused", goal=self.description))
            self.components.motions.require_alone(self)
            part = self._part = self._part.remaining()
            goal = step_goal(StepControlMode.RESUME, part.steps, self._avoid)
            client = self.components.clients.action(self.server)
            goal_id = self._new_goal_id(client)
            self.send(lambda: self._send_to(client, goal, goal_id))

    @contextmanager
    def _in_turn(self) -> Iterator[None]:
        """Wait, with a time limit, until another thread's pause or resume of this move has been answered."""
        if not self._turn.acquire(timeout=_TURN_SECONDS):
            raise MotionRefused(
                say(
                    "{goal}: another pause or resume of it was not answered within {seconds:g} s",
                    goal=self.description,
                    seconds=_TURN_SECONDS,
                )
            )
        try:
            yield
        finally:
            self._turn.release()

    def _is_held(self, goal: SentGoal) -> bool:
        return goal is self._held

    def check(self) -> None:
        if not (self._paused and self.over.is_set):
            super().check()
        # A paused move does not end, unless the chassis has fallen silent: then it cannot be resumed.
        if self._paused and not self.over.is_set and (lost := self.components.feeds.lost("velocity")):
            self.finish(OutcomeKind.CONNECTION_LOST, lost)

    def request_cancel(self, timeout: float) -> None:
        paused, self._held = self._paused, None
        super().request_cancel(timeout)
        if paused:
            self.finish(OutcomeKind.CANCELLED, "cancelled while paused")

    def _succeeded(self, text: str, result: DynamicMessage) -> None:
        # Result 1 is success; negative is failure, also when actionlib calls the goal succeeded.
        code = int(result.result)
        if code == 1:
            self.finish(OutcomeKind.ARRIVED, text, code)
        else:
            failed = say("the chassis reports a failed step (result {result})", result=code)
            self.finish(OutcomeKind.FAILED, self._reason(text or failed), code)


class StepHandle(ActionHandle):
    """A goal of /cmd_vel_control under way."""

    _motion: StepMotion

    def remaining(self) -> tuple[Step, ...]:
        """The remaining steps, by the last report."""
        return self._motion.remaining()

    def pause(self) -> None:
        """Hold the move; `resume` sends what remains.

        Raises:
            MotionRefused: It has ended, perhaps while the pause was sent; or the chassis did not confirm.
        """
        self._motion.pause()

    def resume(self) -> None:
        """Go on after `pause` by sending the remaining steps again, as the interface prescribes."""
        self._motion.resume()


def _in_a_row(steps: Sequence[Step]) -> str:
    texts = [str(step) for step in steps]
    return functools.reduce(lambda a, b: say("{first}, then {second}", first=a, second=b), texts)


def start_steps(
    components: Components,
    steps: Sequence[Step],
    *,
    avoid: bool,
    timeout: float | None,
    check: bool,
    replace: bool,
) -> StepHandle:
    """Send steps to /cmd_vel_control as one goal."""
    since = components.motions.since
    checked = check_steps(steps)
    components.readiness_state.require_ready(_in_a_row(checked), check)
    expected = 15.0 + 2.0 * sum(step.expected_seconds for step in checked)
    motion = StepMotion(components, checked, avoid)
    handle = StepHandle(motion, expected if timeout is None else timeout)
    motion.begin(step_goal(StepControlMode.EXECUTE, checked, avoid), since, check=check, replace=replace)
    return handle
