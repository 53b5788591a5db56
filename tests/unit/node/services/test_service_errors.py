"""Services that fail: who is told what, and what goes on living."""

from __future__ import annotations

import contextlib
import socket
import struct
import threading

import pytest

from rosproto.errors import (
    ConnectionLost,
    LocalProtocolError,
    Md5sumMismatch,
    RemoteProtocolError,
    RosTimeout,
    ServiceError,
)
from rosproto.protocol.handshake import encode_header
from rosproto.protocol.wire_limits import Limits
from rosproto.transport import Deadline
from rosproto.transport.tcp import read_header
from tests.support.proxy import FaultProxy
from tests.support.small_node import MemoryMaster, SmallNode
from tests.unit.node.services.provided import SetBool, Trigger, tell


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


@pytest.mark.parametrize("uri", ["", "nonsense.invalid", "rosrpc://", "rosrpc://host:notaport"])
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
            with (
                sock,
                contextlib.suppress(ConnectionError),
            ):  # a caller whose time was over before it sent anything
                self._serve(sock)

    def _serve(self, sock: socket.socket) -> None:
        fields = read_header(sock, Limits(), Deadline(20))
        if fields.get("probe") != "1":
            sock.settimeout(0.05)
            try:
                self.early += sock.recv(100)
            except TimeoutError:
                pass
            sock.settimeout(20)
        sock.sendall(encode_header({"md5sum": SetBool._md5sum, "type": "std_srvs/SetBool"}))
        if fields.get("probe") != "1" and sock.recv(100):
            self.requests += 1
            self._action(sock)

    def close(self) -> None:
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)  # wakes the thread that accepts, which close does not
        self._listener.close()
        self._thread.join(20)


def test_nothing_is_sent_before_the_answer_to_the_header_and_never_sent_twice(node, persistent):
    """A rospy provider loses what comes with the header; a request whose fate is unknown is the caller's matter."""
    provider = OddProvider(node.master, "/odd", lambda sock: None)  # closes without an answer
    client = node.service_client("/odd", SetBool, persistent=persistent)
    with pytest.raises(ConnectionLost, match="may or may not"):
        client.call(data=True, timeout=20)
    assert provider.requests == 1
    assert provider.early == b""
    provider.close()


def test_one_deadline_covers_the_whole_call(node):
    release = threading.Event()
    provider = OddProvider(node.master, "/odd", lambda sock: release.wait(20))
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

    def handler(request):
        if request.data:  # and not: the first request, which may not even be sent in so little time
            gate.wait(20)
        return tell(request)

    node.service_server("/set", SetBool, handler)
    client = node.service_client("/set", SetBool, persistent=True)
    with pytest.raises(RosTimeout):
        client.call(data=True, timeout=0.1)
    assert client.call(data=False).message == "data=False"
    gate.set()


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
    with pytest.raises(LocalProtocolError, match="already provides it"):
        node.service_server("/set", Trigger, tell)
    server.close()
    node.service_server("/set", Trigger, lambda request: (True, "new"))
    assert node.service_client("/set", Trigger).call().message == "new"


def test_a_handler_must_be_callable(node):
    with pytest.raises(TypeError, match="callable"):
        node.service_server("/set", SetBool, 5)


def test_garbage_instead_of_a_request_is_an_error_answer_and_the_service_lives_on(node, caplog):
    """It is the caller's fault: a line of the log, without a traceback."""
    node.service_server("/set", SetBool, tell)
    with socket.create_connection(("127.0.0.1", node.tcpros_address[1])) as sock:
        sock.sendall(
            encode_header({"service": "/set", "md5sum": SetBool._md5sum, "callerid": "/x", "persistent": "1"})
        )
        read_header(sock, Limits(), Deadline(5))
        sock.sendall(struct.pack("<I", 9) + b"123456789")
        assert sock.recv(1) == b"\0"
    assert "a request of /x is malformed" in caplog.text
    assert "Traceback" not in caplog.text
    assert node.service_client("/set", SetBool).call(data=True).success


def test_a_registration_that_fails_leaves_no_server(node, monkeypatch):
    def down(*args):
        raise ConnectionLost("no master")

    monkeypatch.setattr(node.master, "register_service", down)
    with pytest.raises(ConnectionLost):
        node.service_server("/set", SetBool, tell)
    monkeypatch.undo()
    node.service_server("/set", SetBool, tell)


def test_clients_through_a_broken_network_get_documented_errors(node):
    node.service_server("/set", SetBool, tell)
    with FaultProxy("127.0.0.1", node.tcpros_address[1]) as proxy:
        node.master.services["/set"] = f"rosrpc://127.0.0.1:{proxy.port}"
        client = node.service_client("/set", SetBool, persistent=True)
        assert client.call(data=True).success
        proxy.reset()
        deadline = Deadline(5)
        while client._kept.usable and not deadline.expired:
            threading.Event().wait(0.001)  # the reset is on its way
        assert client.call(data=True, timeout=20).success  # found dead before a request was sent
        proxy.byte_at_a_time = True
        assert client.call(data=True, timeout=20).success
        proxy.stall()
        with pytest.raises(RosTimeout):
            client.call(data=True, timeout=0.1)
        with pytest.raises(RosTimeout):
            node.service_client("/set", SetBool).call(data=True, timeout=0.1)
