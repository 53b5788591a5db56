"""The slave API of a node: exact reply shapes, and whose words are believed."""

from __future__ import annotations

import os
import threading
import xmlrpc.client
from collections.abc import Iterable, Iterator
from typing import Any

import pytest

from rosproto.errors import MasterError, RosError
from rosproto.master import Master
from rosproto.node import Node
from rosproto.node.graph.registrations import Registrations
from rosproto.node.graph.slave_api import SlaveApi
from rosproto.protocol.xmlrpc import Fault
from rosproto.transport.uri import parse_uri
from tests.support.slave_caller import Caller, require_second_address


class FakeMaster:
    """Answers lookupNode."""

    uri = "http://10.0.0.7:11311/"

    def __init__(self, answer: str | Exception) -> None:
        self.answer = answer

    def lookup_node(self, name: str) -> str:
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


class FakeTopics:
    """Notes what it is told."""

    def __init__(self) -> None:
        self.told: list[Any] = []

    def publications(self) -> list[list[str]]:
        return [["/a", "std_msgs/String"]]

    def subscriptions(self) -> list[list[str]]:
        return [["/b", "std_msgs/String"]]

    def bus_info(self) -> list[list[Any]]:
        return []

    def bus_stats(self) -> list[list[Any]]:
        return [[], [], []]

    def is_published(self, topic: str) -> bool:
        return topic == "/a"

    def request_datagrams(self, topic, request):
        raise RosError("not here")

    def update_publishers(self, topic: str, uris: list[str]) -> None:
        self.told.append(("update", topic, uris))

    def verify_publishers(self, topic: str) -> None:
        self.told.append(("verify", topic))


def api(
    answer: str | Exception = "http://10.0.0.2:5/", *, allow: bool = True
) -> tuple[SlaveApi, FakeTopics, list[str]]:
    topics, ended = FakeTopics(), []
    slave = SlaveApi(
        name="/n",
        master=FakeMaster(answer),  # type: ignore[arg-type]
        topics=topics,
        own_uri=lambda: "http://10.0.0.2:5/",
        tcpros_address=lambda: ("10.0.0.2", 6),
        is_master_address=lambda host: host == "10.0.0.7",
        shut_down=ended.append,
        allow_shutdown=allow,
    )
    return slave, topics, ended


@pytest.mark.parametrize(
    ("method", "params", "reply"),
    [
        ("getPid", ["/c"], [1, "", os.getpid()]),
        ("getName", ["/c"], [1, "", "/n"]),
        ("getUri", ["/c"], [1, "", "http://10.0.0.2:5/"]),
        ("getMasterUri", ["/c"], [1, FakeMaster.uri, FakeMaster.uri]),
        ("getPublications", ["/c"], [1, "publications", [["/a", "std_msgs/String"]]]),
        ("getSubscriptions", ["/c"], [1, "subscriptions", [["/b", "std_msgs/String"]]]),
        ("getBusStats", ["/c"], [1, "bus stats", [[], [], []]]),
        ("getBusInfo", ["/c"], [1, "bus info", []]),
        ("requestTopic", ["/c", "/a", [["TCPROS"]]], [1, "ready on 10.0.0.2:6", ["TCPROS", "10.0.0.2", 6]]),
        (
            "requestTopic",
            ["/c", "/a", [["UDPROS", "x"], 7, [], ["TCPROS"]]],
            [1, "ready on 10.0.0.2:6", ["TCPROS", "10.0.0.2", 6]],
        ),
        ("requestTopic", ["/c", "/a", [["SHM"]]], [0, "no supported protocol implementations", []]),
        ("requestTopic", ["/c", "/zzz", [["TCPROS"]]], [-1, "Not a publisher of [/zzz]", []]),
        ("paramUpdate", ["/c", "/p", 1], [-1, "not subscribed to [/p]", 0]),
    ],
)
def test_reply_shapes(method: str, params: list[Any], reply: list[Any]) -> None:
    """wiki.ros.org/ROS/Slave_API."""
    assert api()[0].dispatch(method, params, "10.0.0.9") == reply


@pytest.mark.parametrize(
    ("method", "params"),
    [
        ("getPid", []),
        ("getPid", [5]),
        ("getPid", ["/c", "too much"]),
        ("requestTopic", ["/c", "/a"]),
        ("requestTopic", ["/c", 5, [["TCPROS"]]]),
        ("requestTopic", ["/c", "/a", []]),
        ("requestTopic", ["/c", "/a", "TCPROS"]),
        ("publisherUpdate", ["/c", "/b", "http://x:1"]),
        ("publisherUpdate", ["/c", "/b", ["no uri"]]),
        ("publisherUpdate", ["/c", "/b", [5]]),
        ("publisherUpdate", ["/c", {}, []]),
        ("paramUpdate", ["/c", "", 5]),
    ],
)
def test_wrong_arguments_are_the_callers_mistake(method: str, params: list[Any]) -> None:
    """Code -1, three elements, nothing happens."""
    slave, topics, _ = api()
    code, text, _ = slave.dispatch(method, params, "10.0.0.7")  # type: ignore[misc]
    assert code == -1
    assert text
    assert topics.told == []


def test_an_unknown_method_is_a_fault() -> None:
    """As every XML-RPC server has it."""
    with pytest.raises(Fault):
        api()[0].dispatch("format", ["/c"], "10.0.0.9")


@pytest.mark.promise("are checked with the master")
def test_publisher_updates_count_from_the_master_only() -> None:
    """From elsewhere they are a hint to ask the master. Always answered with 1."""
    slave, topics, _ = api()
    params = ["/master", "/b", ["http://10.0.0.3:7/"]]
    assert slave.dispatch("publisherUpdate", params, "10.0.0.7") == [1, "", 0]
    assert slave.dispatch("publisherUpdate", params, "10.0.0.66") == [1, "", 0]
    assert topics.told == [("update", "/b", ["http://10.0.0.3:7/"]), ("verify", "/b")]


def test_param_updates_are_marked_with_whom_they_came_from() -> None:
    """The cache decides what to do with one it cannot trust."""
    slave, _, _ = api()
    seen: list[Any] = []
    slave.on_parameter_update = lambda *update: bool(seen.append(update)) or True
    for peer in ("10.0.0.7", "10.0.0.66"):
        assert slave.dispatch("paramUpdate", ["/master", "/p/", {}], peer) == [1, "", 0]
    assert seen == [("/p/", {}, True), ("/p/", {}, False)]


@pytest.mark.promise(
    "is obeyed only when the master no longer knows our URI", "The master ends a node whose name is"
)
def test_a_shutdown_in_the_masters_name_is_checked() -> None:
    """Obeyed when the name is no longer ours; not when the master still has us, or cannot be asked."""
    for answer, obeyed in (
        ("http://10.0.0.2:5", False),
        ("http://10.0.0.99:1/", True),
        (MasterError("lookupNode", -1, "unknown node"), True),
    ):
        slave, _, ended = api(answer)
        code, text, _ = slave.dispatch("shutdown", ["/master", "new node"], "10.0.0.66")  # type: ignore[misc]
        assert (code == 1) is obeyed, text
        assert bool(ended) is obeyed


@pytest.mark.promise("`allow_shutdown=False` refuses `rosnode kill` too")
def test_a_shutdown_by_a_person_is_obeyed_unless_it_is_not_allowed() -> None:
    """`rosnode kill`; the refusal says why."""
    slave, _, ended = api()
    assert slave.dispatch("shutdown", ["/rosnode", "user request"], "10.0.0.9") == [1, "shutdown", 0]
    assert "user request" in ended[0]
    slave, _, ended = api(allow=False)
    code, text, _ = slave.dispatch("shutdown", ["/rosnode"], "10.0.0.9")  # type: ignore[misc]
    assert (code, ended) == (0, [])
    assert "allow_shutdown" in text


# -- over the wire ------------------------------------------------------------------------------------------


@pytest.fixture
def pair() -> Iterator[tuple[Node, Node]]:
    with (
        Master() as master,
        Node("/pub", master_uri=master.uri) as a,
        Node("/sub", master_uri=master.uri) as b,
    ):
        yield a, b


def test_bus_info_and_stats_of_a_live_link(pair: tuple[Node, Node]) -> None:
    """Rows of seven as rosnode info reads them; counters as the wiki has them."""
    a, b = pair
    publisher = a.publisher("/t", "std_msgs/String")
    subscriber = b.subscriber("/t", "std_msgs/String")
    publisher.wait_for_connection()
    publisher.publish(data="12345")
    subscriber.next(20)
    out = xmlrpc.client.ServerProxy(a.uri)
    into = xmlrpc.client.ServerProxy(b.uri)
    (row,) = [row for row in out.getBusInfo("/test")[2] if row[4] == "/t"]  # type: ignore[index,misc,union-attr]
    assert row[1:6] == ["/sub", "o", "INTRAPROCESS", "/t", True]
    assert isinstance(row[0], int)
    assert isinstance(row[6], str)
    (row,) = into.getBusInfo("/test")[2]  # type: ignore[index,misc]
    assert row[1:6] in ([a.uri, "i", "INTRAPROCESS", "/t", True],)
    code, _, (published, subscribed, services) = out.getBusStats("/test")  # type: ignore[misc]
    assert (code, subscribed, services) == (1, [], [])
    (entry,) = [entry for entry in published if entry[0] == "/t"]
    assert entry[1] == 13
    assert entry[2][0][1:] == [13, 1, True]
    (entry,) = into.getBusStats("/test")[2][1]  # type: ignore[index]
    assert entry[0] == "/t"
    assert entry[1][0][1:] == [13, -1, True]
    out("close")()
    into("close")()


def test_rosnode_kill_closes_the_node(pair: tuple[Node, Node]) -> None:
    """The call is answered, then the node goes, with the reason known."""
    a, _ = pair
    reasons: list[str] = []
    a.on_shutdown(reasons.append)
    with xmlrpc.client.ServerProxy(a.uri) as proxy:
        assert proxy.shutdown("/rosnode", "enough") == [1, "shutdown", 0]
    assert a.wait(20)
    assert a.closed
    assert "enough" in reasons[0]


@pytest.mark.promise("are checked with the master", "A `publisherUpdate` may come before the answer of")
def test_a_forged_publisher_update_is_put_right_by_the_master(
    pair: tuple[Node, Node], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A list from elsewhere changes nothing but that the master is asked."""
    require_second_address()
    a, b = pair
    publisher = a.publisher("/t", "std_msgs/String")
    subscriber = b.subscriber("/t", "std_msgs/String")
    publisher.wait_for_connection()
    asked = threading.Event()
    announce = Registrations.announce_again

    def noted(self: Registrations, registrations: Iterable[Any]) -> None:
        some = list(registrations)
        announce(self, some)
        if some:
            asked.set()

    monkeypatch.setattr(Registrations, "announce_again", noted)
    with Caller(parse_uri(b.uri)) as stranger:
        assert stranger.call("publisherUpdate", "/master", "/t", []) == [1, "", 0]
    assert asked.wait(5)
    assert subscriber.connections == 1
    assert len(subscriber.stats()) == 1
