"""The action /tf2_web_republisher: transforms for web clients that have no tf of their own.

ROSLIB.TFClient sends it the frames that it wants, and gets as feedback those that have moved; tf itself, at
full rate and with every frame, is too much for a phone. A goal moves nothing: it may be sent without a write
pattern.

Source: tf2_web_republisher (tf_web_republisher.cpp): which transform is looked up, and when it is sent again.
"""

from __future__ import annotations

import math
import threading
from typing import TYPE_CHECKING, Any

from rosproto.action import ActionServer
from rosproto.bounded_cache import BoundedCache
from rosproto.tf import TransformError, TransformListener
from rosproto.tf.buffer import frame_name

if TYPE_CHECKING:
    from types import TracebackType

    from rosproto.action import ServerGoal
    from rosproto.node import Node
    from rosproto.tf import Transform

__all__ = ["TfRepublisher"]

NAME = "/tf2_web_republisher"
TYPE = "tf2_web_republisher/TFSubscriptionAction"
MOST_GOALS = 64
MOST_REMEMBERED = 1000  # goals of clients that have left
MOST_FRAMES = 500  # of one goal
HIGHEST_RATE = 100.0  # Hz


class TfRepublisher:
    """Provides the action; close it, or the node.

    A goal goes on until it is cancelled. A web page that is closed cancels nothing, so the gateway tells
    which client sent which goal (`sent`), and when that one has left (`gone`).

    Args:
        node: Subscribes /tf and /tf_static, and provides the action.

    Raises:
        MasterError, ConnectionLost, RosTimeout: As `Node.publisher`.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._lock = threading.Lock()
        self._clients: dict[object, set[str]] = {}
        self._left: BoundedCache[str, bool] = BoundedCache(MOST_REMEMBERED)
        self._listener = TransformListener(node)
        try:
            self._server = ActionServer(
                node, NAME, TYPE, self._serve, concurrent=True, check=_problem, most_goals=MOST_GOALS
            )
        except BaseException:
            self._listener.close()
            raise

    def __enter__(self) -> TfRepublisher:
        return self

    def __exit__(
        self,
        error_type: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """End all goals and the subscriptions; may be called twice."""
        self._server.close()
        self._listener.close()

    @staticmethod
    def owns(name: str) -> bool:
        """True for the action, and the topics on which its clients publish."""
        return name in (NAME, f"{NAME}/goal", f"{NAME}/cancel")

    def sent(self, client: object, goal_id: str) -> None:
        """A client of the gateway sends a goal with this id; said before the goal is published."""
        with self._lock:
            ids = self._clients.setdefault(client, set())
            if len(ids) >= MOST_GOALS:  # most have ended by now
                ids.intersection_update(goal.id for goal in self._server.goals)
            ids.add(goal_id)

    def gone(self, client: object) -> None:
        """It has left: its goals end, one that is still on its way here, too."""
        with self._lock:
            ids = self._clients.pop(client, set())
        for goal_id in ids:
            self._left.put(goal_id, True)

    def _serve(self, goal: ServerGoal) -> None:
        sending = _Sending(goal.goal.angular_thres, goal.goal.trans_thres)
        target, sources = frame_name(goal.goal.target_frame), list(map(frame_name, goal.goal.source_frames))
        period = 1.0 / goal.goal.rate
        while not self._ended(goal, period):
            transforms = [self._message(found) for found in sending.due(self._looked_up(target, sources))]
            if transforms:
                goal.publish_feedback({"transforms": transforms})
        goal.preempted()

    def _ended(self, goal: ServerGoal, period: float) -> bool:
        return goal.wait_for_cancel(period) or self._left.get(goal.id) is not None

    def _looked_up(self, target: str, sources: list[str]) -> list[Transform]:
        found = []
        for source in sources:
            try:
                found.append(self._listener.buffer.lookup(target, source))
            except TransformError:
                continue  # not yet, or not any more: it is sent when it can be had
        return found

    def _message(self, transform: Transform) -> Any:
        message = transform.to_message()
        message.header.stamp = self._node.clock.now()
        return message


class _Sending:
    """Which transforms have moved since they were sent last."""

    def __init__(self, angle: float, distance: float) -> None:
        self._angle = angle
        self._distance = distance
        self._sent: dict[str, Transform] = {}

    def due(self, transforms: list[Transform]) -> list[Transform]:
        moved = [found for found in transforms if self._moved(found)]
        for transform in moved:
            self._sent[transform.source] = transform
        return moved

    def _moved(self, now: Transform) -> bool:
        before = self._sent.get(now.source)
        if before is None:
            return True
        along = abs(sum(a * b for a, b in zip(before.rotation, now.rotation, strict=True)))
        angle = 2.0 * math.acos(min(1.0, along))
        return math.dist(before.translation, now.translation) > self._distance or angle > self._angle


def _problem(goal: Any) -> str | None:
    """Why a goal is not taken; None when it is."""
    if len(goal.source_frames) > MOST_FRAMES:
        return f"{len(goal.source_frames)} frames, {MOST_FRAMES} are the most"
    if not 0.0 < goal.rate <= HIGHEST_RATE:
        return f"a rate of {goal.rate:g} Hz; expected more than 0, and {HIGHEST_RATE:g} at most"
    if not (goal.angular_thres >= 0.0 and goal.trans_thres >= 0.0):
        return "a threshold is negative, or no number"
    try:
        for name in (goal.target_frame, *goal.source_frames):
            frame_name(name)
    except ValueError as error:
        return str(error)
    return None
