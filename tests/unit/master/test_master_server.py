"""A master over real connections: notifications, duplicate names, embedding, hostile callers."""

from __future__ import annotations

import contextlib
import socket
import subprocess
import sys
import threading
import time
import xmlrpc.client
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from rosproto.errors import ConnectionLost, MasterError
from rosproto.master import Master
from rosproto.node.graph.master_client import MasterClient
from rosproto.protocol.wire_limits import Limits
from tests.support.ports import unused_port
from tests.support.slaves import BlackHole, RecordingNode
from tests.support.waiting import until

DEADLINE = 20.0


@pytest.fixture
def master() -> Iterator[Master]:
    with Master(call_timeout=2.0) as master:
        yield master


@pytest.fixture
def client(master: Master) -> Iterator[MasterClient]:
    with MasterClient(master.uri, "/tester") as client:
        yield client


def as_node(master: Master, name: str) -> MasterClient:
    return MasterClient(master.uri, name)


# -- what roscore sets, system methods -----------------------------------------------------------------------


def test_it_starts_as_roscore_does(client: MasterClient) -> None:
    """roslaunch wants /run_id, tools want the other two."""
    assert client.get_param("/rosdistro") == "noetic\n"
    assert str(client.get_param("/rosversion")).endswith("\n")
    assert len(str(client.get_param("/run_id"))) == 36
    assert client.get_system_state() == ({}, {}, {})


def test_the_uri_is_known_everywhere(master: Master, client: MasterClient) -> None:
    """Attribute, getUri, and the socket agree."""
    assert client.get_uri() == master.uri == f"http://127.0.0.1:{master.port}/"


def test_unknown_methods_are_faults_and_known_ones_are_listed(client: MasterClient) -> None:
    """rosmaster has no listMethods; everything it does have is in ours."""
    with pytest.raises(MasterError, match='method "nonsense" is not supported'):
        client.call("nonsense")
    with xmlrpc.client.ServerProxy(client.get_uri()) as proxy:
        methods: Any = proxy.system.listMethods()
    assert {"registerPublisher", "getParam", "shutdown", "system.multicall"} <= set(methods)


@pytest.mark.promise("rospy leaves the graph by `system.multicall`")
def test_many_calls_in_one_keep_their_order_and_their_errors(client: MasterClient) -> None:
    """system.multicall: rospy unregisters everything through it."""
    answers = client.multicall([("setParam", ("/x", 1)), ("getParam", ("/x",)), ("getParam", ("/y",))])
    assert answers[:2] == [0, 1]
    assert isinstance(answers[2], MasterError)
    assert answers[2].code == -1


# -- fan-out -------------------------------------------------------------------------------------------------


def test_subscribers_hear_of_publishers_and_parameters(master: Master) -> None:
    """publisherUpdate and paramUpdate over the wire, from /master."""
    with RecordingNode() as node, as_node(master, "/s") as me, as_node(master, "/p") as other:
        me.register_subscriber("/t", "std_msgs/String", node.uri)
        me.subscribe_param("/k", node.uri)
        other.register_publisher("/t", "std_msgs/String", "http://127.0.0.1:1/")
        other.set_param("/k/x", {"y": [1, 2.5, "z", True]})
        other.unregister_publisher("/t", "http://127.0.0.1:1/")
        node.wait_for(lambda n: ("publisherUpdate", ["/t", []]) in n.calls)
        assert node.told("paramUpdate") == [["/k/x/", {"y": [1, 2.5, "z", True]}]]


def test_a_silent_subscriber_delays_nobody() -> None:
    """Neither the registering node nor the other subscribers wait for one that never answers.

    Whoever did would wait for a minute, longer than anything here has patience.
    """
    with (
        Master(call_timeout=60.0) as master,
        BlackHole() as hole,
        RecordingNode() as node,
        as_node(master, "/p") as publisher,
    ):
        with as_node(master, "/silent") as silent, as_node(master, "/s") as healthy:
            silent.register_subscriber("/t", "*", hole.uri)
            healthy.register_subscriber("/t", "*", node.uri)
        for number in range(20):
            publisher.register_publisher("/t", "std_msgs/String", "http://127.0.0.1:1/")
            publisher.unregister_publisher("/t", "http://127.0.0.1:1/")
            publisher.register_publisher(f"/other{number}", "std_msgs/String", "http://127.0.0.1:1/")
        node.wait_for(lambda n: len(n.told("publisherUpdate")) > 0)


def test_a_hundred_silent_subscribers_delay_nobody(master: Master) -> None:
    """More than there are worker threads, each with a URI of its own: the next waits for one of them, not for all."""
    with contextlib.ExitStack() as stack:
        holes = [stack.enter_context(BlackHole(1)) for _ in range(100)]
        node = stack.enter_context(RecordingNode())
        me = stack.enter_context(as_node(master, "/p"))
        for number, hole in enumerate(holes):
            stack.enter_context(as_node(master, f"/s{number}")).register_subscriber("/t", "*", hole.uri)
        me.register_publisher("/t", "std_msgs/String", "http://127.0.0.1:1/")
        stack.enter_context(as_node(master, "/healthy")).register_subscriber("/u", "*", node.uri)
        me.register_publisher("/u", "std_msgs/String", "http://127.0.0.1:1/")
        node.wait_for(lambda n: n.told("publisherUpdate") == [["/u", ["http://127.0.0.1:1/"]]])
        assert master.stats()["threads"] <= 72
        begun = time.monotonic()
        master.close()
        assert time.monotonic() - begun < 30.0  # all of them, one after the other, would be two hundred


def test_a_busy_subscriber_gets_the_newest_list_only(master: Master) -> None:
    """While it answers one call, the lists in between are skipped."""
    with RecordingNode() as node, as_node(master, "/s") as me, as_node(master, "/p") as publisher:
        node.hold = threading.Event()
        me.register_subscriber("/t", "*", node.uri)
        publisher.register_publisher("/t", "a/B", "http://127.0.0.1:1/")
        node.wait_for(lambda n: len(n.calls) == 1)
        for number in range(2, 30):
            as_node(master, f"/p{number}").register_publisher("/t", "a/B", f"http://127.0.0.1:{number}/")
        node.hold.set()
        assert master.flush(DEADLINE)
        lists = [params[1] for params in node.told("publisherUpdate")]
        assert len(lists) == 2
        assert lists[-1] == [f"http://127.0.0.1:{number}/" for number in range(1, 30)]


# -- duplicate names -----------------------------------------------------------------------------------------


def _take_over(master: Master, old: RecordingNode, topics: tuple[str, ...] = ("/rosout", "/t")) -> None:
    """Register /n at `old`'s URI, then from somewhere else; wait until the master has done about it."""
    with as_node(master, "/n") as first, as_node(master, "/n") as second:
        for topic in topics:
            first.register_publisher(topic, "a/B", old.uri)
        second.register_publisher("/rosout", "a/B", "http://127.0.0.1:1/")
    assert master.flush(DEADLINE)


REASON = ["[/n] Reason: new node registered with same name"]


@pytest.mark.parametrize(
    ("old", "is_shut_down"),
    [
        pytest.param({"name": "/n"}, True, id="rospy, the same node"),
        pytest.param({"name": "/innocent"}, False, id="rospy, another node on that port"),
        pytest.param({"callerid": "/n", "publications": ("/rosout", "/t")}, True, id="roscpp, the same node"),
        pytest.param(
            {"callerid": "/innocent", "publications": ("/rosout", "/t")}, False, id="roscpp, another node"
        ),
        pytest.param({"publications": ("/rosout", "/t")}, True, id="no name to get, but the same topics"),
        pytest.param({"publications": ("/rosout", "/u")}, False, id="no name to get, other topics"),
        pytest.param({}, False, id="knows nothing"),
    ],
)
def test_the_old_holder_of_a_name_is_shut_down_if_it_still_is_that_node(
    master: Master, old: dict[str, object], is_shut_down: bool
) -> None:
    """Ports are used again (ros_comm#2241): an innocent node that got the old one's lives on."""
    with RecordingNode(**old) as node:  # type: ignore[arg-type]
        _take_over(master, node)
        assert node.told("shutdown") == ([REASON] if is_shut_down else [])


def test_topics_that_everybody_has_prove_nothing(master: Master) -> None:
    """A node known for /rosout only, which cannot be asked for its name, is left alone."""
    with RecordingNode(publications=("/rosout",)) as node:
        _take_over(master, node, ("/rosout",))
        assert node.told("shutdown") == []


def test_a_uri_that_belongs_to_another_registered_node_is_not_even_asked(master: Master) -> None:
    """The master knows already who lives there now."""
    with RecordingNode(name="/n") as node:
        with as_node(master, "/innocent") as innocent:
            innocent.register_publisher("/x", "a/B", node.uri)
        _take_over(master, node)
        assert node.calls == []


def test_a_dead_old_holder_costs_nothing(master: Master) -> None:
    """Nobody listens at the old URI any more: the usual case after a crash."""
    with RecordingNode() as node:
        pass
    _take_over(master, node)
    assert master.stats()["nodes"] == 0


# -- address and end -----------------------------------------------------------------------------------------


def test_a_taken_port_names_the_address(master: Master) -> None:
    """And says what to do."""
    with pytest.raises(ConnectionLost, match=rf"127\.0\.0\.1:{master.port}.*port is taken"):
        Master(port=master.port)


@pytest.mark.parametrize("host", ["0.0.0.0", ""])
def test_a_wildcard_host_gives_a_reachable_uri(host: str) -> None:
    """Nobody can connect to 0.0.0.0."""
    with Master(host) as master:
        assert "0.0.0.0" not in master.uri
        with MasterClient(master.uri, "/t") as client:
            assert client.get_uri() == master.uri


@pytest.mark.parametrize(("host", "called"), [("0.0.0.0", "127.0.0.1"), ("", "127.0.0.1"), ("::", "[::1]")])
def test_get_uri_of_a_wildcard_is_where_the_caller_called(host: str, called: str) -> None:
    """The default route's address may belong to a network that the caller is not in."""
    with contextlib.ExitStack() as stack:
        try:
            master = stack.enter_context(Master(host))
        except ConnectionLost as error:
            pytest.skip(f"no IPv6 here: {error}")
        uri = f"http://{called}:{master.port}/"
        client = stack.enter_context(MasterClient(uri, "/t"))
        assert client.get_uri() == uri
        assert client.multicall([("getUri", ())]) == [uri]
        with pytest.raises(MasterError, match="getUri"):  # a wrong call has no URI to be changed
            client.call("getUri", "too", "much")


def test_an_advertised_host_is_in_the_uri() -> None:
    """For address translation and names."""
    with Master(advertise="robot.local") as master:
        assert master.uri == f"http://robot.local:{master.port}/"
    with (
        Master("0.0.0.0", advertise="robot.local") as master,
        MasterClient(f"http://127.0.0.1:{master.port}", "/t") as client,
    ):
        assert client.get_uri() == master.uri == f"http://robot.local:{master.port}/"


def test_ipv6(request: pytest.FixtureRequest) -> None:
    """Brackets in the URI, and it answers."""
    with contextlib.ExitStack() as stack:
        try:
            master = stack.enter_context(Master("::1"))
        except ConnectionLost as error:
            pytest.skip(f"no IPv6 here: {error}")
        assert master.uri == f"http://[::1]:{master.port}/"
        assert stack.enter_context(MasterClient(master.uri, "/t")).get_uri() == master.uri


@pytest.mark.promise("`allow=` takes a list of addresses")
def test_only_allowed_addresses_may_connect() -> None:
    """Others are cut off before a byte is read."""
    with (
        Master(allow=["10.0.0.1"]) as master,
        MasterClient(master.uri, "/t") as client,
        pytest.raises(ConnectionLost),
    ):
        client.get_pid()


def test_close_is_idempotent_and_frees_the_port() -> None:
    """A master can be started again at once on the same port."""
    for _ in range(3):
        with Master(port=unused_port()) as master:
            with MasterClient(master.uri, "/t") as client:
                client.get_pid()
            master.close()
            assert master.closed
        with Master(port=master.port) as again:
            assert again.port == master.port


def test_many_masters_come_and_go_without_a_trace() -> None:
    """Threads and registrations are each master's own; nothing is left."""
    before = threading.active_count()
    masters = [Master() for _ in range(20)]
    for number, master in enumerate(masters):
        with MasterClient(master.uri, f"/n{number}") as client:
            client.register_publisher("/t", "a/B", "http://127.0.0.1:1/")
            assert list(client.get_system_state().publishers.values()) == [[f"/n{number}"]]
    for master in masters:
        master.close()
    assert threading.active_count() <= before


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="counts sockets in /proc")
def test_fifty_lives_leave_no_socket_behind() -> None:
    """Each with a caller, a subscriber to tell, and a silent one."""

    def life() -> None:
        with contextlib.ExitStack() as stack:
            master = stack.enter_context(Master(call_timeout=5.0))
            node, hole = stack.enter_context(RecordingNode()), stack.enter_context(BlackHole())
            me, silent = (stack.enter_context(as_node(master, name)) for name in ("/s", "/silent"))
            me.register_subscriber("/t", "*", node.uri)
            silent.register_subscriber("/t", "*", hole.uri)
            silent.register_publisher("/t", "a/B", hole.uri)
            node.wait_for(lambda n: len(n.calls) == 1)

    life()
    before = len(list(Path("/proc/self/fd").iterdir())), threading.active_count()
    for _ in range(50):
        life()
    until(lambda: len(list(Path("/proc/self/fd").iterdir())) <= before[0], what="the end of the last socket")
    until(lambda: threading.active_count() <= before[1], what="the end of the last thread")


def test_shutdown_is_answered_and_obeyed_where_allowed() -> None:
    """The reply comes before the end."""
    with Master() as master, MasterClient(master.uri, "/t") as client:
        client.shutdown("bye")
        assert master.wait(DEADLINE)
    with Master(allow_shutdown=False) as master, MasterClient(master.uri, "/t") as client:
        with pytest.raises(MasterError, match="not allowed"):
            client.shutdown("bye")
        assert not master.closed


# -- load and hostility --------------------------------------------------------------------------------------


def test_thousands_of_registrations_from_many_threads(master: Master) -> None:
    """4000 registrations in parallel: all there."""

    def register(worker: int) -> None:
        with as_node(master, f"/n{worker}") as node:
            calls = [
                ("registerPublisher", (f"/t{i}", "a/B", f"http://127.0.0.1:{worker + 1}/"))
                for i in range(500)
            ]
            assert all(not isinstance(answer, Exception) for answer in node.multicall(calls, timeout=60.0))

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(register, range(8)))
    with as_node(master, "/q") as client:
        state = client.get_system_state()
        assert len(state.publishers) == 500
        assert all(len(nodes) == 8 for nodes in state.publishers.values())
    assert master.stats()["registrations"] == 4000


def _post(master: Master, body: bytes, head: bytes = b"") -> bytes:
    """Send a request as it is; whatever comes back until the server closes or a response is complete."""
    default = b"POST / HTTP/1.1\r\nHost: x\r\nContent-Type: text/xml\r\nConnection: close\r\nContent-Length: %d\r\n\r\n"
    with socket.create_connection(("127.0.0.1", master.port), DEADLINE) as sock:
        sock.sendall((head or default % len(body)) + body)
        received = b""
        while chunk := sock.recv(65536):
            received += chunk
        return received


CALL = b"<?xml version='1.0'?>%s<methodCall><methodName>%s</methodName><params>%s</params></methodCall>"
ME = b"<param><value>/n</value></param>"
KEY = b"<param><value>/k</value></param>"
ENTITIES = b"<!DOCTYPE b [<!ENTITY a 'aaaaaaaaaa'><!ENTITY b '&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;'>]>"


@pytest.mark.promise("gives a value or a documented error on *that one* connection")
@pytest.mark.parametrize(
    ("request_bytes", "answer"),
    [
        pytest.param((CALL % (ENTITIES, b"getPid", b"<param><value>&b;</value></param>"),), b"<fault>", id="entity bomb"),
        pytest.param((CALL % (b"", b"setParam", ME + KEY + b"<param>" + b"<value><array><data>" * 100_000),), b"<fault>", id="100000 arrays"),
        pytest.param((CALL % (b"", b"setParam", ME + KEY + b"<param><value><i8>99999999999</i8></value></param>"),), b"-1", id="huge int"),
        pytest.param((CALL % (b"", b"setParam", ME + KEY + b"<param><value><int>" + b"9" * 100_000 + b"</int></value></param>"),), b"<fault>", id="absurd int"),
        pytest.param((CALL % (b"", b"setParam", ME + KEY + b"<param><value><nil/></value></param>"),), b"must be specified", id="nil"),
        pytest.param((CALL % (b"", b"getParam", b""),), b"missing required caller_id", id="no params"),
        pytest.param((b"<methodCall><methodName>getPid</methodName></methodCall>",), b"missing required caller_id", id="no params element"),
        pytest.param((b"not xml at all",), b"<fault>", id="garbage"),
        pytest.param((b"",), b"HTTP/1.1", id="empty body"),
        pytest.param((b"", b"GET / HTTP/1.1\r\nHost: x\r\n\r\n"), b"405", id="GET"),
        pytest.param((b"", b"POST /foo HTTP/1.1\r\nHost: x\r\nConnection: close\r\nContent-Length: 0\r\n\r\n"), b"404", id="other path"),
        pytest.param((b"", b"POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 99999999999\r\n\r\n"), b"413", id="absurd length"),
        pytest.param((b"", b"\x00\xff\r\n\r\n"), b"400", id="no HTTP"),
    ],
)  # fmt: skip
def test_hostile_requests_cost_their_own_connection_only(
    master: Master, client: MasterClient, request_bytes: tuple[bytes, ...], answer: bytes
) -> None:
    """Each gets an error; the master answers the next caller and stored nothing."""
    assert answer in _post(master, *request_bytes)
    assert not client.has_param("/k")


def test_a_chunked_request_is_understood(master: Master) -> None:
    """rosmaster answers 500, roscpp hangs up."""
    body = CALL % (b"", b"getPid", ME)
    head = b"POST /RPC2 HTTP/1.1\r\nHost: x\r\nConnection: close\r\nTransfer-Encoding: chunked\r\n\r\n"
    chunks = b"".join(
        b"%x\r\n%s\r\n" % (len(body[i : i + 7]), body[i : i + 7]) for i in range(0, len(body), 7)
    )
    assert b"<int>" in _post(master, chunks + b"0\r\n\r\n", head)


def test_a_parameter_as_deep_as_allowed_can_be_read_in_every_way() -> None:
    """The bound on depth leaves room for the reply and a multicall around it."""
    limits = Limits(xml_depth=12)
    with Master(limits=limits) as master, MasterClient(master.uri, "/t", limits=limits) as client:
        client.set_param("/1/2/3/4/5/6/7/8", 5)
        assert client.get_param("/1/2/3") == {"4": {"5": {"6": {"7": {"8": 5}}}}}
        tree = client.multicall([("getParam", ("/",))])[0]
        assert tree["1"]["2"]["3"]["4"]["5"]["6"]["7"]["8"] == 5  # type: ignore[index]
        with pytest.raises(MasterError, match="nested too deep"):
            client.set_param("/1/2/3/4/5/6/7/8/9", 5)


def test_a_thousand_silent_connections_leave_room() -> None:
    """Connections that never send a byte are dropped oldest first."""
    limits = Limits(pending_handshakes=20)
    with Master(limits=limits) as master, contextlib.ExitStack() as stack:
        for _ in range(300):
            stack.enter_context(socket.create_connection(("127.0.0.1", master.port), DEADLINE))
        with MasterClient(master.uri, "/t") as client:
            assert client.get_uri() == master.uri
        # The threads of those that were dropped end in their time.
        until(lambda: master.stats()["connections"] <= 30, DEADLINE, master.stats)


FEW_FILES = """
import resource, sys
from rosproto.master import Master
resource.setrlimit(resource.RLIMIT_NOFILE, (64, resource.getrlimit(resource.RLIMIT_NOFILE)[1]))
with Master() as master:
    print(master.port, flush=True)
    sys.stdin.readline()
    print(master._server.stats.dropped_pending)
"""


@pytest.mark.promise("such a one, then the one that has been idle for longest")
@pytest.mark.skipif(sys.platform == "win32", reason="limits open files the POSIX way")
def test_silent_connections_that_take_every_file_keep_nobody_out() -> None:
    """The system's bound may be below `Limits.pending_handshakes`: the oldest silent one goes then, too."""
    with (
        subprocess.Popen(
            [sys.executable, "-c", FEW_FILES], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        ) as process,
        contextlib.ExitStack() as opened,
    ):
        assert process.stdout is not None
        port = int(process.stdout.readline())
        with MasterClient(f"http://127.0.0.1:{port}/", "/first") as client:
            client.get_pid()  # what reads documents is loaded with the first
        for _ in range(90):
            sock = opened.enter_context(socket.create_connection(("127.0.0.1", port), 5))
            sock.sendall(b"POST / HTTP/1.1\r\n")
        with MasterClient(f"http://127.0.0.1:{port}/", "/honest", timeout=DEADLINE) as client:
            assert client.get_pid() == process.pid
        out, _ = process.communicate("\n", timeout=20)
        assert int(out) > 20
