"""The robot's own client of /move_base, by which /ros_interface drives its tasks.

So a task is visible on the topics of /move_base, another client's goal replaces it, and a cancel of all goals
ends it, as on the real graph (`/ros_interface` keeps a goal publisher on every action server).
"""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Sequence

from rosproto.action import GoalHandle, GoalStatus
from rosproto.errors import RosError
from rosproto.logs import get_logger
from woosh_pure.firmware.versions import Firmware
from woosh_pure.geometry import Pose2D
from woosh_pure.sim.graph import Graph
from woosh_pure.sim.motions import Motion, MotionState
from woosh_pure.values.messages import message_type, stamped_pose

logger = get_logger("woosh_pure.sim")


class NavigationMotion(Motion):
    """A motion carried out as a goal of /move_base.

    Pausing cancels the goal; resuming sends the rest of the way (assumed).
    """

    def __init__(self, client: NavigationClient, way: Sequence[Pose2D], keep_path: bool) -> None:
        super().__init__("task")
        self._client = client
        self.way = list(way)
        self.keep_path = keep_path
        self.sent = 0
        self.goal: GoalHandle | None = None

    def end(self, state: MotionState, code: int = 0) -> None:
        if not self.state.is_final:
            super().end(state, code)
            self._client.cancel(self)

    def pause(self) -> None:
        super().pause()
        self._client.cancel(self)

    def resume(self) -> None:
        super().resume()
        self._client.send(self)


class NavigationClient:
    """Sends goals and cancels in a thread, so that the world is not locked meanwhile."""

    def __init__(self, graph: Graph, firmware: Firmware, lock: threading.Condition) -> None:
        self._graph = graph
        self._firmware = firmware
        self._lock = lock
        self._todo: queue.SimpleQueue[Callable[[], object] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="woosh:simulated client", daemon=True)
        self._thread.start()

    def drive(self, way: Sequence[Pose2D], keep_path: bool) -> Motion:
        """Start to drive; called with the world locked."""
        motion = NavigationMotion(self, way, keep_path)
        self.send(motion)
        return motion

    def send(self, motion: NavigationMotion) -> None:
        """Queue sending its goal."""
        motion.sent += 1
        number = motion.sent
        self._todo.put(lambda: self._send(motion, number))

    def cancel(self, motion: NavigationMotion) -> None:
        """Queue cancelling its goal."""
        goal, motion.goal = motion.goal, None
        if goal is not None:
            self._todo.put(lambda: goal.cancel())

    def close(self) -> None:
        """End the thread."""
        self._todo.put(None)
        self._thread.join(2.0)

    def _run(self) -> None:
        while (job := self._todo.get()) is not None:
            try:
                job()
            except RosError as error:
                logger.debug("! the simulated client: %s", error)

    def _send(self, motion: NavigationMotion, number: int) -> None:
        client = self._graph.client("/move_base")
        try:
            client.wait_for_server(5.0)
        except RosError:
            with self._lock:
                motion.end(MotionState.FAILED)
            raise
        goal = message_type("woosh_msgs/MoveBaseGoal")()
        goal.target_pose = stamped_pose(motion.way[-1])
        goal.poses = [stamped_pose(pose) for pose in motion.way] if motion.keep_path else []
        with self._lock:
            if motion.state is not MotionState.RUNNING or number != motion.sent:
                return  # paused or ended before it was sent
        handle = client.send_goal(
            self._firmware.convert(goal, client.type.goal),
            transition=lambda state: self._goal_changed(motion, number, state),
            feedback=lambda _, report: self._drop_passed(motion, int(report.nav_state)),
        )
        with self._lock:
            if motion.state is MotionState.RUNNING and number == motion.sent:
                motion.goal = handle
                return
        handle.cancel()  # paused or ended while it was sent

    def _drop_passed(self, motion: NavigationMotion, left: int) -> None:
        # nav_state of the simulated /move_base is the number of remaining points.
        if motion.keep_path and 0 < left < len(motion.way):
            with self._lock:
                motion.way = motion.way[-left:]

    def _goal_changed(self, motion: NavigationMotion, number: int, goal: GoalHandle) -> None:
        if not goal.done:
            return
        with self._lock:
            if number != motion.sent or motion.state is not MotionState.RUNNING:
                return
            motion.goal = None
            if goal.status is GoalStatus.SUCCEEDED:
                motion.end(MotionState.DONE)
            elif goal.status is GoalStatus.PREEMPTED or "replaced" in goal.text:
                motion.end(MotionState.REPLACED)
            else:
                motion.end(MotionState.FAILED)
