"""How the watchdog process handles the lines of its pipe; here it runs in a thread."""

from __future__ import annotations

import os
import socket
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

import pytest

from rosproto.codec import encode, message_class, service_class
from rosproto.master import Master
from rosproto.node import MasterClient, Node
from rosproto.watchdog.process import WatchdogProcess
from rosproto.watchdog.protocol import (
    ROUNDS,
    Arm,
    Drop,
    Heartbeat,
    LastCall,
    LastMessage,
    Line,
    Prepare,
    Ready,
    Sent,
    WatchedNode,
    read_line,
    watchdog_name,
    write_line,
)
from tests.support.waiting import until

TWIST = message_class("geometry_msgs/Twist")
L = TypeVar("L")
STAMPED = message_class("geometry_msgs/TwistStamped")


class Pipe:
    """The parent's end of the pipes, and the process in a thread."""

    def __init__(self, parent: Callable[[], int] | None = None) -> None:
        theirs, ours = os.pipe()
        answers, write = os.pipe()
        self._out, self._in = os.fdopen(ours, "wb", 0), os.fdopen(answers, "rb")
        self._ends = os.fdopen(theirs, "rb"), os.fdopen(write, "wb")
        self.process = WatchdogProcess(*self._ends, parent)
        self.thread = threading.Thread(target=self.process.run)
        self.thread.start()

    def say(self, line: Line) -> None:
        self._out.write(write_line(line))

    def answer(self, kind: type[L]) -> L:
        """The next line of this kind; reports that are repeated may come before it."""
        while not isinstance(line := read_line(self._in.readline()), kind):
            pass
        return line

    def prepare(self, line: Prepare) -> None:
        self.say(line)
        while (ready := self.answer(Ready)).key != line.key:
            pass
        assert ready == Ready(line.key)

    def end(self) -> None:
        """The parent is gone."""
        self._out.close()
        self.thread.join(20)
        assert not self.thread.is_alive()

    def close(self) -> None:
        self.end()
        for each in (self._in, *self._ends):
            each.close()


@pytest.fixture
def pipe() -> Iterator[Pipe]:
    made = Pipe()
    yield made
    made.close()


@pytest.fixture
def robot() -> Iterator[Node]:
    with (
        Master(host="127.0.0.1", port=0) as master,
        Node("/robot", master_uri=master.uri, rosout=False) as node,
    ):
        yield node


def zero(topic: str, kind: Any = TWIST) -> LastMessage:
    return LastMessage(topic, kind._type, kind._full_text, encode(kind()))


def prepared(node: Node, key: int, *messages: LastMessage, armed: bool = True, **more: Any) -> Prepare:
    return Prepare(key, WatchedNode(node.master_uri, "/program"), messages, armed=armed, **more)


def heard_on(node: Node, topic: str, kind: Any = TWIST) -> list[Any]:
    heard: list[Any] = []
    node.subscriber(topic, kind, heard.append, queue_size=100)
    return heard


def test_a_service_is_called_until_it_answers_and_not_again(robot: Node, pipe: Pipe) -> None:
    asked: list[bool] = []

    def answer(request: Any) -> dict[str, Any]:
        asked.append(request.data)
        if len(asked) == 1:
            raise ValueError("not yet")
        return {"success": True, "message": ""}

    robot.service_server("/end", "std_srvs/SetBool", answer)
    kind: Any = service_class("std_srvs/SetBool")
    call = LastCall("/end", "std_srvs/SetBool", encode(kind._request_class(data=True)))
    pipe.prepare(prepared(robot, 1, calls=(call,)))
    pipe.end()
    assert asked == [True, True]


def test_the_last_message_is_stamped_when_it_is_sent_and_armed_with_other_data(
    robot: Node, pipe: Pipe
) -> None:
    heard = heard_on(robot, "/stamped", STAMPED)
    pipe.prepare(prepared(robot, 1, zero("/stamped", STAMPED), armed=False))
    frame: Any = STAMPED()
    frame.header.frame_id = "base_link"
    pipe.say(Arm(1, (encode(frame),)))
    pipe.end()
    assert abs(heard[0].header.stamp.to_sec() - time.time()) < 20.0
    assert heard[0].header.frame_id == "base_link"


def test_a_service_that_is_to_be_called_for_a_while_is_called_again(robot: Node, pipe: Pipe) -> None:
    """What it ended may be followed by more, as a task of a list by the next one."""
    asked: list[float] = []

    def answer(request: Any) -> dict[str, Any]:
        asked.append(time.monotonic())
        return {"success": False, "message": "there is nothing to end now"}

    robot.service_server("/end", "std_srvs/Trigger", answer)
    kind: Any = service_class("std_srvs/Trigger")
    call = LastCall("/end", "std_srvs/Trigger", encode(kind._request_class()), 1.5)
    pipe.prepare(prepared(robot, 1, calls=(call,)))
    pipe.end()
    assert asked[-1] - asked[0] >= 1.4
    assert len(asked) >= 3


@pytest.mark.promise("It sends only the messages it received before the motion")
def test_what_was_dropped_is_off_the_graph_and_gets_nothing(robot: Node, pipe: Pipe) -> None:
    dropped, kept = heard_on(robot, "/dropped"), heard_on(robot, "/kept")
    pipe.prepare(prepared(robot, 1, zero("/dropped")))
    pipe.prepare(prepared(robot, 2, zero("/kept")))
    pipe.say(Drop(1))
    until(lambda: "/dropped" not in robot.master.get_system_state().publishers)
    pipe.end()
    assert not dropped
    assert kept


def test_a_watch_that_is_dropped_while_it_is_prepared_is_taken_back(robot: Node, pipe: Pipe) -> None:
    heard = heard_on(robot, "/cmd_vel")
    pipe.say(prepared(robot, 1, zero("/cmd_vel")))
    pipe.say(Drop(1))
    pipe.prepare(prepared(robot, 2, zero("/other"), armed=False))
    until(lambda: "/cmd_vel" not in robot.master.get_system_state().publishers)
    pipe.end()
    assert not heard


def test_what_is_being_prepared_when_the_parent_ends_is_sent_all_the_same(robot: Node, pipe: Pipe) -> None:
    heard = heard_on(robot, "/cmd_vel")
    pipe.say(prepared(robot, 1, zero("/cmd_vel")))
    pipe.end()
    assert heard


@pytest.mark.promise("are sent at once, and three times more within a tenth of a second")
def test_at_the_end_it_sends_before_it_does_anything_else(
    robot: Node, pipe: Pipe, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It looks nothing up, asks no master and starts no thread before the zeros and cancels are sent."""
    order: list[str] = []
    enough = threading.Event()

    def noted(owner: Any, name: str) -> None:
        before = getattr(owner, name)

        def call(*given: Any, **options: Any) -> Any:
            if enough.is_set() or threading.current_thread() is not pipe.thread:
                return before(*given, **options)
            order.append(f"{name} {given[:1]}")
            raise OSError("not before the zeros")

        monkeypatch.setattr(owner, name, call)

    def hear(message: Any) -> None:
        order.append("zero")
        if order.count("zero") == ROUNDS:
            enough.set()

    robot.subscriber("/cmd_vel", TWIST, hear, queue_size=100)
    pipe.prepare(prepared(robot, 1, zero("/cmd_vel")))
    for owner, name in (
        (threading.Thread, "start"),
        (socket, "getaddrinfo"),
        (socket.socket, "connect"),
        (MasterClient, "get_system_state"),
        (MasterClient, "lookup_node"),
    ):
        noted(owner, name)
    pipe.end()
    assert order == ["zero"] * ROUNDS


def test_it_tells_a_parent_that_was_silent_and_goes_on_watching(robot: Node, pipe: Pipe) -> None:
    heard = heard_on(robot, "/cmd_vel")
    pipe.prepare(prepared(robot, 1, zero("/cmd_vel")))
    assert pipe.answer(Sent).keys == (1,)
    until(lambda: len(heard) == ROUNDS)
    pipe.say(Heartbeat())
    assert pipe.answer(Sent).keys == (1,)


def test_it_reports_again_and_again_while_the_parent_talks(robot: Node, pipe: Pipe) -> None:
    heard_on(robot, "/cmd_vel")
    pipe.prepare(prepared(robot, 1, zero("/cmd_vel"), armed=False))
    for _ in range(2):
        pipe.say(Heartbeat())
        assert pipe.answer(Ready) == Ready(1)


@pytest.mark.promise("another node takes the name of the watchdog", "the master then shuts it down")
def test_it_takes_another_name_and_connects_again_when_its_own_was_taken(robot: Node, pipe: Pipe) -> None:
    heard = heard_on(robot, "/cmd_vel")
    pipe.prepare(prepared(robot, 1, zero("/cmd_vel"), armed=False))
    frame: Any = TWIST()
    frame.linear.z = 7.0
    pipe.say(Arm(1, (encode(frame),)))
    with Node(watchdog_name("/program"), master_uri=robot.master_uri, rosout=False) as taker:
        taker.publisher("/anything", TWIST)
        while not pipe.answer(Ready).problem:
            pipe.say(Heartbeat())
        while pipe.answer(Ready).problem:
            pipe.say(Heartbeat())
        names = robot.master.get_system_state().publishers["/cmd_vel"]
        assert names == [watchdog_name("/program", 1)]
        pipe.end()
    assert heard[-1].linear.z == 7.0, "the contents with which it was armed"


def test_a_name_that_is_taken_as_the_parent_ends_is_replaced_all_the_same(robot: Node, pipe: Pipe) -> None:
    heard = heard_on(robot, "/cmd_vel")
    pipe.prepare(prepared(robot, 1, zero("/cmd_vel")))
    with Node(watchdog_name("/program"), master_uri=robot.master_uri, rosout=False) as taker:
        taker.publisher("/anything", TWIST)
        until(lambda: not robot.master.get_system_state().publishers.get("/cmd_vel"))
        pipe.end()
    until(lambda: heard)


def test_a_parent_whose_number_changes_is_gone(robot: Node) -> None:
    number = [7]
    pipe = Pipe(lambda: number[0])
    heard = heard_on(robot, "/cmd_vel")
    pipe.prepare(prepared(robot, 1, zero("/cmd_vel")))
    number[0] = 1
    pipe.thread.join(20)
    assert not pipe.thread.is_alive()
    assert len(heard) >= 5
    pipe.close()


def test_a_robot_that_cannot_be_reached_gets_its_zero_when_it_is_back(robot: Node, pipe: Pipe) -> None:
    pipe.prepare(prepared(robot, 1, zero("/late")))
    threading.Timer(1.0, lambda: heard.extend([heard_on(robot, "/late")])).start()
    heard: list[list[Any]] = []
    pipe.end()
    until(lambda: heard and heard[0])
