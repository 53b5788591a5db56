"""Peers with another revision of a type: all five directions, over TCP and inside one process."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from rosproto import ActionClient, ActionServer, Master, Node
from rosproto.codec import define, message_class, service_class
from rosproto.codec.conversion import Conversion, ValuesLost
from rosproto.errors import CodecError, Md5sumMismatch, RosTimeout
from rosproto.msg import bundled
from rosproto.node.definitions.known_definitions import KnownDefinitions
from rosproto.node.definitions.md5sum_mismatch import RevisedType, UnconvertibleMessage
from rosproto.node.definitions.topic_type import TopicType
from rosproto.node.graph.master_client import SystemState
from rosproto.node.incoming.delivery import RevisedDelivery
from rosproto.node.incoming.subscriber_queue import SubscriberQueue
from rosproto.protocol.handshake import subscriber_header
from tests.support.victim import eventually

Battery = message_class("woosh_msgs/Battery")
Parameter = message_class("woosh_msgs/Parameter")
ExecTask = service_class("woosh_msgs/ExecTask")


def revision(name: str, label: str, kind: str = "msg") -> Any:
    """The class of a type as of a revision."""
    found = next(r for r in bundled().revisions(name, kind=kind) if r.label == label)
    return (message_class if kind == "msg" else service_class)(name, found.library)


PageBattery = revision("woosh_msgs/Battery", "page")
PageParameter = revision("woosh_msgs/Parameter", "page")
PageExecTask = revision("woosh_msgs/ExecTask", "page", "srv")


@pytest.fixture(params=[True, False], ids=["intraprocess", "tcp"])
def nodes(request: pytest.FixtureRequest) -> Iterator[tuple[Node, Node]]:
    """Two nodes of one master."""
    inside = request.param
    with (
        Master() as master,
        Node("/here", master_uri=master.uri, intraprocess=inside, rosout=False) as here,
        Node("/robot", master_uri=master.uri, intraprocess=inside, rosout=False) as robot,
    ):
        yield here, robot


def test_subscribing(nodes: tuple[Node, Node]) -> None:
    """The robot's older definition is decoded, and the program gets the type it asked for."""
    here, robot = nodes
    publisher = robot.publisher("/battery", PageBattery)
    subscriber = here.subscriber("/battery", Battery)
    publisher.wait_for_connection(timeout=20)
    publisher.publish(PageBattery(batteryPercentage=81, bmsStatus=7, cellVoltageMax=3.5))
    message = subscriber.next(timeout=20)
    assert type(message) is Battery
    assert (message.batteryPercentage, message.bmsStatus, message.cellVoltageMax) == (81, 7, 3.5)
    assert message._connection_header["topic"] == "/battery"


def test_publishing_to_several_revisions(nodes: tuple[Node, Node]) -> None:
    """Each subscriber gets the revision it asks for, the latched message too, and ours is not disturbed."""
    here, robot = nodes
    publisher = here.publisher("/battery", Battery, latch=True)
    publisher.publish(Battery(batteryPercentage=1, bmsStatus=1))
    old = robot.subscriber("/battery", PageBattery)
    assert old.next(timeout=20).batteryPercentage == 1
    new = here.subscriber("/battery", Battery)
    assert new.next(timeout=20).batteryPercentage == 1
    publisher.wait_for_connection(timeout=20, count=2)
    assert publisher.connections == 2
    publisher.publish(Battery(batteryPercentage=2, bmsStatus=9, cellVoltageMin=3.25))
    for subscriber, cls in ((old, PageBattery), (new, Battery)):
        message = subscriber.next(timeout=20)
        assert type(message) is cls
        assert (message.batteryPercentage, message.bmsStatus, message.cellVoltageMin) == (2, 9, 3.25)


def test_publishing_raw_bytes_to_another_revision(nodes: tuple[Node, Node]) -> None:
    """A relay that never decoded its messages is converted for the one peer that needs it."""
    here, robot = nodes
    publisher = here.publisher("/battery", Battery)
    old = robot.subscriber("/battery", PageBattery)
    publisher.wait_for_connection(timeout=20)
    from rosproto.codec import encode

    publisher.publish(encode(Battery(bmsStatus=5)))
    assert old.next(timeout=20).bmsStatus == 5


def test_a_value_that_does_not_fit_is_told(nodes: tuple[Node, Node]) -> None:
    """The others get their message; who had to convert is told which field, and the next message arrives."""
    here, robot = nodes
    publisher = here.publisher("/parameter", PageParameter)
    fine = here.subscriber("/parameter", PageParameter)
    other = robot.subscriber("/parameter", Parameter)
    publisher.wait_for_connection(timeout=20, count=2)
    if (
        publisher.stats()[0].transport == "INTRAPROCESS"
    ):  # there the subscriber converts, and its link is told
        publisher.publish(PageParameter(pulsePerCircle=0.5))
        eventually(lambda: other.errors)
        with pytest.raises(RosTimeout, match="pulsePerCircle"):
            other.next(timeout=0.01)
        publisher.wait_for_connection(timeout=20, count=2)
    else:
        with pytest.raises(CodecError, match="pulsePerCircle"):
            publisher.publish(PageParameter(pulsePerCircle=0.5))
    assert fine.next(timeout=20).pulsePerCircle == 0.5
    publisher.publish(PageParameter(pulsePerCircle=7.0))
    assert other.next(timeout=20).pulsePerCircle == 7


def test_service_client(nodes: tuple[Node, Node]) -> None:
    """A provider with the page's spelling: the request arrives under its names, the answer under ours."""
    here, robot = nodes
    seen: list[Any] = []

    def handler(request: Any) -> Any:
        seen.append(request)
        return PageExecTask.Response(statuscode=2)

    robot.service_server("/exec_task", PageExecTask, handler)
    for persistent in (False, True):
        with here.service_client("/exec_task", ExecTask, persistent=persistent) as client:
            for _ in range(2):
                response = client.call(ExecTask.Request(task_exect=1, mark_no="A1"), timeout=20)
                assert type(response) is ExecTask.Response
                assert response.statusCode == 2
    assert all((r.task_exec, r.mark_no) == (1, "A1") for r in seen)
    assert len(seen) == 4


def test_service_server(nodes: tuple[Node, Node]) -> None:
    """A client with the page's spelling calls us."""
    here, robot = nodes
    with (
        here.service_server("/exec_task", ExecTask, lambda r: {"statusCode": r.task_exect + 1}),
        robot.service_client("/exec_task", PageExecTask) as client,
    ):
        assert client.call(task_exec=3, timeout=20).statuscode == 4


@pytest.mark.parametrize("old_side", ["server", "client"])
def test_actions(nodes: tuple[Node, Node], old_side: str) -> None:
    """Goal, feedback and result each travel by their own revision."""
    here, robot = nodes
    old = revision("woosh_msgs/StepControlAction", "1.1.0")
    new = message_class("woosh_msgs/StepControlAction")
    server_type, client_type = (old, new) if old_side == "server" else (new, old)

    def handler(goal: Any) -> None:
        assert goal.goal.stepControl[0].data == 0.5
        goal.succeed()

    goal_class = message_class("woosh_msgs/StepControlGoal", client_type._binding.library)
    step_class = message_class("woosh_msgs/StepControl", client_type._binding.library)
    with (
        ActionServer(robot, "/steps", server_type, handler),
        ActionClient(here, "/steps", client_type) as client,
    ):
        client.wait_for_server(timeout=20)
        assert client.revisions == {"/robot": type(server_type().action_goal)}
        handle = client.send_goal(goal_class(mode=1, stepControl=[step_class(executeMode=1, data=0.5)]))
        handle.wait(timeout=20)
        assert handle.status.name == "SUCCEEDED"


def test_learned_from_the_header(nodes: tuple[Node, Node]) -> None:
    """A definition nobody bundled is taken from what the publisher says about itself."""
    here, robot = nodes
    ours = define("robot_msgs/State", "uint8 mode\nfloat32 speed")
    theirs = define("robot_msgs/State", "string mood\nfloat64 speed\nuint16 mode")
    publisher = robot.publisher("/state", theirs)
    subscriber = here.subscriber("/state", ours)
    publisher.wait_for_connection(timeout=20)
    publisher.publish(theirs(mode=3, speed=0.5, mood="calm"))
    message = subscriber.next(timeout=20)
    assert (message.mode, message.speed) == (3, 0.5)


def test_a_kind_that_changed_shows_both_definitions(nodes: tuple[Node, Node]) -> None:
    """Text for a number cannot be carried over: the subscriber's error has the two side by side."""
    here, robot = nodes
    ours = define("robot_msgs/State", "uint8 mode")
    theirs = define("robot_msgs/State", "string mode")
    robot.publisher("/state", theirs, latch=True).publish(theirs(mode="calm"))
    subscriber = here.subscriber("/state", ours)
    eventually(lambda: subscriber.errors)
    with pytest.raises(RosTimeout):
        subscriber.next(timeout=0.01)
    mismatch = next(e for e in subscriber.errors if isinstance(e, Md5sumMismatch))
    assert "uint8 mode" in str(mismatch)
    assert "string mode" in str(mismatch)


def test_another_type_is_no_revision(nodes: tuple[Node, Node]) -> None:
    """A topic with a different type altogether stays an error, though fields may be called alike."""
    here, robot = nodes
    robot.publisher("/t", "geometry_msgs/Point", latch=True).publish(x=1.0)
    subscriber = here.subscriber("/t", "geometry_msgs/Point32")
    eventually(lambda: subscriber.errors)
    with pytest.raises(RosTimeout):
        subscriber.next(timeout=0.01)
    assert isinstance(subscriber.errors[0], Md5sumMismatch)


def test_one_log_line_a_link(nodes: tuple[Node, Node], caplog: pytest.LogCaptureFixture) -> None:
    """What is dropped or defaulted is said once, not with every message."""
    here, robot = nodes
    ours = define("robot_msgs/State", "uint8 mode\nfloat32 speed")
    theirs = define("robot_msgs/State", "uint8 mode\nstring mood")
    publisher = robot.publisher("/state", theirs)
    with caplog.at_level(logging.WARNING, "rosproto.node"):
        subscriber = here.subscriber("/state", ours)
        publisher.wait_for_connection(timeout=20)
        for mode in range(3):
            publisher.publish(theirs(mode=mode, mood="calm"))
        assert [subscriber.next(timeout=20).mode for _ in range(3)] == [0, 1, 2]
    lines = [r.getMessage() for r in caplog.records if "another revision" in r.getMessage()]
    assert len(lines) == 1
    assert "mood" in lines[0]
    assert "speed" in lines[0]


def write_package(folder: Path, service: str) -> Path:
    """A folder with my_msgs: the service Ask and the message Note."""
    for kind, name, text in (("srv", "Ask", service), ("msg", "Note", "string text\n")):
        place = folder / "my_msgs" / kind
        place.mkdir(parents=True)
        (place / f"{name}.{kind}").write_text(text)
    return folder


def test_folders_of_the_user(tmp_path: Path) -> None:
    """A revision nobody knows becomes known by a folder of definitions; and so do types of one's own."""
    mine = write_package(tmp_path / "mine", "int32 a\n---\nint32 b\n")
    robots = write_package(tmp_path / "robots", "int64 a\nstring why\n---\nint64 b\n")
    ours = service_class("my_msgs/Ask", bundled().fork([mine]))
    theirs = service_class("my_msgs/Ask", bundled().fork([robots]))
    with (
        Master() as master,
        Node("/here", master_uri=master.uri, rosout=False, msg_path=[mine, robots]) as here,
        Node("/plain", master_uri=master.uri, rosout=False) as plain,
        Node("/robot", master_uri=master.uri, rosout=False) as robot,
        robot.service_server("/ask", theirs, lambda r: theirs.Response(b=r.a + 1)),
    ):
        with (
            plain.service_client("/ask", ours) as client,
            pytest.raises(Md5sumMismatch, match="woosh learn"),
        ):
            client.call(a=1, timeout=20)
        with here.service_client("/ask", "my_msgs/Ask") as client:
            assert client.md5sum == ours._md5sum
            assert client.call(a=1, timeout=20).b == 2
        here.publisher("/note", "my_msgs/Note", latch=True).publish(text="hello")
        assert plain.subscriber("/note", None).next(timeout=20).text == "hello"


def test_a_damaged_folder_does_no_harm(tmp_path: Path) -> None:
    """What cannot be read in one folder is passed over; the next one has the definition."""
    for name, text in (("broken", "this is ] no definition\n"), ("good", "int64 a\n---\nint64 b\n")):
        write_package(tmp_path / name, text)
    theirs = service_class("my_msgs/Ask", bundled().fork([tmp_path / "good"]))
    ours = service_class(
        "my_msgs/Ask", bundled().fork([write_package(tmp_path / "mine", "int8 a\n---\nint8 b")])
    )
    with (
        Master() as master,
        Node("/robot", master_uri=master.uri, rosout=False) as robot,
        robot.service_server("/ask", theirs, lambda r: theirs.Response(b=r.a + 1)),
        Node(
            "/h", master_uri=master.uri, rosout=False, msg_path=[tmp_path / "broken", tmp_path / "good"]
        ) as here,
        here.service_client("/ask", ours) as client,
    ):
        assert client.call(a=1, timeout=20).b == 2


def test_an_action_of_ones_own_in_a_folder(tmp_path: Path) -> None:
    """Its name is enough, as for messages and services."""
    place = tmp_path / "my_msgs" / "action"
    place.mkdir(parents=True)
    (place / "Fetch.action").write_text("string what\n---\nuint8 count\n---\n")
    with (
        Master() as master,
        Node("/here", master_uri=master.uri, rosout=False, msg_path=[tmp_path]) as here,
        ActionServer(here, "/fetch", "my_msgs/Fetch", lambda goal: goal.succeed()),
        ActionClient(here, "/fetch", "my_msgs/FetchAction") as client,
    ):
        client.wait_for_server(timeout=20)
        assert client.send_goal(client.type.goal(what="tea")).wait(timeout=20).count == 0


@pytest.fixture
def counting(monkeypatch: pytest.MonkeyPatch) -> Callable[[], int]:
    """How often a conversion was planned."""
    from rosproto.codec import conversion

    planned: list[int] = []
    original = conversion.Conversion.__init__

    def counted(self: Any, *args: Any) -> None:
        planned.append(1)
        original(self, *args)

    monkeypatch.setattr(conversion.Conversion, "__init__", counted)
    return lambda: len(planned)


def test_nothing_is_planned_when_the_sums_agree(
    nodes: tuple[Node, Node], counting: Callable[[], int]
) -> None:
    """The fast path never meets this machinery."""
    here, robot = nodes
    publisher = robot.publisher("/battery", Battery)
    subscriber = here.subscriber("/battery", Battery)
    publisher.wait_for_connection(timeout=20)
    publisher.publish(Battery(bmsStatus=1))
    subscriber.next(timeout=20)
    assert counting() == 0


def test_a_received_value_that_does_not_fit_costs_that_message_only(
    nodes: tuple[Node, Node], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is dropped, counted and told; the link stays, and raw subscribers get the bytes all the same."""
    here, robot = nodes
    told: list[Exception] = []
    # A robot that knows nothing of revisions: it refuses ours, and then sends its own to who takes anything.
    monkeypatch.setattr(robot.definitions, "message", lambda *given: None)
    publisher = robot.publisher("/parameter", PageParameter)
    raw = here.subscriber("/parameter", Parameter, raw=True)
    subscriber = here.subscriber("/parameter", Parameter, on_error=told.append)
    publisher.wait_for_connection(timeout=20)
    for value in (1.0, 0.5, 2.0):
        publisher.publish(PageParameter(pulsePerCircle=value))
    assert [subscriber.next(timeout=20).pulsePerCircle for _ in range(2)] == [1, 2]
    assert len([raw.next(timeout=20) for _ in range(3)]) == 3
    assert (subscriber.unfit, subscriber.stats()[0].reconnects) == (1, 0)
    assert "pulsePerCircle" in str(told[-1])
    assert subscriber.errors[-1] is told[-1]


def test_a_latched_message_that_does_not_fit_is_left_out(nodes: tuple[Node, Node]) -> None:
    """A late subscriber of another revision is connected without it."""
    here, robot = nodes
    publisher = here.publisher("/parameter", PageParameter, latch=True)
    publisher.publish(PageParameter(pulsePerCircle=0.5))
    subscriber = robot.subscriber("/parameter", Parameter)
    publisher.wait_for_connection(timeout=20)
    publisher.publish(PageParameter(pulsePerCircle=7.0))
    assert subscriber.next(timeout=20).pulsePerCircle == 7


def test_which_revision_subscribers_want(nodes: tuple[Node, Node]) -> None:
    """A program can ask before it sends, by the subscriber's name."""
    here, robot = nodes
    publisher = here.publisher("/battery", Battery)
    robot.subscriber("/battery", PageBattery)
    publisher.wait_for_connection(timeout=20)
    assert publisher.revisions == {"/robot": PageBattery}
    here.subscriber("/battery", Battery)
    publisher.wait_for_connection(timeout=20, count=2)
    assert publisher.revisions == {"/robot": PageBattery, "/here": Battery}


def test_a_message_of_another_type_is_refused_also_with_revised_subscribers(nodes: tuple[Node, Node]) -> None:
    """The mistake is told as it is without them."""
    here, robot = nodes
    publisher = here.publisher("/battery", Battery)
    old = robot.subscriber("/battery", PageBattery)
    publisher.wait_for_connection(timeout=20)
    with pytest.raises(CodecError, match="not as geometry_msgs/Point"):
        publisher.publish(message_class("geometry_msgs/Point")())
    publisher.publish(batteryPercentage=3)
    assert old.next(timeout=20).batteryPercentage == 3


def test_a_lossless_client_sends_nothing_that_would_be_dropped(
    nodes: tuple[Node, Node], tmp_path: Path
) -> None:
    """A value without a place is an error before the request; defaults may be left out."""
    here, robot = nodes
    new, old = "int32 a\nint32 extra\n---\nint32 b", "int32 a\n---\nint32 b"
    ours, theirs = (service_class("my_msgs/Ask", library_with("my_msgs/Ask", text)) for text in (new, old))
    (tmp_path / "my_msgs/srv").mkdir(parents=True)
    (tmp_path / "my_msgs/srv/Ask.srv").write_text(old)
    here.definitions = KnownDefinitions([tmp_path])
    calls: list[Any] = []

    def handler(request: Any) -> Any:
        calls.append(request)
        return theirs.Response(b=request.a)

    with robot.service_server("/ask", theirs, handler), here.service_client("/ask", ours) as client:
        assert client.call(a=1, extra=2, timeout=20).b == 1
        client.lossless = True
        assert client.call(a=1, timeout=20).b == 1
        with pytest.raises(ValuesLost, match="extra") as caught:
            client.call(a=1, extra=2, timeout=20)
        assert caught.value.fields == ["extra"]
        assert len(calls) == 2


def library_with(name: str, text: str) -> Any:
    """A library with one service more than the bundled ones."""
    from rosproto.msg import parse_service

    library = bundled().fork()
    library.add(parse_service(text, name))
    return library


@pytest.mark.parametrize(
    ("angles", "lost"), [((0.0, 0.0), []), ((0.0, 0.5), ["action_goal.goal.stepControl.angle"])]
)
def test_what_is_lost_is_seen_inside_arrays(angles: tuple[float, float], lost: list[str]) -> None:
    """A field counts when any element holds something else than its default."""
    new = message_class("woosh_msgs/StepControlAction")
    conversion = Conversion(new, revision("woosh_msgs/StepControlAction", "1.1.0"))
    message = new()
    step = message_class("woosh_msgs/StepControl")
    message.action_goal.goal.stepControl = [step(angle=angle) for angle in angles]
    assert conversion.lost(message) == lost


@pytest.fixture
def mute_subscribers(monkeypatch: pytest.MonkeyPatch) -> None:
    """Subscribers that do not send their definition, as roscpp's."""
    from rosproto.node.incoming import tcpros_link

    def header(**fields: Any) -> dict[str, str]:
        return subscriber_header(**{**fields, "message_definition": ""})

    monkeypatch.setattr(tcpros_link, "subscriber_header", header)


@pytest.mark.parametrize("told", [True, False])
def test_a_definition_is_asked_of_another_publisher(told: bool, mute_subscribers: None) -> None:
    """The robot's own client of an action server knows what the server wants, and tells everybody."""
    ours = define("robot_msgs/Goal", "uint8 mode\nfloat32 speed")
    theirs = define("robot_msgs/Goal", "string id\nfloat32 speed\nuint8 mode")
    with (
        Master() as master,
        Node("/server", master_uri=master.uri, rosout=False, intraprocess=False) as server,
        Node("/client", master_uri=master.uri, rosout=False, intraprocess=False) as client,
        Node("/here", master_uri=master.uri, rosout=False, intraprocess=False) as here,
    ):
        if told:
            client.publisher("/goal", theirs)
        goals = server.subscriber("/goal", theirs)
        if not told:
            # It comes to know our definition from us, and converts; but its md5sum is asked for first.
            publisher = here.publisher("/goal", ours)
            publisher.wait_for_connection(timeout=20)
            assert publisher.revisions == {"/server": ours}
            return
        goals.wait_for_connection(timeout=20)
        publisher = here.publisher("/goal", ours)
        publisher.wait_for_connection(timeout=20)
        assert publisher.revisions["/server"]._md5sum == theirs._md5sum
        publisher.publish(mode=3, speed=0.5)
        message = goals.next(timeout=20)
        assert (message.id, message.speed, message.mode) == ("", 0.5, 3)


def test_strangers_do_not_keep_us_asking() -> None:
    """The same question is not asked again at once, and not ever more different ones."""
    known, asked = KnownDefinitions(), []

    def get_system_state(**options: Any) -> SystemState:
        asked.append(options)
        return SystemState({}, {}, {})

    caller: Any = SimpleNamespace(name="/us", master=SimpleNamespace(get_system_state=get_system_state))
    for _ in range(2):
        assert known.fetch(caller, "/t", Battery, "0") is None
    assert len(asked) == 1
    for i in range(1000):
        assert known.fetch(caller, "/t", Battery, str(i)) is None
    assert len(asked) == 200


def test_a_read_of_which_no_message_fits(nodes: tuple[Node, Node], monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside raw subscribers an unfit message that arrives alone is dropped alone: the link stays."""
    here, robot = nodes
    monkeypatch.setattr(robot.definitions, "message", lambda *given: None)
    publisher = robot.publisher("/parameter", PageParameter)
    raw = here.subscriber("/parameter", Parameter, raw=True)
    subscriber = here.subscriber("/parameter", Parameter)
    publisher.wait_for_connection(timeout=20)
    for value in (0.5, 2.0):
        publisher.publish(PageParameter(pulsePerCircle=value))
        raw.next(timeout=20)  # so each comes in a read of its own
    assert subscriber.next(timeout=20).pulsePerCircle == 2
    assert subscriber.stats()[0].reconnects == 0


def test_a_new_subscriber_is_not_offered_a_read_of_which_no_message_fits() -> None:
    """An unfit message that arrives while a subscriber is added is left out; the link's thread goes on."""
    revised = RevisedType(PageParameter, TopicType(Parameter))
    added = [
        SubscriberQueue("/p", revised, queue_size=1, raw=raw, renew=lambda: None) for raw in (True, False)
    ]
    before, now = (RevisedDelivery(queues, revised, lambda errors: None) for queues in ([], added))
    now.deliver_to_newcomers(before, [UnconvertibleMessage(CodecError("does not fit"))], {})
    assert [queue.inbox.received for queue in added] == [0, 0]
