"""A graph without sockets: topics deliver in the calling thread, tests play the other side."""

from __future__ import annotations

import threading
from typing import Any

from rosproto.codec import decode, message_class
from rosproto.errors import LocalProtocolError
from rosproto.time import Time

ACTION = "woosh_msgs/StepControl"
StatusArray = message_class("actionlib_msgs/GoalStatusArray")
Status = message_class("actionlib_msgs/GoalStatus")
GoalID = message_class("actionlib_msgs/GoalID")
Goal = message_class("woosh_msgs/StepControlGoal")
Result = message_class("woosh_msgs/StepControlResult")
ActionGoal = message_class("woosh_msgs/StepControlActionGoal")
ActionResult = message_class("woosh_msgs/StepControlActionResult")
ActionFeedback = message_class("woosh_msgs/StepControlActionFeedback")
Feedback = message_class("woosh_msgs/StepControlFeedback")


class Publisher:
    def __init__(self, graph: Graph, node: FakeNode, topic: str) -> None:
        self.graph, self.node, self.topic = graph, node, topic
        self.latch, self.linger = False, True
        self.sent: list[Any] = []
        self.closed = False

    @property
    def subscribers(self) -> list[str]:
        return [
            s.node.name for s in self.graph.subscribers if s.topic == self.topic
        ] + self.graph.fake_subscribers.get(self.topic, [])

    @property
    def connections(self) -> int:
        return len(self.subscribers)

    def publish(self, message: Any) -> None:
        if self.closed:
            raise LocalProtocolError("closed")
        self.sent.append(message)
        if isinstance(message, bytes):  # of the publishers here, only that of cancels is given bytes
            message = decode(message_class("actionlib_msgs/GoalID"), message)
        self.graph.deliver(self.topic, message, self.node.name)

    def close(self) -> None:
        self.closed = True


class Subscriber:
    def __init__(self, graph: Graph, node: FakeNode, topic: str, callback: Any) -> None:
        self.graph, self.node, self.topic, self.callback = graph, node, topic, callback

    @property
    def publishers(self) -> list[str]:
        return self.graph.fake_publishers.get(self.topic, [])

    def stats(self) -> list[str]:
        return self.publishers + self.graph.unreachable.get(self.topic, [])

    def why_silent(self) -> str:
        return "; ".join(f"{who} is waiting" for who in self.graph.unreachable.get(self.topic, []))

    def close(self) -> None:
        if self in self.graph.subscribers:
            self.graph.subscribers.remove(self)


class NodeTime:
    def __init__(self) -> None:
        self.time = Time(100)

    def now(self) -> Time:
        return self.time


class FakeNode:
    def __init__(self, graph: Graph, name: str) -> None:
        self.graph, self.name = graph, name
        self.clock = NodeTime()
        self.closed = False
        self.closers: list[Any] = []

    def add_closer(self, close: Any) -> None:
        self.closers.append(close)

    def remove_closer(self, close: Any) -> None:
        if close in self.closers:
            self.closers.remove(close)

    def resolve_name(self, name: str) -> str:
        return name if name.startswith("/") else "/" + name

    def publisher(
        self, topic: str, type: Any, *, latch: bool = False, queue_size: int = 10, linger: bool = True
    ) -> Publisher:
        publisher = self.graph.publishers[topic] = Publisher(self.graph, self, topic)
        publisher.latch, publisher.linger = latch, linger
        return publisher

    def subscriber(self, topic: str, type: Any, callback: Any, *, queue_size: int = 10) -> Subscriber:
        subscriber = Subscriber(self.graph, self, topic, callback)
        self.graph.subscribers.append(subscriber)
        return subscriber


class Graph:
    def __init__(self) -> None:
        self.subscribers: list[Subscriber] = []
        self.publishers: dict[str, Publisher] = {}
        self.fake_subscribers: dict[str, list[str]] = {}
        self.fake_publishers: dict[str, list[str]] = {}
        self.unreachable: dict[str, list[str]] = {}

    def deliver(self, topic: str, message: Any, caller: str) -> None:
        message._connection_header = {"callerid": caller}
        for subscriber in list(self.subscribers):
            if subscriber.topic == topic:
                subscriber.callback(message)

    def connect_server(self, name: str = "/srv", action: str = "/act") -> None:
        """Connections as to a running server of that name."""
        for part in ("goal", "cancel"):
            self.fake_subscribers.setdefault(f"{action}/{part}", []).append(name)
        for part in ("status", "result", "feedback"):
            self.fake_publishers.setdefault(f"{action}/{part}", []).append(name)

    def status(self, *goals: tuple[str, int] | tuple[str, int, str], server: str = "/srv") -> None:
        """A status array from a server."""
        rows = [Status(goal_id=GoalID(id=g[0]), status=g[1], text=g[2] if len(g) > 2 else "") for g in goals]
        self.deliver("/act/status", StatusArray(status_list=rows), server)

    def result(self, goal_id: str, status: int, text: str = "", server: str = "/srv") -> None:
        """A result from a server."""
        message = ActionResult(status=Status(goal_id=GoalID(id=goal_id), status=status, text=text))
        message.result.percent = 1.0
        self.deliver("/act/result", message, server)

    def feedback(self, goal_id: str, percent: float, server: str = "/srv") -> None:
        """Feedback from a server."""
        message = ActionFeedback(status=Status(goal_id=GoalID(id=goal_id), status=1))
        message.feedback.percent = percent
        self.deliver("/act/feedback", message, server)


class SteppedClock:
    """Its time moves when told; waits are real."""

    def __init__(self) -> None:
        self.now = 1000.0

    def monotonic(self) -> float:
        return self.now

    def wait(self, waitable: threading.Event, timeout: float | None) -> bool:
        return bool(waitable.wait(timeout))
