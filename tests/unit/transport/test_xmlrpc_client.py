"""The XML-RPC client: keep-alive, retry, deadlines, errors."""

from __future__ import annotations

import queue
import socket
import sys
import threading
from collections.abc import Callable, Iterator

import pytest

from rosproto.errors import ConnectionLost, LocalProtocolError, MasterError, RemoteProtocolError, RosTimeout
from rosproto.protocol import xmlrpc
from rosproto.protocol.http import HttpServerConnection, Request
from rosproto.protocol.wire_limits import Limits
from rosproto.transport.tcp_server import TcpServer
from rosproto.transport.xmlrpc_client import XmlRpcClient, unpack
from rosproto.transport.xmlrpc_server import XmlRpcServer
from tests.support.proxy import FaultProxy
from tests.support.victim import eventually

SOON = 20.0


def dispatch(method: str, params: list[object], _peer: str) -> object:
    if method == "fault":
        raise xmlrpc.Fault(7, "no such thing")
    return [1, method, params]


@pytest.fixture
def server() -> Iterator[XmlRpcServer]:
    with XmlRpcServer("127.0.0.1", 0, dispatch) as running:
        yield running


@pytest.fixture
def scripted() -> Iterator[Callable[..., str]]:
    """Starts a server that runs `script(connection number, sock)` for each connection; gives its URI."""
    servers = []

    def start(script: Callable[[int, socket.socket], object]) -> str:
        count = iter(range(1000))
        lock = threading.Lock()

        def on_connection(sock: socket.socket, _peer: object) -> None:
            with lock:
                number = next(count)
            sock.settimeout(SOON)
            script(number, sock)

        servers.append(TcpServer("127.0.0.1", 0, on_connection))
        return f"http://127.0.0.1:{servers[-1].port}/"

    yield start
    for each in servers:
        each.close()


def serve_one(sock: socket.socket, value: object = "fine") -> Request | None:
    """Read one request and answer it properly; None when the client closed."""
    connection = HttpServerConnection(Limits())
    while True:
        event = connection.next_event()
        if isinstance(event, Request):
            sock.sendall(connection.encode_response(200, xmlrpc.encode_response(value)))
            return event
        if event is not None:
            return None
        connection.receive(sock.recv(65536))


def test_calls_share_one_connection(server: XmlRpcServer) -> None:
    with XmlRpcClient(server.uri) as client:
        for number in range(5):
            assert client.call("echo", number, "x") == [1, "echo", [number, "x"]]
    assert server.stats.accepted == 1


def test_threads_call_side_by_side(server: XmlRpcServer) -> None:
    results: list[object] = []
    with XmlRpcClient(server.uri) as client:
        threads = [
            threading.Thread(target=lambda n=n: results.extend(client.call("e", n, i) for i in range(20)))  # type: ignore[misc]
            for n in range(6)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(SOON)
        assert sorted(result[2] for result in results) == [[n, i] for n in range(6) for i in range(20)]  # type: ignore[index]
        eventually(lambda: 1 <= server.connections <= 4)


def test_a_fault_is_a_master_error_and_the_connection_is_kept(server: XmlRpcServer) -> None:
    with XmlRpcClient(server.uri) as client:
        with pytest.raises(MasterError, match=r"fault refused by .*no such thing") as caught:
            client.call("fault")
        assert (caught.value.method, caught.value.code, caught.value.text) == ("fault", 7, "no such thing")
        assert caught.value.uri == server.uri
        client.call("echo")
    assert server.stats.accepted == 1


def test_nobody_there_says_so(server: XmlRpcServer) -> None:
    server.close()
    with (
        XmlRpcClient(server.uri) as client,
        pytest.raises(ConnectionLost, match=r"getPid at http://127.*running"),
    ):
        client.call("getPid")


def test_a_uri_that_is_none_is_told_at_once() -> None:
    with pytest.raises(ValueError, match="URI"):
        XmlRpcClient("http://:1/")


def test_an_argument_that_cannot_be_sent_opens_no_connection(server: XmlRpcServer) -> None:
    with XmlRpcClient(server.uri) as client, pytest.raises(LocalProtocolError):
        client.call("setParam", None)
    assert server.stats.accepted == 0


def test_a_silent_server_costs_the_timeout_only(scripted: Callable[..., str]) -> None:
    uri = scripted(lambda _n, sock: [None for _ in iter(lambda: sock.recv(1000), b"")])
    with XmlRpcClient(uri) as client:
        with pytest.raises(RosTimeout, match=r"getPid at http.*within 0\.05 s.*cable"):
            client.call("getPid", timeout=0.05)
        client.timeout = 0.03
        with pytest.raises(RosTimeout, match=r"0\.03 s"):
            client.call("getPid")


@pytest.mark.skipif(sys.platform == "win32", reason="Wine sends FIN where SO_LINGER 0 asks for RST")
def test_a_call_that_was_given_up_is_not_delivered_later(scripted: Callable[..., str]) -> None:
    """Its connection is reset, so that the system throws away what a silent network has kept of it."""
    ended: queue.Queue[object] = queue.Queue()

    def wait_for_the_end(_number: int, sock: socket.socket) -> None:
        sock.recv(1000)
        try:
            ended.put(sock.recv(1000))
        except OSError as error:
            ended.put(error)

    with XmlRpcClient(scripted(wait_for_the_end)) as client:
        with pytest.raises(RosTimeout):
            client.call("registerPublisher", timeout=0.05)
        assert isinstance(ended.get(timeout=SOON), ConnectionResetError)


def test_dripping_bytes_do_not_extend_the_deadline(scripted: Callable[..., str]) -> None:
    over = threading.Event()

    def drip(_number: int, sock: socket.socket) -> None:
        sock.recv(1000)
        while not over.wait(0.005):
            sock.sendall(b"H")

    try:
        with XmlRpcClient(scripted(drip)) as client, pytest.raises(RosTimeout):
            client.call("getPid", timeout=0.1)
    finally:
        over.set()


@pytest.mark.promise("Connections are kept, closed when idle, and capped")
def test_a_connection_the_server_closed_while_idle_is_replaced_unnoticed(
    scripted: Callable[..., str],
) -> None:
    closed = threading.Event()

    def once(_number: int, sock: socket.socket) -> None:
        serve_one(sock)
        sock.shutdown(socket.SHUT_RDWR)
        closed.set()

    with XmlRpcClient(scripted(once)) as client:
        for _ in range(3):
            closed.clear()
            assert client.call("echo", retry=False) == "fine"
            assert closed.wait(SOON)


def dies_on_second(number: int, sock: socket.socket) -> None:
    """The first connection answers once, then takes a request and closes without an answer."""
    serve_one(sock)
    if number == 0:
        sock.recv(65536)
        return
    serve_one(sock)


def test_a_connection_that_dies_at_the_next_call_is_retried_once(scripted: Callable[..., str]) -> None:
    with XmlRpcClient(scripted(dies_on_second)) as client:
        assert client.call("one") == "fine"
        assert client.call("two") == "fine"


def test_a_call_that_must_not_run_twice_is_not_retried(scripted: Callable[..., str]) -> None:
    with XmlRpcClient(scripted(dies_on_second)) as client:
        assert client.call("one") == "fine"
        with pytest.raises(ConnectionLost, match="without an answer"):
            client.call("two", retry=False)


def test_a_new_connection_is_never_retried(scripted: Callable[..., str]) -> None:
    numbers = []

    def close(number: int, sock: socket.socket) -> None:
        numbers.append(number)
        sock.recv(65536)

    with XmlRpcClient(scripted(close)) as client, pytest.raises(ConnectionLost, match="without an answer"):
        client.call("one")
    assert numbers == [0]


def test_a_call_that_waits_at_an_old_address_is_made_again(scripted: Callable[..., str]) -> None:
    """What was sent from an address that is gone is never answered: `reconnect` sends it again from the new one."""
    waiting = threading.Event()

    def script(number: int, sock: socket.socket) -> None:
        serve_one(sock, number)
        if number == 0:
            sock.recv(65536)
            waiting.set()
            sock.recv(1)  # until the client lets go

    with XmlRpcClient(scripted(script)) as client:
        assert client.call("getPid") == 0
        answers: queue.Queue[object] = queue.Queue()
        caller = threading.Thread(target=lambda: answers.put(client.call("getPid", timeout=SOON)))
        caller.start()
        assert waiting.wait(SOON)
        client.reconnect()
        assert answers.get(timeout=SOON) == 1
        caller.join()


def test_an_answer_that_breaks_off_is_not_retried(scripted: Callable[..., str]) -> None:
    numbers = []

    def half(number: int, sock: socket.socket) -> None:
        numbers.append(number)
        serve_one(sock)
        sock.recv(65536)
        sock.sendall(b"HTTP/1.1 200 OK\r\nContent-le")

    with XmlRpcClient(scripted(half)) as client:
        assert client.call("one") == "fine"
        with pytest.raises(RemoteProtocolError, match=r"two at http.*middle of a message"):
            client.call("two")
    assert numbers == [0]


@pytest.mark.parametrize(
    ("answer", "text"),
    [
        (b"SSH-2.0-OpenSSH_9.2\r\n\r\n", "status line"),
        (b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n", "HTTP 404 Not Found.*is this a ROS master"),
        (
            b"HTTP/1.1 200 OK\r\nContent-Length: 5\r\n\r\n<html",
            "getPid at http.*XML-RPC.*is this a ROS master",
        ),
        (b"HTTP/1.1 200 OK\r\nContent-Length: 999999999\r\n\r\n", "xml_body_bytes"),
        (b"HTTP/1.1 200 OK\r\nX: " + b"x" * 20_000, "http_head_bytes"),
    ],
)
def test_a_server_that_is_something_else_is_the_peers_error(
    scripted: Callable[..., str], answer: bytes, text: str
) -> None:
    def script(_number: int, sock: socket.socket) -> None:
        sock.recv(65536)
        sock.sendall(answer)
        sock.recv(1)

    with XmlRpcClient(scripted(script)) as client, pytest.raises(RemoteProtocolError, match=text):
        client.call("getPid")


def test_a_connection_with_surplus_bytes_is_not_used_again(scripted: Callable[..., str]) -> None:
    numbers = []

    def script(number: int, sock: socket.socket) -> None:
        numbers.append(number)
        sock.recv(65536)
        body = xmlrpc.encode_response("fine")
        sock.sendall(b"HTTP/1.1 200 OK\r\nContent-length: %d\r\n\r\n%bsurplus" % (len(body), body))
        sock.recv(1)

    with XmlRpcClient(scripted(script)) as client:
        assert client.call("one") == client.call("two") == "fine"
    assert numbers == [0, 1]


def test_the_path_of_the_uri_is_asked_for(scripted: Callable[..., str]) -> None:
    answered: queue.Queue[Request] = queue.Queue()
    uri = scripted(lambda _n, sock: answered.put(serve_one(sock)))
    requests = []
    for path in ("", "RPC2"):
        with XmlRpcClient(uri + path) as client:
            client.call("x")
        # Taken one by one: the script notes a request after it was answered.
        requests.append(answered.get(timeout=SOON))
    assert [request.target for request in requests] == ["/", "/RPC2"]
    assert requests[0].headers["host"] == uri[7:-1]


def test_close_ends_calls_under_way_and_refuses_new_ones(scripted: Callable[..., str]) -> None:
    asked = threading.Event()

    def silent(_number: int, sock: socket.socket) -> None:
        sock.recv(65536)
        asked.set()
        sock.recv(1)

    client = XmlRpcClient(scripted(silent), timeout=None)
    errors: list[Exception] = []

    def call() -> None:
        try:
            client.call("wait")
        except ConnectionLost as error:
            errors.append(error)

    thread = threading.Thread(target=call)
    thread.start()
    assert asked.wait(SOON)
    client.close()
    client.close()
    thread.join(SOON)
    assert len(errors) == 1
    with pytest.raises(ConnectionLost, match="closed"):
        client.call("again")


def test_it_survives_a_restarted_server_behind_a_bad_line(server: XmlRpcServer) -> None:
    with (
        FaultProxy("127.0.0.1", server.port) as proxy,
        XmlRpcClient(f"http://127.0.0.1:{proxy.port}/") as client,
    ):
        assert client.call("one")
        proxy.reset()
        assert client.call("two")
        proxy.byte_at_a_time = True
        assert client.call("three", "x" * 50) == [1, "three", ["x" * 50]]
        proxy.stall()
        with pytest.raises(RosTimeout):
            client.call("four", timeout=0.05)
        proxy.resume()
        assert client.call("five")
        proxy.cut()
        assert client.call("six")
        with XmlRpcServer("127.0.0.1", 0, dispatch) as other:
            server.close()
            proxy.retarget("127.0.0.1", other.port)
            assert client.call("seven")


# -- the ROS triple


def test_a_good_reply_gives_its_value() -> None:
    assert unpack("getPid", [1, "", 4711]) == 4711


def test_a_reply_without_value_gives_none() -> None:
    assert unpack("shutdown", [1, "ok"]) is None


@pytest.mark.parametrize("code", [0, -1])
def test_a_refusal_is_a_master_error(code: int) -> None:
    with pytest.raises(MasterError, match="getParam refused by http://m/: not set") as caught:
        unpack("getParam", [code, "not set", 0], "http://m/")
    assert (caught.value.method, caught.value.code, caught.value.text) == ("getParam", code, "not set")


@pytest.mark.parametrize("reply", [None, 1, "x", [], ["1", "", 0], {}, [None]])
def test_another_shape_is_the_peers_error(reply: object) -> None:
    with pytest.raises(RemoteProtocolError, match="expected"):
        unpack("getPid", reply)
