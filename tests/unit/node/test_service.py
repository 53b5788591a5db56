"""Service client and server over loopback: calls, failures, caching, persistence, closing."""

from __future__ import annotations

import logging
import socket
import struct
import threading
from collections.abc import Iterator

import pytest

from rosproto.codec import define, service_class
from rosproto.errors import (
    ConnectionLost,
    LocalProtocolError,
    Md5sumMismatch,
    RemoteProtocolError,
    RosTimeout,
    ServiceError,
)
from rosproto.node import service_probe
from rosproto.protocol.header import encode_header
from rosproto.protocol.limits import Limits
from rosproto.transport import Deadline
from rosproto.transport.tcpros_io import read_header
from tests.support.proxy import FaultProxy
from tests.support.small_node import MemoryMaster, SmallNode

SetBool = service_class("std_srvs/SetBool")
Trigger = service_class("std_srvs/Trigger")
Empty = service_class("std_srvs/Empty")
GetLoggers = service_class("roscpp/GetLoggers")


@pytest.fixture
def node() -> Iterator[SmallNode]:
    with SmallNode() as small:
        yield small


@pytest.fixture(params=[False, True], ids=["one-shot", "persistent"])
def persistent(request) -> bool:
    return request.param


def tell(request):
    return SetBool.Response(success=request.data, message=f"data={request.data}")


def test_a_request_gets_its_response(node, persistent):
    node.service_server("/set", SetBool, tell)
    with node.service_client("/set", SetBool, persistent=persistent) as client:
        for data in (True, False, True):
            answer = client.call(SetBool.Request(data=data), timeout=5.0)
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


@pytest.mark.parametrize(
    "returned", [None, 5, (True,), (1, 2, 3), {"nonsense": 1}, Trigger.Request(), object()]
)
def test_what_is_no_response_is_an_error_at_the_caller(node, returned, caplog):
    node.service_server("/set", SetBool, lambda request: returned)
    with pytest.raises(ServiceError):
        node.service_client("/set", SetBool).call(data=True)
    assert "Traceback" in caplog.text


def test_a_forgotten_return_is_told_with_the_fields_of_the_response(node):
    node.service_server("/set", SetBool, lambda request: None)
    with pytest.raises(
        ServiceError, match="returned None; expected std_srvs/SetBoolResponse with success, message"
    ):
        node.service_client("/set", SetBool).call(data=True)


def test_a_value_that_cannot_be_encoded_is_an_error_at_the_caller(node):
    node.service_server("/set", SetBool, lambda request: {"success": True, "message": 5})
    with pytest.raises(ServiceError):
        node.service_client("/set", SetBool).call(data=True)


def test_an_exception_crosses_as_text_and_the_link_lives_on(node, persistent, caplog):
    def picky(request):
        if request.data:
            raise KeyError("wheel")
        return tell(request)

    server = node.service_server("/set", SetBool, picky)
    with node.service_client("/set", SetBool, persistent=persistent) as client:
        with pytest.raises(ServiceError, match=r"KeyError: 'wheel'") as caught:
            client.call(data=True)
        assert caught.value.service == "/set"
        assert client.call(data=False).message == "data=False"
        assert client.stats()["connects"] == (1 if persistent else 2)
    assert "Traceback" in caplog.text
    assert (server.stats()["calls"], server.stats()["errors"]) == (2, 1)


def test_a_handler_says_no_in_plain_words_without_a_traceback(node, caplog):
    def refuse(request):
        raise ServiceError("/set", "the brake is on")

    node.service_server("/set", SetBool, refuse)
    with pytest.raises(ServiceError) as caught:
        node.service_client("/set", SetBool).call(data=True)
    assert caught.value.text == "the brake is on"
    assert "Traceback" not in caplog.text


def test_nobody_provides_it(node):
    client = node.service_client("/set", SetBool)
    with pytest.raises(ServiceError, match="no node provides it"):
        client.call(data=True)


def test_a_provider_that_is_listed_but_gone_is_a_lost_connection(node):
    with socket.create_server(("127.0.0.1", 0)) as gone:
        node.master.services["/set"] = f"rosrpc://127.0.0.1:{gone.getsockname()[1]}"
    with pytest.raises(ConnectionLost):
        node.service_client("/set", SetBool).call(data=True)


@pytest.mark.parametrize("uri", ["", "nonsense", "rosrpc://", "rosrpc://host:notaport"])
def test_an_unusable_address_from_the_master_is_an_error(node, uri):
    node.master.services["/set"] = uri
    with pytest.raises(Exception) as caught:
        node.service_client("/set", SetBool).call(data=True, timeout=1.0)
    assert type(caught.value).__module__ == "rosproto.errors"


def test_the_wrong_definition_is_told_with_both_sums(node, persistent):
    node.service_server("/set", Trigger, lambda request: (True, ""))
    client = node.service_client("/set", SetBool, persistent=persistent)
    with pytest.raises(Md5sumMismatch) as caught:
        client.call(data=True)
    error = caught.value
    assert (error.md5sum, error.remote_md5sum) == (SetBool._md5sum, Trigger._md5sum)
    assert (error.type_name, error.remote_type) == ("std_srvs/SetBool", "std_srvs/Trigger")
    assert SetBool._md5sum in str(error)
    assert Trigger._md5sum in str(error)


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
        assert client.call(data=True, timeout=0.5).success
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
            client.call(data=True)

    threads = [threading.Thread(target=call) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(20)
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


class OddProvider:
    """Listens, answers the handshake, then does what it is told with the socket after each request."""

    def __init__(self, master: MemoryMaster, name: str, action) -> None:
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._action = action
        self.requests = 0
        self.early = b""
        master.services[name] = f"rosrpc://127.0.0.1:{self._listener.getsockname()[1]}"
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while True:
            try:
                sock, _ = self._listener.accept()
            except OSError:
                return
            with sock:
                fields = read_header(sock, Limits(), Deadline(5))
                if fields.get("probe") != "1":
                    sock.settimeout(0.05)
                    try:
                        self.early += sock.recv(100)
                    except TimeoutError:
                        pass
                    sock.settimeout(5)
                sock.sendall(encode_header({"md5sum": SetBool._md5sum, "type": "std_srvs/SetBool"}))
                if fields.get("probe") != "1" and sock.recv(100):
                    self.requests += 1
                    self._action(sock)

    def close(self) -> None:
        self._listener.close()


def test_nothing_is_sent_before_the_answer_to_the_header_and_never_sent_twice(node, persistent):
    """A rospy provider loses what comes with the header; a request whose fate is unknown is the caller's matter."""
    provider = OddProvider(node.master, "/odd", lambda sock: None)  # closes without an answer
    client = node.service_client("/odd", SetBool, persistent=persistent)
    with pytest.raises(ConnectionLost, match="may or may not"):
        client.call(data=True, timeout=5.0)
    assert provider.requests == 1
    assert provider.early == b""
    provider.close()


def test_one_deadline_covers_the_whole_call(node):
    release = threading.Event()
    provider = OddProvider(node.master, "/odd", lambda sock: release.wait(5))
    client = node.service_client("/odd", SetBool)
    with pytest.raises(RosTimeout) as caught:
        client.call(data=True, timeout=0.2)
    assert caught.value.seconds == 0.2
    release.set()
    provider.close()


def test_a_provider_that_never_answers_the_header_is_a_timeout(node):
    with socket.create_server(("127.0.0.1", 0)) as silent:
        node.master.services["/set"] = f"rosrpc://127.0.0.1:{silent.getsockname()[1]}"
        with pytest.raises(RosTimeout):
            node.service_client("/set", SetBool).call(data=True, timeout=0.1)


def test_after_a_timeout_a_persistent_client_starts_with_a_clean_link(node):
    gate = threading.Event()
    slow = [True]

    def handler(request):
        if slow.pop() if slow else False:
            gate.wait(5)
        return tell(request)

    node.service_server("/set", SetBool, handler)
    client = node.service_client("/set", SetBool, persistent=True)
    with pytest.raises(RosTimeout):
        client.call(data=True, timeout=0.1)
    assert client.call(data=False).message == "data=False"
    gate.set()


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
    node.service_server("/set", SetBool, lambda request: (entered.set(), gate.wait(5), tell(request))[2])
    client = node.service_client("/set", SetBool, persistent=True)
    first = threading.Thread(target=lambda: client.call(data=True))
    first.start()
    assert entered.wait(5)
    with pytest.raises(RosTimeout, match="not sent"):
        client.call(data=True, timeout=0.05)
    gate.set()
    first.join(5)


def test_a_response_beyond_the_limit_is_refused():
    master = MemoryMaster()
    with (
        SmallNode("/server", master) as provider,
        SmallNode("/client", master, Limits(message_bytes=100)) as caller,
    ):
        provider.service_server("/set", SetBool, lambda request: (True, "x" * 1000))
        with pytest.raises(RemoteProtocolError, match="message_bytes"):
            caller.service_client("/set", SetBool).call(data=True)


def test_a_request_of_the_wrong_type_is_the_callers_mistake(node):
    client = node.service_client("/set", SetBool)
    with pytest.raises(TypeError, match="expected std_srvs/SetBoolRequest"):
        client.call(Trigger.Request())
    with pytest.raises(TypeError, match="not both"):
        client.call(SetBool.Request(), data=True)


def test_two_servers_for_one_service_in_a_node_are_refused(node):
    server = node.service_server("/set", SetBool, tell)
    with pytest.raises(LocalProtocolError, match="provides it already"):
        node.service_server("/set", Trigger, tell)
    server.close()
    node.service_server("/set", Trigger, lambda request: (True, "new"))
    assert node.service_client("/set", Trigger).call().message == "new"


def test_a_handler_must_be_callable(node):
    with pytest.raises(TypeError, match="callable"):
        node.service_server("/set", SetBool, 5)


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
        with socket.create_connection(("127.0.0.1", node._tcpros.port)) as sock:
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
    node.service_client("/late", SetBool).wait(5.0)
    timer.join()


def test_waiting_in_vain_says_what_was_missing(node):
    with pytest.raises(RosTimeout, match=r"/never did not appear within 0\.05 s.*no node provides"):
        node.service_client("/never", SetBool).wait(0.05)
    assert 2 <= node.master.count("lookupService") < 20


def test_closing_a_client_ends_its_wait_and_its_calls(node, persistent):
    entered, gate = threading.Event(), threading.Event()
    node.service_server("/set", SetBool, lambda request: (entered.set(), gate.wait(5), tell(request))[2])
    client = node.service_client("/set", SetBool, persistent=persistent)
    problems: list[Exception] = []

    def call() -> None:
        try:
            client.call(data=True)
        except Exception as error:
            problems.append(error)

    thread = threading.Thread(target=call)
    thread.start()
    assert entered.wait(5)
    client.close()
    client.close()
    thread.join(5)
    gate.set()
    assert [type(problem) for problem in problems] == [ConnectionLost]
    with pytest.raises(LocalProtocolError, match="closed"):
        client.call(data=True)


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
    assert entered.wait(5)
    server.close(timeout=0.05)
    assert lost.wait(5)
    gate.set()
    thread.join(5)


def test_a_handler_may_close_its_own_server(node):
    server = node.service_server("/stop", Empty, lambda request: server.close())
    node.service_client("/stop", Empty).call()
    with pytest.raises(ServiceError):
        node.service_client("/stop", Empty).call()


def test_garbage_instead_of_a_request_is_an_error_answer_and_the_service_lives_on(node):
    node.service_server("/set", SetBool, tell)
    with socket.create_connection(("127.0.0.1", node._tcpros.port)) as sock:
        sock.sendall(
            encode_header({"service": "/set", "md5sum": SetBool._md5sum, "callerid": "/x", "persistent": "1"})
        )
        read_header(sock, Limits(), Deadline(5))
        sock.sendall(struct.pack("<I", 9) + b"123456789")
        assert sock.recv(1) == b"\0"
    assert node.service_client("/set", SetBool).call(data=True).success


def test_a_registration_that_fails_leaves_no_server(node, monkeypatch):
    def down(*args):
        raise ConnectionLost("no master")

    monkeypatch.setattr(node.master, "register_service", down)
    with pytest.raises(ConnectionLost):
        node.service_server("/set", SetBool, tell)
    monkeypatch.undo()
    node.service_server("/set", SetBool, tell)


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
    with pytest.raises(LocalProtocolError, match="no service type"):
        node.service_client("/set", SetBool.Request)
    with pytest.raises(LocalProtocolError, match="no service type"):
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
            assert entered.acquire(timeout=5)
        deadline = Deadline(10)
        small._services.close()
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
    assert node._services.stats() == {"servers": {}, "clients": {}}
    assert len(node._registrations) == 0


def test_clients_through_a_broken_network_get_documented_errors(node):
    node.service_server("/set", SetBool, tell)
    with FaultProxy("127.0.0.1", node._tcpros.port) as proxy:
        node.master.services["/set"] = f"rosrpc://127.0.0.1:{proxy.port}"
        client = node.service_client("/set", SetBool, persistent=True)
        assert client.call(data=True).success
        proxy.reset()
        deadline = Deadline(5)
        while client._kept.usable and not deadline.expired:
            threading.Event().wait(0.001)  # the reset is on its way
        assert client.call(data=True, timeout=5.0).success  # found dead before a request was sent
        proxy.byte_at_a_time = True
        assert client.call(data=True, timeout=5.0).success
        proxy.stall()
        with pytest.raises(RosTimeout):
            client.call(data=True, timeout=0.1)
        with pytest.raises(RosTimeout):
            node.service_client("/set", SetBool).call(data=True, timeout=0.1)
