"""docs/wire.md against a running node: what comes instead of a good TCPROS header or request."""

from __future__ import annotations

import logging
import socket
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, closing

import pytest

from rosproto.master import Master
from rosproto.node import MasterClient, Node
from rosproto.protocol.handshake import encode_header
from rosproto.protocol.wire_limits import Limits
from tests.support import attacks
from tests.support.victim import Victim, eventually

Unharmed = Callable[..., AbstractContextManager[None]]
REQUEST = struct.pack("<I", 1) + b"\x01"  # a SetBool request, true
ANSWER = b"\x01" + struct.pack("<IBI", 9, 1, 4) + b"echo"


@pytest.fixture
def node() -> Iterator[Node]:
    """A node in this process, with short times, which publishes /kept and answers /empty."""
    limits = Limits(handshake_seconds=1.0)
    with Master() as master, Node("/inside", master_uri=master.uri, limits=limits, rosout=False) as node:
        node.publisher("/kept", "std_msgs/String", latch=True).publish(data="kept")
        node.service_server("/empty", "std_srvs/Empty", lambda request: {})
        yield node


def tcpros(node: Node, data: bytes = b"") -> socket.socket:
    return attacks.connect(("127.0.0.1", node.tcpros_address[1]), data)


@pytest.mark.promise(
    "gives a value or a documented error on *that one* connection",
    "A header length of 4,294,967,295 makes rospy wait",
)
@pytest.mark.parametrize("length", [0, 1, 3, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, (1 << 20) + 1])
def test_a_header_of_impossible_length_ends_the_connection(
    length: int, victim: Victim, unharmed: Unharmed
) -> None:
    """Refused before memory is taken: 200 connections announce it and send a little (10, section 10)."""
    with (
        unharmed(memory=32),
        attacks.many(victim.tcpros, 200, struct.pack("<I", length) + b"abcd" * 20) as all_,
    ):
        for sock in all_:
            assert attacks.ended_by_peer(sock, Victim.HANDSHAKE_SECONDS + 3)


def test_a_header_of_a_hundred_thousand_fields(victim: Victim, unharmed: Unharmed) -> None:
    """As many fields as fit into the largest header, twenty of those at once: refused after a thousand each."""
    body = b"".join(struct.pack("<I", 7) + b"%06x=" % n for n in range(95_000))
    assert len(body) <= Limits().header_bytes
    # 20 MiB of headers arrive; decoding all fields would keep others waiting for seconds
    with unharmed(memory=128), attacks.many(victim.tcpros, 20) as sockets:
        for sock in sockets:
            try:
                sock.sendall(struct.pack("<I", len(body)) + body)
            except OSError:
                pass  # it was refused before the last byte
        for sock in sockets:
            assert attacks.ended_by_peer(sock, 10)


@pytest.mark.promise("Fields come in any order, unknown keys")
def test_any_order_unknown_keys_and_equals_signs(victim: Victim) -> None:
    """1, 2: fields in reverse order, values with "=" and line breaks, a key nobody knows."""
    fields = [
        b"zzz=a=b=c\nd", b"topic=/tick", b"md5sum=992ce8a1687cec8c8bd883ec73ca41d1", b"type=std_msgs/String",
        b"callerid=/odd=name",
    ]  # fmt: skip
    body = b"".join(struct.pack("<I", len(field)) + field for field in fields)
    with attacks.connect(victim.tcpros, struct.pack("<I", len(body)) + body) as sock:
        reply = attacks.read_header(sock)
        assert reply["type"] == "std_msgs/String"
        assert "string data" in reply["message_definition"]
        assert attacks.read_frame(sock)[4:] == b"tick"


@pytest.mark.parametrize("absent", ["topic", "md5sum", "callerid"])
def test_a_subscriber_that_does_not_say_what_it_must(absent: str, victim: Victim, unharmed: Unharmed) -> None:
    """2: told in an error header, then the end."""
    with (
        unharmed(),
        attacks.connect(victim.tcpros, attacks.subscriber_header(**{"topic": "/tick", absent: ""})) as sock,
    ):
        reply = attacks.read_header(sock)
        assert list(reply) == ["error"]
        assert attacks.ended_by_peer(sock, 3)


def test_a_roscpp_subscriber_without_definition_and_rospys_wildcards(victim: Victim) -> None:
    """2, 4: no message_definition is needed, "*" for md5sum and type is welcome."""
    for fields in ({"message_definition": ""}, {"md5sum": "*", "type": "*"}, {"md5sum": "*"}):
        with attacks.connect(victim.tcpros, attacks.subscriber_header("/tick", **fields)) as sock:
            assert attacks.read_header(sock)["md5sum"] == attacks.STRING_MD5
            assert attacks.read_frame(sock)[4:] == b"tick"


@pytest.mark.parametrize(
    "fields", [{"md5sum": "0" * 32}, {"type": "a/B", "md5sum": "1" * 32}, {"topic": "/none"}]
)
def test_three_hundred_wrong_subscribers(fields: dict[str, str], victim: Victim, unharmed: Unharmed) -> None:
    """Another md5sum, another type, a topic that is not published: an error header for each (5)."""
    header = attacks.subscriber_header(**{"topic": "/tick", **fields})  # type: ignore[arg-type]
    with unharmed():
        for _ in range(300):
            with attacks.connect(victim.tcpros, header) as sock:
                assert list(attacks.read_header(sock)) == ["error"]


@pytest.mark.promise("rospy's service client wants `type` in the reply")
def test_a_probe_gets_the_header_rospy_needs(victim: Victim, unharmed: Unharmed) -> None:
    """3, 8: md5sum and type (and no more is sent); wrong sums, unknown services get an error."""
    with unharmed():
        for _ in range(100):
            with attacks.connect(victim.tcpros, attacks.service_header(probe="1", md5sum="*")) as sock:
                reply = attacks.read_header(sock)
                assert reply["md5sum"] == attacks.SETBOOL_MD5
                assert reply["type"] == "std_srvs/SetBool"
                assert attacks.ended_by_peer(sock, 5)
        for fields in ({"md5sum": "2" * 32}, {"service": "/none"}, {"md5sum": ""}, {"callerid": ""}):
            header = attacks.service_header(**{"service": "/echo", **fields})  # type: ignore[arg-type]
            with attacks.connect(victim.tcpros, header) as sock:
                assert "error" in attacks.read_header(sock)


@pytest.mark.promise("A probe ends after the header, and `rospy.wait_for_service`")
def test_probes_are_no_error(node: Node, caplog: pytest.LogCaptureFixture) -> None:
    """8: connect and close, a header and no wait for the answer: nothing above debug is logged."""
    caplog.set_level(logging.DEBUG)
    for data in (
        b"",
        b"\x20",
        attacks.service_header("/empty", probe="1", md5sum="*"),
        attacks.subscriber_header("/kept"),
    ):
        for end in (socket.socket.close, attacks.reset):
            end(tcpros(node, data))
    eventually(lambda: node._parts.context.listening.endpoints.tcpros.connections == 0)
    loud = [record.getMessage() for record in caplog.records if record.levelno > logging.INFO]
    assert not loud


@pytest.mark.promise("`persistent` is true as `1` or `true`")
@pytest.mark.parametrize("word", ["1", "true", "TRUE", "True"])
def test_persistent_in_every_spelling(word: str, victim: Victim) -> None:
    """7: the link stays after an answer; without the word it ends."""
    with attacks.connect(victim.tcpros, attacks.service_header(persistent=word)) as sock:
        attacks.read_header(sock)
        for _ in range(3):
            sock.sendall(REQUEST)
            assert attacks.read_exactly(sock, len(ANSWER)) == ANSWER
    with attacks.connect(victim.tcpros, attacks.service_header() + REQUEST) as sock:
        attacks.read_header(sock)
        assert attacks.read_exactly(sock, len(ANSWER)) == ANSWER
        assert attacks.ended_by_peer(sock, 5)


def test_pipelined_requests_are_answered_in_order(victim: Victim) -> None:
    """16: header and a hundred requests in one piece, every second one false."""
    other = struct.pack("<I", 1) + b"\0"
    with attacks.connect(
        victim.tcpros, attacks.service_header(persistent="1") + (REQUEST + other) * 50
    ) as sock:
        attacks.read_header(sock)
        for _ in range(50):
            assert attacks.read_exactly(sock, len(ANSWER)) == ANSWER
            assert attacks.read_exactly(sock, len(ANSWER))[5] == 0


@pytest.mark.promise("Several requests may be sent before the first")
def test_clients_that_leave_anywhere_in_a_request(victim: Victim, unharmed: Unharmed) -> None:
    """16: with FIN and with RST, three hundred times."""
    data = attacks.service_header(persistent="1") + REQUEST * 2
    with unharmed():
        for number in range(300):
            sock = attacks.connect(victim.tcpros, data[: number % (len(data) + 1)])
            if number % 2:
                sock.close()
            else:
                attacks.reset(sock)


@pytest.mark.promise("gives a value or a documented error on *that one* connection")
@pytest.mark.parametrize("length", [0xFFFFFFFF, 1_000_000_001, 999_999_999])
def test_request_length_bombs(length: int, victim: Victim, unharmed: Unharmed) -> None:
    """10: a gigabyte announced by fifty clients, a kilobyte sent."""
    data = attacks.service_header(persistent="1") + struct.pack("<I", length) + bytes(1000)
    with unharmed(memory=48), attacks.many(victim.tcpros, 50, data) as sockets:
        for sock in sockets:
            attacks.read_header(sock)
        if length > Limits().message_bytes:
            assert all(attacks.ended_by_peer(sock, 5) for sock in sockets)


def test_garbage_requests_are_service_errors(victim: Victim, unharmed: Unharmed) -> None:
    """Bytes that are not a request of this type: an error answer, and the link goes on (15)."""
    with unharmed(), attacks.connect(victim.tcpros, attacks.service_header(persistent="1")) as sock:
        attacks.read_header(sock)
        for size in (0, 2, 1000, 100_000):
            sock.sendall(struct.pack("<I", size) + b"\xff" * size)
            assert attacks.read_exactly(sock, 1) == b"\0"
            assert attacks.read_frame(sock)
        sock.sendall(REQUEST)
        assert attacks.read_exactly(sock, len(ANSWER)) == ANSWER


@pytest.mark.promise("A message may have no bytes at all")
def test_messages_without_a_byte(node: Node) -> None:
    """11: std_msgs/Empty and std_srvs/Empty are a length of zero and nothing else."""
    publisher = node.publisher("/nothing", "std_msgs/Empty")
    with tcpros(node, attacks.subscriber_header("/nothing", type="*", md5sum="*")) as sock:
        attacks.read_header(sock)
        publisher.wait_for_connection()
        publisher.publish()
        publisher.publish()
        assert attacks.read_exactly(sock, 8) == bytes(8)
    with tcpros(node, attacks.service_header("/empty", md5sum="*") + bytes(4)) as sock:
        attacks.read_header(sock)
        assert attacks.read_exactly(sock, 5) == b"\x01" + bytes(4)


@pytest.mark.promise("`tcp_nodelay` is what the subscriber asks for and")
def test_nodelay_is_set_on_every_socket_that_is_written(node: Node) -> None:
    """13: publisher, service server, subscriber and service client, asked or not; by TCP, as between two computers."""
    with Node("/other", master_uri=node.master_uri, rosout=False, intraprocess=False) as other:
        subscriber = other.subscriber("/kept", "std_msgs/String")
        assert subscriber.next(60).data == "kept"
        client = other.service_client("/empty", "std_srvs/Empty", persistent=True)
        client.call()
        publication = node._parts.topics.publication("/kept")
        subscription = other._parts.topics.subscription("/kept")
        assert publication is not None
        assert subscription is not None
        sockets = [publication.links[0].sock, next(iter(subscription.links.values()))._sock]  # type: ignore[attr-defined]
        sockets += [session._sock for session in _sessions(node)]
        assert len(sockets) == 3
        for sock in sockets:
            assert sock.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY) != 0


def _sessions(node: Node) -> list[object]:
    import gc

    from rosproto.node.services.server import ServiceSession

    return [s for s in gc.get_objects() if type(s) is ServiceSession and s.callerid == "/other"]


def test_a_name_as_host_refuses_nobody() -> None:
    """14: rospy with ROS_HOSTNAME=localhost refuses publishers elsewhere; here a publisher may be anywhere."""
    with (
        Master() as master,
        Node("/local", master_uri=master.uri, host="localhost", rosout=False, intraprocess=False) as local,
    ):
        try:
            other = Node(
                "/elsewhere", master_uri=master.uri, host="127.0.0.3", rosout=False, intraprocess=False
            )
        except OSError:
            pytest.skip("this computer has no other loopback addresses")
        with other:
            assert other.uri.startswith("http://127.0.0.3:")
            other.publisher("/far", "std_msgs/String", latch=True).publish(data="far")
            assert local.subscriber("/far", "std_msgs/String").next(60).data == "far"


@pytest.mark.promise("A refusal is one byte 0, a length")
@pytest.mark.parametrize("text", [b"\xff\xfe no text", b"", b"=", b"x" * 100_000])
def test_a_provider_whose_error_is_no_text(text: bytes, node: Node) -> None:
    """15: bytes that are not UTF-8, none, many; the link stays in step and open."""
    from rosproto.errors import ServiceError

    def provider(server: socket.socket) -> None:
        sock, _ = server.accept()
        with sock:
            sock.settimeout(60)
            attacks.read_header(sock)
            sock.sendall(encode_header({"callerid": "/fake", "md5sum": attacks.SETBOOL_MD5}))
            attacks.read_frame(sock)
            sock.sendall(b"\0" + struct.pack("<I", len(text)) + text)
            attacks.read_frame(sock)
            sock.sendall(ANSWER)

    with socket.create_server(("127.0.0.1", 0)) as server:
        thread = threading.Thread(target=provider, args=(server,), daemon=True)
        thread.start()
        uri = f"rosrpc://127.0.0.1:{server.getsockname()[1]}"
        with MasterClient(node.master_uri, "/provider") as master:
            master.register_service("/strange", uri, "http://127.0.0.1:1/")
        with closing(node.service_client("/strange", "std_srvs/SetBool", persistent=True)) as client:
            with pytest.raises(ServiceError):
                client.call(data=True, timeout=60)
            assert client.call(data=True, timeout=60).message == "echo"
        thread.join(120)
        assert not thread.is_alive()


def test_a_thousand_services_asked_at_once(victim: Victim, unharmed: Unharmed) -> None:
    """Two hundred persistent links that stay idle, four hundred one-shot calls beside them."""
    with unharmed(), ExitStack() as stack:
        for _ in range(200):
            stack.enter_context(attacks.connect(victim.tcpros, attacks.service_header(persistent="1")))
        for _ in range(400):
            with attacks.connect(victim.tcpros, attacks.service_header() + REQUEST) as sock:
                attacks.read_header(sock)
                assert attacks.read_exactly(sock, len(ANSWER)) == ANSWER
