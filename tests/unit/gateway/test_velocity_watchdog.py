"""Zero follows a velocity whose client is gone or silent; nothing else is sent in anybody's stead."""

from __future__ import annotations

import ast
import threading
import time
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

import rosproto.gateway
from rosproto import Master, Node
from rosproto.codec import Message, define, encode, message_class
from rosproto.errors import CodecError, LocalProtocolError
from rosproto.gateway.client_publications import ClientPublications
from rosproto.gateway.velocity_watchdog import DriveTable, VelocityWatchdog, is_velocity, moves
from tests.support.victim import eventually

Twist = message_class("geometry_msgs/Twist")
TwistStamped = message_class("geometry_msgs/TwistStamped")
String = message_class("std_msgs/String")


def forward(speed: float = 0.2) -> Any:
    twist = Twist()
    twist.linear.x = speed
    return twist


def zeros_until(table: DriveTable, start: float, end: float) -> list[float]:
    """When zeros were due on the one topic."""
    found = []
    step = 0.01
    now = start
    while now < end:
        found += [round(now, 2)] * len(table.due(now))
        now += step
    return found


def test_silence_is_followed_by_zeros() -> None:
    """Half a second after the last velocity, five times over half a second; then nothing."""
    table = DriveTable()
    for i in range(10):
        table.note("c", "/v", i * 0.1, moving=True)
    zeros = zeros_until(table, 0.9, 5.0)
    assert len(zeros) == 5
    assert 1.39 <= zeros[0] <= 1.42
    assert 0.45 <= zeros[-1] - zeros[0] <= 0.6
    assert table.driven == ()
    assert table.next_look() is None


class Missed:
    """A publisher without a subscriber."""

    topic, message_class = "/v", Twist

    def __init__(self) -> None:
        self.sent: list[tuple[str, bytes]] = []

    def publish(self, message: object) -> None:
        pass

    def publish_to(self, caller_id: str, data: bytes) -> None:
        self.sent.append((caller_id, data))


@pytest.mark.parametrize(
    ("messages", "late", "sent"),
    [
        ([Twist()], 0.0, 1),
        ([forward(), Twist()], 0.0, 1),
        ([Twist()], 6.0, 0),
        ([Twist(), forward()], 0.0, 0),
        ([forward()], 0.0, 0),
        ([], 0.0, 0),
    ],
)
def test_a_subscriber_that_connects_after_a_zero_is_sent_it_unless_somebody_drives(
    messages: list[Any], late: float, sent: int
) -> None:
    """A velocity that it has missed is not sent: that would be a late one."""
    watchdog, publisher = VelocityWatchdog(), Missed()
    for message in messages:
        watchdog.publish("c", publisher, message, time.monotonic() - late)  # type: ignore[arg-type]
    watchdog.connected(publisher, "/robot")  # type: ignore[arg-type]
    watchdog.close()
    assert publisher.sent == [("/robot", encode(Twist()))] * sent


def test_leaving_is_followed_by_zeros_at_once() -> None:
    """Not half a second later."""
    table = DriveTable()
    table.note("c", "/v", 0.0, moving=True)
    table.note("c", "/w", 0.0, moving=True)
    table.gone("c", 0.1, "/v")
    assert table.due(0.1) == ["/v"]
    table.gone("c", 0.11)
    assert table.due(0.11) == ["/w"]
    assert len(zeros_until(table, 0.12, 3.0)) == 4 + 4


def test_a_client_that_stops_by_itself_is_left_alone() -> None:
    """Its zero was the last word."""
    table = DriveTable()
    table.note("c", "/v", 0.0, moving=True)
    table.note("c", "/v", 0.1, moving=False)
    table.gone("c", 0.2)
    assert zeros_until(table, 0.2, 3.0) == []
    table.note("c", "/v", 4.0, moving=False)
    assert table.driven == ()


def test_no_zero_while_another_client_drives() -> None:
    """It has the topic; when it is gone, too, zero follows."""
    table = DriveTable()
    table.note("a", "/v", 0.0, moving=True)
    table.note("b", "/v", 0.1, moving=True)
    table.gone("a", 0.2)
    assert table.due(0.2) == []
    table.note("b", "/v", 0.3, moving=True)
    assert zeros_until(table, 0.3, 0.75) == []
    assert len(zeros_until(table, 0.75, 3.0)) == 5


def test_who_drives_on_ends_the_zeros() -> None:
    """They would stutter into it."""
    table = DriveTable()
    table.note("a", "/v", 0.0, moving=True)
    assert zeros_until(table, 0.5, 0.6) != []
    table.note("a", "/v", 0.6, moving=True)
    assert zeros_until(table, 0.6, 1.0) == []
    assert len(zeros_until(table, 1.0, 3.0)) == 5


def test_another_client_that_stands_still_does_not_drive() -> None:
    """Zeros of a second page (a joystick at rest) end neither the first one's drive nor its supervision."""
    table = DriveTable()
    table.note("a", "/v", 0.0, moving=True)
    table.note("b", "/v", 0.1, moving=False)
    assert table.driven == ("/v",)
    assert len(zeros_until(table, 0.1, 3.0)) == 5


@pytest.mark.parametrize("value", [0.1, -0.1, float("nan"), float("inf"), 1e-300])
def test_what_moves(value: float) -> None:
    """Any number but zero, NaN too."""
    for axis in ("x", "y", "z"):
        for part in ("linear", "angular"):
            twist = Twist()
            assert not moves(twist)
            setattr(getattr(twist, part), axis, value)
            assert moves(twist)
    stamped = TwistStamped()
    stamped.header.seq = 7
    stamped.header.frame_id = "base"
    assert not moves(stamped)
    twist = Twist()
    twist.linear.x = -0.0
    assert not moves(twist)


class Robot:
    """A node that notes velocities, with the time."""

    def __init__(self, node: Node, topic: str, type_: str) -> None:
        self.got: list[tuple[float, Any]] = []
        self.changed = threading.Condition()
        self.subscriber = node.subscriber(topic, type_, self.take, queue_size=1000)

    def take(self, message: Any) -> None:
        with self.changed:
            self.got.append((time.monotonic(), message))
            self.changed.notify_all()

    def wait(self, count: int, seconds: float = 10.0) -> list[tuple[float, Any]]:
        with self.changed:
            assert self.changed.wait_for(lambda: len(self.got) >= count, seconds), self.got
            return list(self.got)


@pytest.mark.promise("leaves or is silent for half a second, the gateway sends zero")
def test_over_real_sockets() -> None:
    """Silence, bytes, stamps, closing; and no thread stays."""
    with (
        Master() as master,
        Node("/robot", master_uri=master.uri, intraprocess=False) as robot_node,
        Node("/gateway", master_uri=master.uri, intraprocess=False) as node,
    ):
        plain = Robot(robot_node, "/cmd_vel", "geometry_msgs/Twist")
        stamped = Robot(robot_node, "/cmd_stamped", "geometry_msgs/TwistStamped")
        velocity_watchdog = VelocityWatchdog(node.clock.now)
        publications = ClientPublications(node, velocity_watchdog)
        drive = publications.open("c", "/cmd_vel", Twist)
        second = publications.open("c", "/cmd_stamped", TwistStamped)
        for publisher in plain, stamped:
            publisher.subscriber.wait_for_connection(10)
        drive.publish(encode(forward()))
        message = TwistStamped()
        message.header.frame_id = "base_link"
        message.twist.angular.z = 1.0
        second.publish(message)
        got = plain.wait(6)
        assert moves(got[0][1])
        assert not any(moves(m) for _, m in got[1:6])
        assert 0.3 <= got[1][0] - got[0][0] <= 2.0
        zeros = [m for _, m in stamped.wait(6)[1:]]
        assert not any(moves(m) for m in zeros)
        assert {m.header.frame_id for m in zeros} == {"base_link"}
        assert all(m.header.stamp.to_sec() > 1e9 for m in zeros)
        # The client goes in the middle of a drive: the publisher stays for the zeros.
        before = len(plain.got)
        drive.publish(forward())
        drive.close()
        with pytest.raises(LocalProtocolError):
            drive.publish(forward())
        left = plain.wait(before + 6)
        assert left[before + 1][0] - left[before][0] < 0.4
        # The gateway goes.
        third = publications.open("d", "/cmd_vel", Twist)
        before = len(plain.got)
        third.publish(forward())
        publications.close()
        assert len(plain.wait(before + 6)) >= before + 6
        names = {"rosproto:velocity watchdog", "rosproto:leave /cmd_vel"}
        eventually(lambda: not [t for t in threading.enumerate() if t.name in names], 10)


class Recorder:
    """A publisher that is none."""

    topic = "/v"
    closed = False

    def __init__(self, message: type[Message] = Twist) -> None:
        self.message_class = message
        self.got: list[Any] = []

    def publish(self, message: Any = None) -> None:
        self.got.append(message)


def test_bytes_that_are_no_velocity_are_not_published() -> None:
    """What cannot be read cannot be guarded."""
    table = DriveTable()
    publisher, velocity_watchdog = Recorder(), VelocityWatchdog(table=table)
    with pytest.raises(CodecError):
        velocity_watchdog.publish("c", publisher, b"\x01\x02")
    assert publisher.got == []
    assert table.driven == ()


def test_a_closed_watchdog_lets_nothing_move() -> None:
    """A moving velocity is not published, as no zero would follow; zeros are."""
    publisher, velocity_watchdog = Recorder(), VelocityWatchdog()
    velocity_watchdog.close()
    velocity_watchdog.publish("c", publisher, forward())
    assert publisher.got == []
    velocity_watchdog.publish("c", publisher, Twist())
    assert len(publisher.got) == 1


def test_without_a_thread_that_would_send_the_zeros_nothing_moves(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(self: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    publisher, velocity_watchdog = Recorder(), VelocityWatchdog()
    monkeypatch.setattr(threading.Thread, "start", refuse)
    with pytest.raises(RuntimeError):
        velocity_watchdog.publish("c", publisher, forward())
    assert publisher.got == []


def test_other_types_pass_as_they_are() -> None:
    """Bytes are not decoded."""

    table = DriveTable()
    publisher, velocity_watchdog = Recorder(String), VelocityWatchdog(table=table)
    velocity_watchdog.publish("c", publisher, b"whatever")
    assert publisher.got == [b"whatever"]
    assert not is_velocity(String)
    assert table.driven == ()


NO_VELOCITIES = [float("nan"), float("inf"), float("-inf"), 1e308, -1e308, 1000.5]


@pytest.mark.promise("does not publish a velocity with a number that is not finite")
@pytest.mark.parametrize("value", NO_VELOCITIES)
@pytest.mark.parametrize("encoded", [False, True])
def test_a_velocity_that_is_none_is_refused(value: float, encoded: bool) -> None:
    """Every number of every velocity type is checked, in bytes too; nothing is published, and no drive begins."""
    places = [(Twist, f"{part}.{axis}") for part in ("linear", "angular") for axis in "xyz"]
    places.append((TwistStamped, "twist.angular.z"))
    for cls, path in places:
        message: Any = cls()
        *outer, last = path.split(".")
        inner = message
        for name in outer:
            inner = getattr(inner, name)
        setattr(inner, last, value)
        table = DriveTable()
        publisher, velocity_watchdog = Recorder(cls), VelocityWatchdog(table=table)
        with pytest.raises(LocalProtocolError, match="a velocity for /v is not published"):
            velocity_watchdog.publish("c", publisher, encode(message) if encoded else message)
        assert publisher.got == []
        assert table.driven == ()


def test_the_definition_of_a_client_hides_no_number() -> None:
    """Arrays are checked too, in a viewer's own definition with the name of a velocity type."""
    text = "float64[] speeds\nfloat32[2] pair\ngeometry_msgs/Vector3[] parts\n"
    vector = "\n" + "=" * 80 + "\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
    own = define("geometry_msgs/Twist", text + vector)
    vectors = message_class("geometry_msgs/Vector3")
    table = DriveTable()
    velocity_watchdog = VelocityWatchdog(table=table)
    assert not moves(own())
    for wrong in (
        own(speeds=[0.0, float("nan")]),
        own(pair=[float("inf"), 0.0]),
        own(parts=[vectors(x=1e308)]),
    ):
        publisher = Recorder(own)
        with pytest.raises(LocalProtocolError):
            velocity_watchdog.publish("c", publisher, encode(wrong))
        assert publisher.got == []
    publisher = Recorder(own)
    velocity_watchdog.publish("c", publisher, encode(own(speeds=[0.0, 0.5])))
    assert table.driven == ("/v",)
    velocity_watchdog.close()


@pytest.mark.promise("does not publish a velocity with a number that is not finite")
def test_what_is_no_velocity_is_no_sign_of_life() -> None:
    """A client that goes on with NaN stands still after half a second, as one that is silent."""
    publisher, velocity_watchdog = Recorder(), VelocityWatchdog(table=DriveTable(silence=0.1, over=0.01))
    velocity_watchdog.publish("c", publisher, forward())
    end = time.monotonic() + 10.0
    while velocity_watchdog.zeros < 5:
        with pytest.raises(LocalProtocolError):
            velocity_watchdog.publish("c", publisher, forward(float("nan")))
        assert time.monotonic() < end, "no zero came"
    assert [moves(message) for message in publisher.got] == [True, False, False, False, False, False]


PUBLISHES = {
    ("velocity_watchdog.py", "VelocityWatchdog.publish"): 2,
    ("velocity_watchdog.py", "VelocityWatchdog._send"): 1,  # its own zeros
    ("velocity_watchdog.py", "VelocityWatchdog.connected"): 1,  # a zero again
    ("client_publications.py", "_EarlyMessages.publish"): 1,  # no velocities: see `ClientPublications.open`
    ("client_publications.py", "_EarlyMessages._catch_up"): 1,
    ("client_publications.py", "ClientPublication.publish"): 2,  # to the two above
    ("rosbridge/session.py", "RosbridgeSession._publish"): 1,  # a `ClientPublication`
    ("foxglove/client_publish.py", "ClientPublisher.publish_at_once"): 2,  # to the one below
    ("foxglove/client_publish.py", "ClientPublisher.publish"): 1,  # a `ClientPublication`
    ("foxglove/session.py", "FoxgloveSession.received"): 1,  # to the one above
    ("rosbridge/calls_and_goals.py", "ServiceCalls._cancel_all"): 1,  # a goal's id
    ("rosbridge/tf_republisher.py", "TfRepublisher._serve_topic"): 1,  # transforms
}
"""Every place below gateway/ that publishes something, and why no client's velocity passes the velocity watchdog there."""


@pytest.mark.promise("does not publish a velocity with a number that is not finite")
def test_no_client_publishes_past_the_velocity_watchdog() -> None:
    """A new place has to be looked at, and named here."""
    root = Path(rosproto.gateway.__file__).parent
    found: Counter[tuple[str, str]] = Counter()

    def look(node: ast.AST, file: str, within: tuple[str, ...]) -> None:
        for child in ast.iter_child_nodes(node):
            inner = within
            if isinstance(child, (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
                inner = (*within, child.name)
            if isinstance(child, ast.Attribute) and child.attr in ("publish", "publish_to"):
                found[file, ".".join(within)] += 1
            look(child, file, inner)

    for path in sorted(root.rglob("*.py")):
        look(ast.parse(path.read_text("utf-8")), path.relative_to(root).as_posix(), ())
    assert dict(found) == PUBLISHES


def test_a_velocity_that_came_before_a_zero_is_not_published_after_it() -> None:
    """Of whichever client; one that came later is."""
    publisher, velocity_watchdog = Recorder(), VelocityWatchdog()
    velocity_watchdog.publish("b", publisher, Twist(), received=2.0)
    with pytest.raises(LocalProtocolError, match="a zero was received while it waited"):
        velocity_watchdog.publish("a", publisher, forward(), received=1.0)
    velocity_watchdog.publish("a", publisher, forward(), received=3.0)
    assert len(publisher.got) == 2
    velocity_watchdog.close()
