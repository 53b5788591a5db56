"""docs/wire.md against a running master and a running node: XML-RPC and HTTP that is not what it should be."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

import pytest

from rosproto.errors import RosError
from rosproto.master import Master
from rosproto.node import MasterClient, Node
from rosproto.protocol.wire_limits import Limits
from rosproto.protocol.xmlrpc import encode_call
from tests.support import attacks
from tests.support.load import crowd
from tests.support.victim import Victim

Unharmed = Callable[..., AbstractContextManager[None]]
BOTH = ("master", "node")
HEAD = b"<?xml version='1.0'?>"


def call_xml(method: str, *values: bytes) -> bytes:
    """A call whose arguments are XML as written."""
    params = b"".join(b"<param><value>" + value + b"</value></param>" for value in values)
    return (
        HEAD
        + f"<methodCall><methodName>{method}</methodName>".encode()
        + b"<params>"
        + params
        + b"</params></methodCall>"
    )


def post(address: tuple[str, int], data: bytes) -> tuple[bytes, bytes]:
    """Send, and read one answer."""
    with attacks.connect(address, data) as sock:
        return attacks.read_http(sock)


@pytest.mark.parametrize("door", BOTH)
def test_the_answer_is_one_that_roscpp_reads(door: str, victim: Victim) -> None:
    """17: the status line, the length's spelling, no chunks, a body."""
    head, body = post(getattr(victim, door), attacks.http_post(call_xml("getPid", b"/x")))
    lines = head.split(b"\r\n")
    assert lines[0] == b"HTTP/1.1 200 OK"
    assert any(line.lower().startswith(b"content-length: ") for line in lines)
    assert b"chunked" not in head.lower()
    assert b"<int>" in body or b"<i4>" in body


@pytest.mark.parametrize("depth", [1_000, 100_000])
@pytest.mark.parametrize("door", BOTH)
def test_nested_arrays(door: str, depth: int, victim: Victim, unharmed: Unharmed) -> None:
    """Section 10: a roscpp node dies of them by segmentation fault; ten of each here."""
    body = call_xml("getParam", b"<array><data><value>" * depth + b"</value></data></array>" * depth)
    with unharmed(memory=96):
        for _ in range(10):
            head, answer = post(getattr(victim, door), attacks.http_post(body))
            assert b"200 OK" in head
            assert b"<fault>" in answer


@pytest.mark.parametrize(
    "item", [b"<value/>", b"<value><i4>1</i4></value>", b"<value><array><data/></array></value>"]
)
@pytest.mark.parametrize("door", BOTH)
def test_flat_arrays_without_end(door: str, item: bytes, victim: Victim, unharmed: Unharmed) -> None:
    """Nothing is nested, but each of many small values costs more than its bytes; four callers at once."""
    body = attacks.http_post(
        call_xml("getPid", b"<array><data>" + item * (2_000_000 // len(item)) + b"</data></array>")
    )
    with unharmed(memory=320), attacks.many(getattr(victim, door), 4) as sockets:
        for sock in sockets:
            sock.settimeout(120)
            sock.sendall(body)
        for sock in sockets:
            assert b"200 OK" in attacks.read_http(sock)[0]


@pytest.mark.parametrize("door", BOTH)
def test_a_struct_of_endless_members(door: str, victim: Victim, unharmed: Unharmed) -> None:
    """And names that hash alike do not exist: they are text, whose hashes are salted."""
    members = b"".join(b"<member><name>n%d</name><value/></member>" % n for n in range(50_000))
    body = attacks.http_post(
        call_xml("setParam", b"/attacker", b"/victim_deep", b"<struct>" + members + b"</struct>")
    )
    with unharmed(memory=256), attacks.many(getattr(victim, door), 4) as sockets:
        for sock in sockets:
            sock.settimeout(120)
            sock.sendall(body)
        for sock in sockets:
            assert b"200 OK" in attacks.read_http(sock)[0]
        with MasterClient(victim.master_uri, "/attacker") as master:
            assert door == "node" or len(master.get_param("/victim_deep", timeout=120)) == 50_000
            if door == "master":
                master.delete_param("/victim_deep")


BILLION_LAUGHS = (
    HEAD
    + b'<!DOCTYPE lolz [<!ENTITY a "lol">'
    + b"".join(b'<!ENTITY %c "%s">' % (98 + n, b"&%c;" % (97 + n) * 10) for n in range(12))
    + b"]><methodCall><methodName>getParam</methodName><params><param><value>&m;</value></param></params></methodCall>"
)
QUADRATIC = (
    HEAD
    + b'<!DOCTYPE x [<!ENTITY a "' + b"A" * 500_000 + b'">]>'
    + b"<methodCall><methodName>getParam</methodName><params><param><value>" + b"&a;" * 100_000
    + b"</value></param></params></methodCall>"
)  # fmt: skip
EXTERNAL = (
    HEAD
    + b'<!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/hostname">]><methodCall><methodName>getParam</methodName>'
    + b"<params><param><value>/x</value></param><param><value>&a;</value></param></params></methodCall>"
)


@pytest.mark.promise("XML with a DOCTYPE or entities is refused")
@pytest.mark.parametrize(
    "bomb", [BILLION_LAUGHS, QUADRATIC, EXTERNAL], ids=["laughs", "quadratic", "external"]
)
@pytest.mark.parametrize("door", BOTH)
def test_entities_are_refused(door: str, bomb: bytes, victim: Victim, unharmed: Unharmed) -> None:
    """Section 10: nothing is expanded and no file is read."""
    with unharmed(memory=48):
        for _ in range(10):
            head, answer = post(getattr(victim, door), attacks.http_post(bomb))
            assert b"<fault>" in answer or b" 400 " in head
            with open("/etc/hostname", "rb") as file:
                name = file.read().strip()
            assert not name or name not in answer


@pytest.mark.promise("gives a value or a documented error on *that one* connection")
@pytest.mark.parametrize(
    "body",
    [
        b"", b"<", b"\0" * 1000, b"<methodCall>", b"<methodCall/>", b"<methodResponse/>", HEAD, b"\xff\xfe<\0a\0",
        call_xml("getPid")[:-5], call_xml("getPid", b"<i4>x</i4>"), call_xml("getPid", b"<i4>" + b"9" * 100_000 + b"</i4>"),
        call_xml("getPid", b"<double>" + b"1" * 100_000 + b"</double>"), call_xml("getPid", b"<base64>" + b"=" * 99 + b"</base64>"),
        call_xml("getPid", b"<struct><member></member></struct>"), call_xml("getPid", b"<dateTime.iso8601>no</dateTime.iso8601>"),
        call_xml("x" * 1_000_000), call_xml("__class__", b"/x"), call_xml("dispatch", b"/x"), call_xml("system.multicall", b"<i4>1</i4>"),
        call_xml("system.multicall", b"<array><data>" + b"<value><i4>1</i4></value>" * 1000 + b"</data></array>"),
    ],
    ids=range(20),
)  # fmt: skip
@pytest.mark.parametrize("door", BOTH)
def test_bodies_that_are_no_calls(door: str, body: bytes, victim: Victim, unharmed: Unharmed) -> None:
    """Each gets an answer on its own connection, which goes on or ends; nothing else happens."""
    with unharmed(memory=48), attacks.connect(getattr(victim, door)) as sock:
        for _ in range(5):
            try:
                sock.sendall(attacks.http_post(body))
                head, _ = attacks.read_http(sock)
            except (AssertionError, OSError):
                break
            assert head.startswith(b"HTTP/1.1 ")


@pytest.mark.parametrize(
    ("request_", "status"),
    [
        (b"GET / HTTP/1.1\r\nHost: x\r\n\r\n", (b"405", b"501")),
        (b"HEAD / HTTP/1.0\r\n\r\n", (b"405", b"501")),
        (b"DELETE /RPC2 HTTP/1.1\r\nHost: x\r\n\r\n", (b"405", b"501")),
        (attacks.http_post(b"x", path="/foo"), (b"404",)),
        (attacks.http_post(b"x", path="/../../etc/passwd"), (b"404",)),
        (b"POST / HTTP/9.9\r\nHost: x\r\n\r\n", (b"400", b"505")),
        (b"POST / HTTP/1.1\r\nHost: x\r\n\r\n", (b"411", b"400")),
        (attacks.http_post(b"", length=-1), (b"400",)),
        (attacks.http_post(b"", length=10**30), (b"413", b"400")),
        (attacks.http_post(b"", length=1 << 40), (b"413",)),
        (attacks.http_post(b"x", extra="Content-Length: 2\r\n"), (b"400",)),
        (attacks.http_post(b"x", extra="Transfer-Encoding: gzip\r\n"), (b"400", b"501")),
        (b"POST / HTTP/1.1\r\n" + b"X: y\r\n" * 100_000, (b"400", b"431")),
        (b"POST /" + b"a" * 1_000_000, (b"400", b"414", b"431")),
        (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + b"\0" * 200 + b"\r\n\r\n", (b"400",)),
        (b"SSH-2.0-OpenSSH_9.6\r\n\r\n", (b"400", b"505")),
    ],
    ids=range(16),
)
@pytest.mark.parametrize("door", BOTH)
def test_requests_that_are_refused(
    door: str, request_: bytes, status: tuple[bytes, ...], victim: Victim, unharmed: Unharmed
) -> None:
    """23 and what scanners send: a status, no work, no memory."""
    with unharmed(memory=32), attacks.connect(getattr(victim, door)) as sock:
        try:
            sock.sendall(request_)
        except OSError:
            pass  # refused before the last byte
        head, _ = attacks.read_http(sock)
        assert head.split()[1] in status, head


def chunked(body: bytes, size: int) -> bytes:
    """The body in chunks of so many bytes."""
    chunks = b"".join(
        b"%x\r\n%s\r\n" % (len(body[n : n + size]), body[n : n + size]) for n in range(0, len(body), size)
    )
    return b"POST / HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n" + chunks + b"0\r\n\r\n"


@pytest.mark.parametrize("door", BOTH)
def test_chunked_bodies(door: str, victim: Victim, unharmed: Unharmed) -> None:
    """Section 10: rosmaster answers 500, roscpp hangs up; here they are read, and bounded like others."""
    address = getattr(victim, door)
    with unharmed(memory=160):  # the largest body allowed is 16 MiB, and is held while it arrives
        for size in (1, 10, 10_000):
            head, body = post(address, chunked(call_xml("getPid", b"/x"), size))
            assert b"200 OK" in head
            assert b"<fault>" not in body
        for bad in (b"ffffffffffffffff\r\n", b"-1\r\n", b"zz\r\n", b"5" * 20_000):
            with attacks.connect(
                address, b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n" + bad
            ) as sock:
                assert attacks.ended_by_peer(sock, Victim.HANDSHAKE_SECONDS + 5)
        with attacks.connect(address, b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n") as sock:
            sent = 0
            try:
                while sent < 64 << 20:
                    sock.sendall(b"10000\r\n" + b"x" * 65536 + b"\r\n")
                    sent += 65536
            except OSError:
                pass  # it had enough
            assert sent < 40 << 20  # xml_body_bytes, and what lies in buffers


@pytest.mark.parametrize("door", BOTH)
def test_expect_100_continue(door: str, victim: Victim) -> None:
    """23: some clients wait for it before they send the body."""
    body = call_xml("getPid", b"/x")
    with attacks.connect(
        getattr(victim, door), attacks.http_post(b"", extra="Expect: 100-continue\r\n", length=len(body))
    ) as sock:
        assert b" 100 " in attacks.read_exactly(sock, 25)
        sock.sendall(body)
        head, _ = attacks.read_http(sock)
        assert b"200 OK" in head


@pytest.mark.parametrize("door", BOTH)
def test_big_bodies_that_come_slowly_or_never(door: str, victim: Victim, unharmed: Unharmed) -> None:
    """Fifty announce 15 MiB each and send a kilobyte: memory follows what arrives."""
    with (
        unharmed(memory=48),
        attacks.many(getattr(victim, door), 50, attacks.http_post(b"x" * 1000, length=15 << 20)) as all_,
    ):
        for sock in all_:
            assert attacks.ended_by_peer(sock, 20)


def test_an_idle_connection_is_closed_and_the_client_comes_back(victim: Victim) -> None:
    """22: kept alive, then closed by the server; our client notices and calls again."""
    with MasterClient(victim.master_uri, "/idle") as client, attacks.connect(victim.master) as raw:
        raw.sendall(attacks.http_post(call_xml("getPid", b"/x")) * 2)
        attacks.read_http(raw)
        pid = client.get_pid()
        assert attacks.ended_by_peer(raw, 10)  # the victim's idle_seconds are 3
        assert client.get_pid() == pid


@pytest.mark.promise("roscpp knows neither `i8` nor `nil`, and silently cuts")
def test_integers_of_any_width_are_read_and_only_32_bits_sent(victim: Victim) -> None:
    """18, section 10: `<i8>` and `<nil/>` are read; what could not be answered is refused, and what is kept can be read."""
    for value in (b"<i8>99999999999</i8>", b"<nil/>", b"<i4>4294967296</i4>"):
        _, answer = post(victim.master, attacks.http_post(call_xml("setParam", b"/x", b"/wide", value)))
        assert b"<fault>" in answer or b"<int>-1</int>" in answer or b"<i4>-1</i4>" in answer
    _, answer = post(victim.master, attacks.http_post(call_xml("setParam", b"/x", b"/wide", b"<i8>12</i8>")))
    with MasterClient(victim.master_uri, "/x") as client:
        assert client.get_param("/wide") == 12
        with pytest.raises((RosError, ValueError)):
            client.set_param("/wide", 1 << 31)
        assert client.get_param("/wide") == 12
        client.delete_param("/wide")


def test_values_cross_unchanged(victim: Victim) -> None:
    """19, 20, 21: white space, angle brackets, no character references, exponents, bool is not int."""
    values = {
        "text": "  <&>\"' \n\t ünï ]]> &#13; ", "empty": "", "yes": True, "one": 1, "tiny": 5e-324, "huge": -1.5e308,
        "list": [[], {}, [True, 1, 1.0]],
    }  # fmt: skip
    with MasterClient(victim.master_uri, "/x") as client:
        client.set_param("/values", values)
        got = client.get_param("/values")
        assert got == values
        assert (type(got["yes"]), type(got["one"]), type(got["list"][2][2])) == (bool, int, float)
        client.delete_param("/values")
    sent = encode_call("setParam", ["/x", "/v", values["text"]])
    assert b"&#" not in sent.replace(b"&amp;#", b"")
    assert b"CDATA" not in sent
    _, answer = post(
        victim.master, attacks.http_post(call_xml("setParam", b"/x", b"/nan", b"<double>nan</double>"))
    )
    assert b"<fault>" not in answer
    _, answer = post(
        victim.master, attacks.http_post(call_xml("setParam", b"/x", b"/untyped", b"  as it is  "))
    )
    with MasterClient(victim.master_uri, "/x") as client:
        assert client.get_param("/untyped") == "  as it is  "
        assert client.get_param("/nan") != client.get_param("/nan")


def test_multicall_floods(victim: Victim, unharmed: Unharmed) -> None:
    """24: rospy needs it; ten thousand calls in one, and multicalls inside a multicall."""
    with unharmed(memory=96), MasterClient(victim.master_uri, "/x") as client:
        answers = client.multicall([("getPid", ())] * 10_000, timeout=120)
        assert len(answers) == 10_000
        inner = b"<array><data></data></array>"
        for _ in range(20):
            inner = (
                b"<array><data><value><struct><member><name>methodName</name><value>system.multicall</value></member>"
                b"<member><name>params</name><value><array><data><value>" + inner + b"</value></data></array></value>"
                b"</member></struct></value></data></array>"
            )  # fmt: skip
        head, _ = post(victim.master, attacks.http_post(call_xml("system.multicall", inner)))
        assert b"200 OK" in head


@pytest.mark.promise("No name server is asked for the name")
def test_no_name_server_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    """36: a peer's address is never looked up backwards, nor the own name forwards."""

    def forbidden(*_: object) -> object:
        raise AssertionError("a look-up")

    for name in ("getfqdn", "gethostbyaddr", "getnameinfo", "gethostbyname_ex", "gethostname"):
        monkeypatch.setattr(socket, name, forbidden)
    with (
        Master() as master,
        Node("/a", master_uri=master.uri, intraprocess=False) as a,
        Node("/b", master_uri=master.uri, intraprocess=False) as b,
    ):
        a.publisher("/t", "std_msgs/String", latch=True).publish(data="x")
        assert b.subscriber("/t", "std_msgs/String").next(60).data == "x"
        a.service_server("/s", "std_srvs/Empty", lambda request: {})
        b.service_client("/s", "std_srvs/Empty").call()


@contextmanager
def odd_server(answer: Callable[[socket.socket], None]) -> Iterator[str]:
    """An XML-RPC "server" that does what it likes with each connection; its URI."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        ended = threading.Event()

        def serve() -> None:
            while not ended.is_set():
                try:
                    sock, _ = server.accept()
                except OSError:
                    return
                threading.Thread(target=one, args=(sock,), daemon=True).start()

        def one(sock: socket.socket) -> None:
            with sock:
                sock.settimeout(60)
                try:
                    attacks.read_http(sock)
                    answer(sock)
                except (OSError, AssertionError):
                    pass  # the client had enough

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.getsockname()[1]}/"
        finally:
            ended.set()
            server.close()


def respond(body: bytes) -> bytes:
    return b"HTTP/1.1 200 OK\r\nContent-length: %d\r\n\r\n" % len(body) + body


def _endless_body(sock: socket.socket) -> None:
    sock.sendall(b"HTTP/1.1 200 OK\r\n\r\n")
    while True:
        sock.sendall(b"x" * 65536)


def _endless_head(sock: socket.socket) -> None:
    sock.sendall(b"HTTP/1.1 200 OK\r\n")
    while True:
        sock.sendall(b"X-More: of this\r\n" * 1000)


def _drip(sock: socket.socket) -> None:
    for byte in respond(b"<methodResponse>" * 100):
        sock.sendall(bytes((byte,)))
        time.sleep(0.05)


def _reset(sock: socket.socket) -> None:
    sock.sendall(b"HTTP/1.1 200 OK\r\nContent-length: 500\r\n\r\n<method")
    attacks.reset(sock)


DEEP = b"<methodResponse><params><param><value>" + b"<array><data><value>" * 100_000
ODD_ANSWERS: dict[str, Callable[[socket.socket], None]] = {
    "silent": lambda sock: time.sleep(3),
    "closed": lambda sock: None,
    "reset": _reset,
    "drip": _drip,
    "endless body": _endless_body,
    "endless head": _endless_head,
    "nested": lambda sock: sock.sendall(respond(DEEP)),
    "bomb": lambda sock: sock.sendall(respond(BILLION_LAUGHS)),
    "html": lambda sock: sock.sendall(respond(b"<html><body>It works!</body></html>")),
    "huge length": lambda sock: sock.sendall(b"HTTP/1.1 200 OK\r\nContent-length: 99999999999\r\n\r\n"),
    "status": lambda sock: sock.sendall(b"HTTP/1.1 500 No\r\nContent-length: 0\r\n\r\n"),
    "redirect": lambda sock: sock.sendall(
        b"HTTP/1.1 301 Moved\r\nLocation: http://127.0.0.1:1/\r\nContent-length: 0\r\n\r\n"
    ),
}


@pytest.mark.parametrize("kind", ODD_ANSWERS)
def test_servers_that_answer_oddly(kind: str) -> None:
    """25: a call ends with a documented error within its timeout, and takes no memory for it."""
    with (
        odd_server(ODD_ANSWERS[kind]) as uri,
        MasterClient(uri, "/x", limits=Limits(xml_body_bytes=1 << 20)) as client,
    ):
        began = time.monotonic()
        with pytest.raises(RosError):
            client.get_pid(timeout=1.0)
        assert time.monotonic() - began < 4 * crowd()
