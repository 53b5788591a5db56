"""`TfRepublisher` provides /tf2_web_republisher and /republish_tfs, transforms for web clients; `TfOnDemand`
starts it.

roslib's TFClient sends the wanted frames as a goal, and gets changed transforms as feedback. roslibpy calls
the service, and gets them on a topic. All of tf, at full rate, is too much for a phone. Both may be used
without a write pattern, because they move nothing.

Source: tf2_web_republisher (tf_web_republisher.cpp): which transform is looked up, and when it is sent again.
"""

from __future__ import annotations

import itertools
import math
import threading
import time
from collections.abc import Mapping

from rosproto.action import ActionServer, ServerGoal
from rosproto.bounded_cache import BoundedCache
from rosproto.codec import DynamicMessage
from rosproto.errors import MasterError, RosError
from rosproto.gateway.access import Access, Kind
from rosproto.node import Node
from rosproto.tf import Transform, TransformError, TransformListener
from rosproto.tf.buffer import frame_name

ACTION = "/tf2_web_republisher"
SERVICE = "/republish_tfs"
ACTION_TYPE = "tf2_web_republisher/TFSubscriptionAction"
KINDS: dict[str, Kind] = {
    ACTION: "action",
    f"{ACTION}/goal": "topic",
    f"{ACTION}/cancel": "topic",
    SERVICE: "service",
}
"""The names that a client writes to: the action, the topics on which it publishes, and the service."""


def is_tf_name(name: str) -> bool:
    """True for one of `KINDS`."""
    return name in KINDS


MAX_GOALS = 64
MAX_TOPICS = 64
MIN_PATIENCE, MAX_PATIENCE = 1.0, 60.0  # seconds that a topic stays without a subscriber
CLOSE_SECONDS = 2.0
MAX_REMEMBERED = 1000  # goals of clients that have left
MAX_FRAMES = 500  # of one goal
MAX_RATE_HZ = 100.0  # Hz


class TfOnDemand:
    """Allows writes to the republisher's names, and starts it. Sessions call it before they check a write.

    Args:
        node: Provides the action and the service.
        access: Whether clients may read /tf.
    """

    def __init__(self, node: Node, access: Access) -> None:
        self._node = node
        self._access = access
        self._lock = threading.Lock()
        self._republisher: TfRepublisher | None = None
        self._closed = False

    def opens(self, name: str) -> bool:
        """True for a name of the republisher, which may be written to without a pattern; starts it if needed.

        Calls the master at the first such name.

        Args:
            name: Resolved name of a topic, service or action.

        Raises:
            MasterError, ConnectionLost, RosTimeout: The master does not answer, or refuses the registration.
        """
        kind = KINDS.get(name)
        if kind is None or not self._access.shows(kind, name):
            return False
        if not self._access.shows("topic", "/tf"):
            return False
        with self._lock:
            if self._republisher is None and not self._closed and not self._is_provided():
                self._republisher = TfRepublisher(self._node)
        return True

    def _is_provided(self) -> bool:
        """Whether another node (tf2_web_republisher, another bridge) provides it."""
        if self._node.master.get_system_state().publishers.get(f"{ACTION}/status"):
            return True
        try:
            self._node.master.lookup_service(SERVICE)
        except MasterError as error:
            if error.code != -1:
                raise
            return False
        return True

    def publishes(self, client: object, name: str, message: object) -> None:
        """Called before a client's message is published on a topic."""
        republisher = self._republisher
        if republisher is None or name != f"{ACTION}/goal" or not isinstance(message, Mapping):
            return
        goal_id = message.get("goal_id")
        if isinstance(goal_id, Mapping) and isinstance(goal_id.get("id"), str):
            republisher.sent(client, goal_id["id"])

    def gone(self, client: object) -> None:
        """Called when a client has left."""
        if self._republisher is not None:
            self._republisher.gone(client)

    def close(self) -> None:
        """End it; may be called again."""
        with self._lock:
            self._closed = True
            republisher, self._republisher = self._republisher, None
        if republisher is not None:
            republisher.close()


class TfRepublisher:
    """Provides the action and the service; close it, or the node.

    A goal continues until it is cancelled. A closed web page cancels nothing, so the gateway reports which
    client sent which goal (`sent`), and when that client has left (`gone`).

    Args:
        node: Subscribes /tf and /tf_static, and provides the action.

    Raises:
        MasterError, ConnectionLost, RosTimeout: A topic could not be registered.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._lock = threading.Lock()
        self._clients: dict[object, set[str]] = {}
        self._left: BoundedCache[str, bool] = BoundedCache(MAX_REMEMBERED)
        self._topics: set[threading.Thread] = set()
        self._numbers = itertools.count()
        self._closing = threading.Event()
        self._listener = TransformListener(node)
        try:
            self._server = ActionServer(
                node, ACTION, ACTION_TYPE, self._serve, concurrent=True, check=_problem, max_goals=MAX_GOALS
            )
            kind = "tf2_web_republisher/RepublishTFs"
            self._service = node.service_server(SERVICE, kind, self._open_topic)
        except BaseException:
            self._listener.close()
            raise

    def close(self) -> None:
        """End all goals, topics and subscriptions; may be called twice."""
        self._closing.set()
        self._service.close()
        self._server.close()
        with self._lock:
            topics = list(self._topics)
        for thread in topics:
            thread.join(CLOSE_SECONDS)
        self._listener.close()

    def sent(self, client: object, goal_id: str) -> None:
        """A client of the gateway sends a goal with this id; called before the goal is published."""
        with self._lock:
            ids = self._clients.setdefault(client, set())
            if len(ids) >= MAX_GOALS:  # most have ended by now
                ids.intersection_update(goal.id for goal in self._server.goals)
            ids.add(goal_id)

    def gone(self, client: object) -> None:
        """A client has left: end its goals, also one that has not arrived yet."""
        with self._lock:
            ids = self._clients.pop(client, set())
        for goal_id in ids:
            self._left.put(goal_id, True)

    def _serve(self, goal: ServerGoal) -> None:
        sending = _Sending(goal.goal)
        while not goal.wait_for_cancel(sending.period) and self._left.get(goal.id) is None:
            transforms = self._due(sending)
            if transforms:
                goal.publish_feedback({"transforms": transforms})
        goal.preempted()

    def _open_topic(self, request: DynamicMessage) -> dict[str, str]:
        """The service: open a topic for one client, with a thread that ends without subscribers."""
        problem = _problem(request)
        if problem is not None:
            raise ValueError(problem)
        sending = _Sending(request)
        patience = min(max(request.timeout.to_sec(), MIN_PATIENCE), MAX_PATIENCE)
        name = f"{ACTION}/tf_repub_{next(self._numbers)}"
        with self._lock:
            if len(self._topics) >= MAX_TOPICS:
                raise ValueError(f"{MAX_TOPICS} topics of transforms are open, which is the limit")
            thread = threading.Thread(
                target=self._serve_topic, args=(name, sending, patience), name=f"rosproto:{name}", daemon=True
            )
            self._topics.add(thread)
        thread.start()
        return {"topic_name": name}

    def _serve_topic(self, name: str, sending: _Sending, patience: float) -> None:
        try:
            with self._node.publisher(
                name, "tf2_web_republisher/TFArray", on_connect=lambda _: sending.forget()
            ) as publisher:
                heard = time.monotonic()
                while time.monotonic() - heard < patience and not self._closing.wait(sending.period):
                    if not publisher.connections:
                        continue
                    heard = time.monotonic()
                    transforms = self._due(sending)
                    if transforms:
                        publisher.publish(transforms=transforms)
        except RosError as error:
            self._node.logger.warning("! %s ends: %s", name, error)
        finally:
            with self._lock:
                self._topics.discard(threading.current_thread())

    def _due(self, sending: _Sending) -> list[DynamicMessage]:
        found = []
        for source in sending.sources:
            try:
                found.append(self._listener.buffer.lookup(sending.target, source))
            except TransformError:
                continue  # not known now; sent when it is
        messages = [transform.to_message() for transform in sending.due(found)]
        for message in messages:
            message.header.stamp = self._node.clock.now()
        return messages


class _Sending:
    """The transforms that one client wants, and the last ones sent to it."""

    def __init__(self, asked: DynamicMessage) -> None:
        self.target = frame_name(asked.target_frame)
        self.sources = [frame_name(name) for name in asked.source_frames]
        self.period = 1.0 / asked.rate
        self._angle = asked.angular_thres
        self._distance = asked.trans_thres
        self._sent: dict[str, Transform] = {}

    def forget(self) -> None:
        """Send all transforms again, for a new subscriber."""
        self._sent = {}

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
        return bool(math.dist(before.translation, now.translation) > self._distance or angle > self._angle)


def _problem(goal: DynamicMessage) -> str | None:
    """Return why a goal is refused, or None."""
    if len(goal.source_frames) > MAX_FRAMES:
        return f"{len(goal.source_frames)} frames, {MAX_FRAMES} are the most"
    if not 0.0 < goal.rate <= MAX_RATE_HZ:
        return f"a rate of {goal.rate:g} Hz; expected more than 0, and {MAX_RATE_HZ:g} at most"
    if not (goal.angular_thres >= 0.0 and goal.trans_thres >= 0.0):
        return "a threshold is negative, or no number"
    try:
        for name in (goal.target_frame, *goal.source_frames):
            frame_name(name)
    except ValueError as error:
        return str(error)
    return None
