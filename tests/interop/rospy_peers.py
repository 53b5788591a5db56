"""The other side of the programs: peers made of our node, the same for both runs."""

from __future__ import annotations

import functools
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import rosproto
from rosproto.node import Node
from tests.support.rospy_pair import Peer

__all__ = ["action_caller", "action_server", "answers", "calls", "clock", "hears", "says", "together"]


def together(*peers: Peer) -> Peer:
    """Several peers at once."""

    @contextmanager
    def both(uri: str, log: list[Any]) -> Iterator[None]:
        from contextlib import ExitStack

        with ExitStack() as stack:
            for peer in peers:
                stack.enter_context(peer(uri, log))
            yield

    return both


def hears(topics: Mapping[str, str], *, name: str = "/ear") -> Peer:
    """Notes the text of every message of some topics, sorted by topic at the end.

    How many they are is the parameter /heard/NAME, so that a program can stay until its last has arrived.
    """

    @contextmanager
    def peer(uri: str, log: list[Any]) -> Iterator[None]:
        heard: dict[str, list[str]] = {topic: [] for topic in topics}
        lock = threading.Lock()
        with Node(name, master_uri=uri) as node:

            def note(topic: str, message: Any) -> None:
                with lock:
                    heard[topic].append(str(message))
                    node.params[f"/heard{name}"] = sum(map(len, heard.values()))

            for topic, kind in topics.items():
                node.subscriber(topic, kind, functools.partial(note, topic), queue_size=1000)
            yield
        log.append(heard)

    return peer


def says(
    topics: Mapping[str, tuple[str, Sequence[Any]]],
    *,
    latch: bool = True,
    pause: float = 0.05,
    repeat: bool = False,
    when: str = "",
) -> Peer:
    """Publishes messages: `topic: (type, [fields, ...])`, when somebody is connected to all topics.

    With `when`, the name of a parameter, only as many as that says: the program's word that it is ready for them.
    """

    @contextmanager
    def peer(uri: str, log: list[Any]) -> Iterator[None]:
        over = threading.Event()
        with Node("/mouth", master_uri=uri) as node:
            threads = [
                threading.Thread(target=speak, args=(node, topic, kind, messages, over), daemon=True)
                for topic, (kind, messages) in topics.items()
            ]
            for thread in threads:
                thread.start()
            yield
            over.set()
            for thread in threads:
                thread.join(5)

    def speak(node: Node, topic: str, kind: str, messages: Sequence[Any], over: threading.Event) -> None:
        publisher = node.publisher(topic, kind, latch=latch, queue_size=1000)
        while not over.is_set():
            if not publisher.connections and not latch:
                time.sleep(0.01)
                continue
            for number, fields in enumerate(messages, 1):
                while when and node.params.get(when, 0) < number and not over.is_set():
                    time.sleep(0.01)
                publisher.publish(rosproto.message_class(kind)(**fields))
                if over.wait(pause):
                    return
            if not repeat:
                return

    return peer


def answers(services: Mapping[str, tuple[str, Callable[[Any], Any]]]) -> Peer:
    """Provides services and notes the requests."""

    @contextmanager
    def peer(uri: str, log: list[Any]) -> Iterator[None]:
        with Node("/provider", master_uri=uri) as node:
            for name, (kind, handler) in services.items():

                def note(request: Any, name: str = name, handler: Callable[[Any], Any] = handler) -> Any:
                    log.append((name, str(request)))
                    return handler(request)

                node.service_server(name, kind, note)
            yield

    return peer


def calls(sequence: Sequence[tuple[str, str, Mapping[str, Any]]]) -> Peer:
    """Calls services of the program one after the other, notes what comes back, and sets /called at the end."""

    @contextmanager
    def peer(uri: str, log: list[Any]) -> Iterator[None]:
        def work() -> None:
            with Node("/caller", master_uri=uri) as node:
                node.wait_for_service(sequence[-1][0], timeout=20)  # then the program is through
                for name, kind, fields in sequence:
                    try:
                        log.append((name, str(node.service_client(name, kind).call(timeout=10, **fields))))
                    except rosproto.ServiceError as error:
                        log.append((name, error.text))
                node.params["/called"] = True

        thread = threading.Thread(target=work, daemon=True)
        thread.start()
        yield
        thread.join(10)

    return peer


def action_server() -> Peer:
    """Counts up to the goal; negative goals fail.

    The program says by /sent that it knows the handle of a goal, and by /seen which feedback it has: rospy loses what
    is earlier than the one, or comes by another topic than the other.
    """

    @contextmanager
    def peer(uri: str, log: list[Any]) -> Iterator[None]:
        def wait(node: Node, name: str, value: int, goal: Any) -> None:
            while node.params.get(name, None) != value and not goal.cancel_requested:
                time.sleep(0.01)

        def work(goal: Any) -> None:
            number = goal.goal.goal
            log.append(("goal", number))
            wait(node, "/sent", number, goal)
            while not all(part.connections for part in (server._feedback_out, server._result_out)):
                time.sleep(0.01)  # the client is connected; this side may not know it yet
            for i in range(number):
                if goal.cancel_requested:
                    goal.preempted(make("Result", result=i), "stopped")
                    return
                goal.publish_feedback(make("Feedback", feedback=i))
                time.sleep(0.05)
            if number < 0:
                goal.abort(make("Result"), "negative")
            else:
                wait(node, "/seen", number - 1, goal)
                goal.succeed(make("Result", result=number), "counted")

        with (
            Node("/counter", master_uri=uri) as node,
            rosproto.ActionServer(node, "/count", "actionlib/TestAction", work) as server,
        ):
            yield

    return peer


def make(part: str, **fields: Any) -> Any:
    """A part of actionlib/Test."""
    return rosproto.message_class(f"actionlib/Test{part}")(**fields)


def action_caller(goals: Sequence[tuple[int, float | None]], then: Callable[[str], None]) -> Peer:
    """Sends goals `(goal, seconds from its start until it is cancelled)` to /count and notes how they end."""

    @contextmanager
    def peer(uri: str, log: list[Any]) -> Iterator[None]:
        def work() -> None:
            with (
                Node("/sender", master_uri=uri) as node,
                rosproto.ActionClient(node, "/count", "actionlib/TestAction") as client,
            ):
                client.wait_for_server(timeout=20)
                for number, cancel_after in goals:
                    handle = client.send_goal(make("Goal", goal=number))
                    if cancel_after is not None:
                        while handle.status.name == "PENDING":  # a cancel may overtake its goal
                            time.sleep(0.01)
                        time.sleep(cancel_after)
                        handle.cancel()
                    result = handle.wait(timeout=20)
                    log.append((number, handle.status.name, handle.text, result.result))
            then(uri)

        thread = threading.Thread(target=work, daemon=True)
        thread.start()
        yield
        thread.join(10)

    return peer


def clock(speed: float = 10.0) -> Peer:
    """Publishes /clock, `speed` times as fast as real time."""

    @contextmanager
    def peer(uri: str, log: list[Any]) -> Iterator[None]:
        over = threading.Event()

        def work(node: Node) -> None:
            publisher = node.publisher("/clock", "rosgraph_msgs/Clock", queue_size=1)
            message = rosproto.message_class("rosgraph_msgs/Clock")()
            stamp = 100.0
            while not over.wait(0.005):
                stamp += 0.005 * speed
                message.clock = rosproto.Time.from_sec(stamp)
                publisher.publish(message)

        with Node("/clockwork", master_uri=uri) as node:
            thread = threading.Thread(target=work, args=(node,), daemon=True)
            thread.start()
            yield
            over.set()
            thread.join(5)

    return peer
