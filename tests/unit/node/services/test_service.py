"""Service client and server over loopback: calls, caching, persistence, waiting, closing."""

from __future__ import annotations

import logging
import socket
import threading

import pytest

from rosproto.codec import define, service_class
from rosproto.errors import (
    ConnectionLost,
    LocalProtocolError,
    RosTimeout,
    ServiceError,
)
from rosproto.node.services import probe as service_probe
from rosproto.protocol.handshake import encode_header
from rosproto.transport import Deadline
from tests.support.small_node import MemoryMaster, SmallNode
from tests.unit.node.services.provided import SetBool, tell

Empty = service_class("std_srvs/Empty")
GetLoggers = service_class("roscpp/GetLoggers")


def test_a_request_gets_its_response(node, persistent):
    node.service_server("/set", SetBool, tell)
    with node.service_client("/set", SetBool, persistent=persistent) as client:
        for data in (True, False, True):
            answer = client.call(SetBool.Request(data=data), timeout=20)
            assert (answer.success, answer.message) == (data, f"data={data}")
        assert client.call(data=True).success
        assert client(data=True).message == "data=True"
        assert answer._connection_header["callerid"] == "/small"
        assert client.stats()["connects"] == (1 if persistent else 5)
        assert client.stats()["lookups"] == 1


def test_the_handler_sees_who_calls(node):
    seen = []
    node.service_server(
        "/set", SetBool, lambda request: seen.append(request._connection_header["callerid"]) or tell(request)
    )
    node.service_client("/set", SetBool).call(data=True)
    assert seen == ["/small"]


@pytest.mark.parametrize(
    ("type_name", "returned", "expected"),
    [
        ("std_srvs/SetBool", {"success": True, "message": "x"}, {"success": True, "message": "x"}),
        ("std_srvs/SetBool", {"success": True}, {"success": True, "message": ""}),
        ("std_srvs/SetBool", (True, "x"), {"success": True, "message": "x"}),
        ("std_srvs/SetBool", [True, "x"], {"success": True, "message": "x"}),
        ("std_srvs/Empty", None, {}),
        ("std_srvs/Empty", {}, {}),
        ("roscpp/GetLoggers", [], {"loggers": []}),
    ],
)
def test_a_handler_may_return_a_dict_a_tuple_or_the_only_field(node, type_name, returned, expected):
    service = service_class(type_name)
    node.service_server("/s", service, lambda request: returned)
    answer = node.service_client("/s", service).call()
    assert {name: getattr(answer, name) for name in answer.__slots__} == expected


def test_a_provider_that_moved_is_found_again():
    master = MemoryMaster()
    with SmallNode("/client", master) as caller, SmallNode("/b", master) as second:
        with SmallNode("/a", master) as first:
            first.service_server("/set", SetBool, lambda request: (True, "first"))
            client = caller.service_client("/set", SetBool)
            assert client.call(data=True).message == "first"
        second.service_server("/set", SetBool, lambda request: (True, "second"))
        assert client.call(data=True).message == "second"
        assert client.call(data=True).message == "second"
        assert client.stats()["lookups"] == 2


def test_another_node_on_the_remembered_port_is_noticed():
    """Ports are re-used: who answers there may know nothing of the service."""
    master = MemoryMaster()
    with (
        SmallNode("/client", master) as caller,
        SmallNode("/a", master) as first,
        SmallNode("/b", master) as second,
    ):
        server = first.service_server("/set", SetBool, lambda request: (True, "first"))
        client = caller.service_client("/set", SetBool)
        client.call(data=True)
        server.close()  # /a still listens, but does not provide it any more
        second.service_server("/set", SetBool, lambda request: (True, "second"))
        assert client.call(data=True).message == "second"


def test_a_remembered_address_that_has_fallen_silent_leaves_time_for_the_new_one(node):
    node.service_server("/set", SetBool, tell)
    client = node.service_client("/set", SetBool)
    client.call(data=True)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        client._address = silent.getsockname()
        assert client.call(data=True, timeout=2.0).success  # of which a half is spent on the old one
        assert client.stats()["lookups"] == 2


def test_threads_that_call_at_the_same_time_share_the_remembered_address(node):
    """The master is asked once, not whenever one call connects while another does."""
    node.service_server("/set", SetBool, tell)
    client = node.service_client("/set", SetBool)
    client.call(data=True)
    together = threading.Barrier(8)

    def call() -> None:
        together.wait(10)
        for _ in range(10):
            client.call(data=True, timeout=60)  # half of it is for the remembered address

    threads = [threading.Thread(target=call) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(90)
    stats = client.stats()
    assert (stats["calls"], stats["errors"], stats["lookups"]) == (81, 0, 1)


def test_a_persistent_link_that_died_idle_is_made_anew():
    master = MemoryMaster()
    with SmallNode("/client", master) as caller:
        client = caller.service_client("/set", SetBool, persistent=True)
        for turn in ("one", "two", "three"):
            with SmallNode("/server", master) as provider:
                provider.service_server("/set", SetBool, lambda request, turn=turn: (True, turn))
                assert client.call(data=True).message == turn
                assert client.call(data=True).message == turn
        assert client.stats()["connects"] >= 3


def test_threads_share_a_persistent_client_and_each_gets_its_own_answer(node, persistent):
    node.service_server("/set", SetBool, tell)
    client = node.service_client("/set", SetBool, persistent=persistent)
    wrong: list[object] = []

    def work(data: bool) -> None:
        for _ in range(50):
            answer = client.call(data=data)
            if answer.message != f"data={data}":
                wrong.append(answer)

    threads = [threading.Thread(target=work, args=(bool(n % 2),)) for n in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(30)
    assert wrong == []
    assert client.stats()["calls"] == 300


def test_waiting_for_a_turn_is_within_the_deadline(node):
    gate, entered = threading.Event(), threading.Event()
    node.service_server("/set", SetBool, lambda request: (entered.set(), gate.wait(20), tell(request))[2])
    client = node.service_client("/set", SetBool, persistent=True)
    first = threading.Thread(target=lambda: client.call(data=True))
    first.start()
    assert entered.wait(20)
    with pytest.raises(RosTimeout, match="not sent"):
        client.call(data=True, timeout=0.05)
    gate.set()
    first.join(20)


@pytest.mark.promise("A probe ends after the header, and `rospy.wait_for_service`")
def test_a_probe_tells_the_type_and_is_silent(node, caplog):
    caplog.set_level(logging.INFO)
    calls: list[object] = []
    node.service_server("/set", SetBool, calls.append)
    header = service_probe.probe(node, "/set", Deadline(5))
    assert (header["type"], header["md5sum"]) == ("std_srvs/SetBool", SetBool._md5sum)
    assert (header["request_type"], header["response_type"]) == (
        "std_srvs/SetBoolRequest",
        "std_srvs/SetBoolResponse",
    )
    for data in (b"", encode_header({"service": "/set", "md5sum": "*", "callerid": "/x", "probe": "1"})):
        with socket.create_connection(("127.0.0.1", node.tcpros_address[1])) as sock:
            sock.sendall(data)  # rospy's wait_for_service closes without reading
    client = node.service_client("/set", SetBool)
    with pytest.raises(ServiceError):  # one call more, so that the probes above have been served
        client.call(data=True)
    assert len(calls) == 1
    assert [
        r.getMessage()
        for r in caplog.records
        if r.levelno >= logging.WARNING and "the call of" not in r.getMessage()
    ] == []


def test_waiting_ends_when_the_service_appears(node):
    timer = threading.Timer(0.05, lambda: node.service_server("/late", SetBool, tell))
    timer.start()
    node.service_client("/late", SetBool).wait(20)
    timer.join()


def test_waiting_in_vain_says_what_was_missing(node):
    with pytest.raises(RosTimeout, match=r"/never did not appear within 0\.5 s.*no node provides"):
        node.service_client("/never", SetBool).wait(0.5)
    assert 2 <= node.master.count("lookupService") < 20


def test_closing_a_client_ends_its_wait_and_its_calls(node, persistent):
    entered, gate = threading.Event(), threading.Event()
    node.service_server("/set", SetBool, lambda request: (entered.set(), gate.wait(20), tell(request))[2])
    client = node.service_client("/set", SetBool, persistent=persistent)
    problems: list[Exception] = []

    def call() -> None:
        try:
            client.call(data=True)
        except Exception as error:
            problems.append(error)

    thread = threading.Thread(target=call)
    thread.start()
    assert entered.wait(20)
    client.close()
    client.close()
    thread.join(20)
    gate.set()
    assert [type(problem) for problem in problems] == [ConnectionLost]
    with pytest.raises(LocalProtocolError, match="closed"):
        client.call(data=True)


@pytest.mark.promise("A service is registered when its port accepts")
def test_closing_a_server_lets_answers_out_ends_idle_links_and_unregisters(node):
    server = node.service_server("/set", SetBool, tell)
    client = node.service_client("/set", SetBool, persistent=True)
    client.call(data=True)
    server.close()
    server.close()
    assert node.master.services == {}
    with pytest.raises(ServiceError, match="no node provides"):
        client.call(data=True)


def test_closing_a_server_with_a_hanging_handler_is_bounded(node):
    entered, gate = threading.Event(), threading.Event()
    server = node.service_server(
        "/set", SetBool, lambda request: (entered.set(), gate.wait(10), tell(request))[2]
    )
    lost = threading.Event()

    def call() -> None:
        try:
            node.service_client("/set", SetBool).call(data=True)
        except ConnectionLost:
            lost.set()

    thread = threading.Thread(target=call)
    thread.start()
    assert entered.wait(20)
    server.close(timeout=0.05)
    assert lost.wait(20)
    gate.set()
    thread.join(20)


def test_a_handler_may_close_its_own_server(node):
    server = node.service_server("/stop", Empty, lambda request: server.close())
    node.service_client("/stop", Empty).call()
    with pytest.raises(ServiceError):
        node.service_client("/stop", Empty).call()


def test_a_definition_of_our_own_works(node):
    sums = service_class("roscpp/SetLoggerLevel")
    node.service_server("/level", sums, lambda request: None)
    assert node.service_client("/level", sums).call(logger="a", level="b") == sums.Response()
    assert define("std_msgs/Empty", "")._md5sum == "d41d8cd98f00b204e9800998ecf8427e"


def test_a_type_may_be_a_name_or_asked_of_the_provider(node):
    node.service_server("/set", "std_srvs/SetBool", tell)
    assert node.service_client("/set", "std_srvs/SetBool").call(data=True).success
    client = node.service_client("/set", None)
    assert client.type_name == "std_srvs/SetBool"
    assert client.call(data=True).success
    with pytest.raises(LocalProtocolError, match="not a service type"):
        node.service_client("/set", SetBool.Request)
    with pytest.raises(LocalProtocolError, match="not a service type"):
        node.service_server("/other", None, tell)


def test_closing_the_node_is_bounded_with_many_hanging_handlers():
    gate, entered = threading.Event(), threading.Semaphore(0)

    def hang(request: object) -> None:
        entered.release()
        gate.wait(20)

    def call(client) -> None:
        with pytest.raises(ConnectionLost):
            client.call()

    with SmallNode() as small:
        for n in range(4):
            small.service_server(f"/hang{n}", Empty, hang)
            client = small.service_client(f"/hang{n}", Empty)
            threading.Thread(target=call, args=(client,), daemon=True).start()
            assert entered.acquire(timeout=20)
        deadline = Deadline(10)
        small.services.close()
        assert deadline.remaining() > 7
        gate.set()


def test_many_services_and_clients_leave_nothing_behind(node):
    def threads() -> int:
        return sum(t.name.startswith("rosproto:") for t in threading.enumerate())

    before = threads()
    for persistent in (False, True) * 50:
        with (
            node.service_server("/set", SetBool, tell),
            node.service_client("/set", SetBool, persistent=persistent) as client,
        ):
            assert client.call(data=True).success
    deadline = Deadline(5)
    while threads() > before and not deadline.expired:
        threading.Event().wait(0.005)
    assert threads() <= before
    assert node.services.stats() == {"servers": {}, "clients": {}}
    assert len(node.registrations) == 0


def test_a_server_that_left_answers_what_it_has_begun(node, persistent):
    """Also when the handler waits for the one who ends the service; nothing waits for the answer."""
    left = threading.Event()

    def handler(request):
        thread = threading.Thread(target=lambda: (server.leave(), left.set()))
        thread.start()
        thread.join(10)
        assert left.is_set()

    server = node.service_server("/stop", Empty, handler)
    with node.service_client("/stop", Empty, persistent=persistent) as client:
        client.call(timeout=10)
        with pytest.raises((ServiceError, ConnectionLost)):
            client.call(timeout=10)
    server.close()
