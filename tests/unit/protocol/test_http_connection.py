"""HTTP messages without sockets."""

from __future__ import annotations

import pytest

from rosproto.errors import LocalProtocolError, RemoteProtocolError, TooLarge
from rosproto.protocol import http
from rosproto.protocol.wire_limits import Limits
from tests.support.splits import every_split, slices_of_one_buffer

LIMITS = Limits(http_head_bytes=512, xml_body_bytes=1000)
# as roscpp's XmlRpcClient writes it
ROSCPP = (
    b"POST / HTTP/1.1\r\nUser-Agent: XMLRPC++ 0.7\r\nHost: robot:11311\r\nContent-Type: text/xml\r\n"
    b"Content-length: 5\r\n\r\nhello"
)
CHUNKED = (
    b"POST /RPC2 HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n"
    b"3;extension=1\r\nhel\r\n02\r\nlo\r\n0\r\nTrailer: x\r\n\r\n"
)


def events(connection: http.HttpServerConnection | http.HttpClientConnection) -> list[http.Event]:
    found = []
    while (event := connection.next_event()) is not None:
        found.append(event)
        if isinstance(event, http.PeerClosed):
            break
    return found


def serve(data: bytes, limits: Limits = LIMITS) -> list[http.Event]:
    server = http.HttpServerConnection(limits)
    server.receive(data)
    return events(server)


def only(data: bytes) -> http.Request:
    (event,) = serve(data)
    assert isinstance(event, http.Request)
    return event


def test_roscpps_request_is_read() -> None:
    request = only(ROSCPP)
    assert (request.method, request.target, request.body, request.keep_alive) == ("POST", "/", b"hello", True)
    assert request.headers["host"] == "robot:11311"


def test_fields_that_come_twice_are_joined_as_a_list() -> None:
    """RFC 9110 section 5.3; the same value twice is one value."""
    request = only(
        b"POST / HTTP/1.1\r\nAccept: text/xml\r\nConnection: Keep-Alive\r\nConnection: close\r\n"
        b"Content-Length: 2\r\nContent-Length: 2\r\n\r\nhi"
    )
    assert request.headers["connection"] == "Keep-Alive, close"
    assert (request.body, request.keep_alive) == (b"hi", False)


@pytest.mark.parametrize("data", [ROSCPP, CHUNKED], ids=["length", "chunked"])
def test_every_split_gives_the_same_requests(data: bytes) -> None:
    expected = serve(data + data)
    assert len(expected) == 2
    for pieces in every_split(data + data):
        server, found = http.HttpServerConnection(LIMITS), []
        for piece in slices_of_one_buffer(pieces):
            server.receive(piece)
            found += events(server)
        assert found == expected
        assert not server.mid_message


def test_a_chunked_body_is_put_together() -> None:
    assert only(CHUNKED).body == b"hello"


def test_bare_newlines_and_leading_empty_lines_are_read() -> None:
    assert only(b"\r\n\n" + ROSCPP.replace(b"\r\n", b"\n")).body == b"hello"


@pytest.mark.parametrize(
    ("version", "connection", "keep_alive"),
    [
        ("1.1", "", True),
        ("1.1", "close", False),
        ("1.1", "Keep-Alive, TE", True),
        ("1.0", "", False),
        ("1.0", "Keep-Alive", True),
    ],
)
def test_keep_alive_is_what_version_and_connection_say(
    version: str, connection: str, keep_alive: bool
) -> None:
    header = f"Connection: {connection}\r\n" if connection else ""
    assert (
        only(f"POST / HTTP/{version}\r\n{header}Content-Length: 0\r\n\r\n".encode()).keep_alive is keep_alive
    )


def test_a_get_is_a_request_without_body() -> None:
    assert only(b"GET /favicon.ico HTTP/1.1\r\n\r\n")[:2] == ("GET", "/favicon.ico")


def test_expect_100_continue_asks_once_for_a_go_ahead() -> None:
    head, body = ROSCPP.replace(b"Host", b"Expect: 100-continue\r\nHost").split(b"\r\n\r\n")
    server = http.HttpServerConnection(LIMITS)
    server.receive(head + b"\r\n\r\n")
    assert isinstance(server.next_event(), http.ContinueWanted)
    assert server.next_event() is None
    server.receive(body)
    assert isinstance(server.next_event(), http.Request)
    server.receive(head + b"\r\n\r\n" + body)  # the body came along: nobody waits
    assert isinstance(server.next_event(), http.Request)


@pytest.mark.parametrize(
    ("data", "status"),
    [
        (b"nonsense\r\n\r\n", 400),
        (b"POST /\r\n\r\n", 400),
        (b"P(ST / HTTP/1.1\r\n\r\n", 400),
        (b"POST / HTTP/2.0\r\n\r\n", 505),
        (b"POST / HTTP/1.1\r\nno colon\r\n\r\n", 400),
        (b"POST / HTTP/1.1\r\nA: b\r\n folded\r\n\r\n", 400),
        (b"POST / HTTP/1.1\r\nContent-Length : 1\r\n\r\n", 400),
        (b"POST / HTTP/1.1\r\nContent-Length: -1\r\n\r\n", 400),
        (b"POST / HTTP/1.1\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\n", 400),
        (b"POST / HTTP/1.1\r\nContent-Length: 1\r\nTransfer-Encoding: chunked\r\n\r\n", 400),
        (b"POST / HTTP/1.1\r\nTransfer-Encoding: gzip\r\n\r\n", 501),
        (b"POST / HTTP/1.1\r\n\r\n", 411),
        (b"POST / HTTP/1.1\r\nExpect: tea\r\nContent-Length: 9\r\n\r\n", 417),
        (b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\nxyz\r\n", 400),
        (b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n-1\r\n", 400),
        (b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n" + b"0" * 300, 400),
        (b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n1\r\nabc\r\n", 400),
        (b"\x16\x03\x01\x02\x00\x01\x00\n\n", 400),  # TLS
    ],
)
def test_bad_requests_are_refused_with_their_status(data: bytes, status: int) -> None:
    with pytest.raises(RemoteProtocolError) as caught:
        serve(data)
    assert http.error_status(caught.value) == status


def test_equal_content_lengths_are_one() -> None:
    assert only(ROSCPP.replace(b"Host", b"Content-Length: 5\r\nHost")).body == b"hello"


def test_http_head_bytes_bounds_the_head() -> None:
    head = b"POST / HTTP/1.1\r\nContent-length: 0\r\nX: "
    assert only(head + b"x" * (512 - len(head)) + b"\r\n\r\n")
    for data in (head + b"x" * (513 - len(head)) + b"\r\n\r\n", b"x" * 513):
        with pytest.raises(TooLarge, match="http_head_bytes") as caught:
            serve(data)
        assert http.error_status(caught.value) == 431


@pytest.mark.parametrize("end", [b"\r\n\r\n", b"\n\n", b"\n\r\n"])
def test_a_head_as_long_as_allowed_may_come_byte_by_byte(end: bytes) -> None:
    """The empty line behind it does not count."""
    head = b"POST / HTTP/1.1\r\nContent-length: 0\r\nX: "
    whole = head + b"x" * (512 - len(head)) + end
    connection = http.HttpServerConnection(LIMITS)
    for at in range(len(whole)):
        assert connection.next_event() is None
        connection.receive(whole[at : at + 1])
    assert isinstance(connection.next_event(), http.Request)


def test_http_head_bytes_bounds_trailers() -> None:
    with pytest.raises(TooLarge, match="http_head_bytes"):
        serve(CHUNKED.replace(b"Trailer: x\r\n", b"Trailer: x\r\n" * 100))


@pytest.mark.parametrize(
    "data",
    [
        b"POST / HTTP/1.1\r\nContent-Length: 1001\r\n\r\n",
        b"POST / HTTP/1.1\r\nContent-Length: 99999999999999999999\r\n\r\n",
        b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n3e9\r\n",
        b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n1\r\nx\r\n3e8\r\n",
    ],
)
def test_xml_body_bytes_bounds_the_body_before_it_comes(data: bytes) -> None:
    with pytest.raises(TooLarge, match="xml_body_bytes") as caught:
        serve(data)
    assert http.error_status(caught.value) == 413


def test_a_peer_that_closes_between_requests_is_no_error() -> None:
    server = http.HttpServerConnection(LIMITS)
    server.receive(ROSCPP)
    assert isinstance(server.next_event(), http.Request)
    server.receive(b"")
    assert isinstance(server.next_event(), http.PeerClosed)


@pytest.mark.parametrize("cut", [1, 40, len(ROSCPP) - 1])
def test_a_peer_that_closes_inside_a_request_is(cut: int) -> None:
    server = http.HttpServerConnection(LIMITS)
    server.receive(ROSCPP[:cut])
    server.receive(b"")
    with pytest.raises(RemoteProtocolError, match="middle"):
        server.next_event()


def test_bytes_after_the_end_are_our_error() -> None:
    server = http.HttpServerConnection(LIMITS)
    server.receive(b"")
    with pytest.raises(LocalProtocolError):
        server.receive(b"x")


@pytest.mark.promise("roscpp reads only `HTTP/1.1 200 OK` or `HTTP/1.0")
def test_the_response_is_one_that_roscpps_client_accepts() -> None:
    data = http.HttpServerConnection(LIMITS).encode_response(200, b"<x/>")
    assert data.startswith(b"HTTP/1.1 200 OK\r\n")
    assert b"\r\nContent-length: 4\r\n" in data
    assert data.endswith(b"\r\n\r\n<x/>")
    assert b"chunked" not in data


def test_a_405_lists_the_methods_that_are_allowed() -> None:
    """RFC 9110, section 15.5.6."""
    head = http.HttpServerConnection(LIMITS).encode_response(405, allow="POST").partition(b"\r\n\r\n")[0]
    assert head.startswith(b"HTTP/1.1 405 ")
    assert b"\r\nAllow: POST\r\n" in head


def test_client_and_server_joined_exchange_messages() -> None:
    client, server = http.HttpClientConnection(LIMITS), http.HttpServerConnection(LIMITS)
    for number in range(3):
        server.receive(client.encode_request("h:1", "/", b"call %d" % number))
        request = server.next_event()
        assert isinstance(request, http.Request)
        assert request.headers["host"] == "h:1"
        client.receive(server.encode_response(200, request.body[::-1]))
        response = client.next_event()
        assert isinstance(response, http.Response)
        assert (response.status, response.reason, response.body) == (200, "OK", b"%d llac" % number)
        assert response.keep_alive


def receive(data: bytes, *, end: bool = False) -> list[http.Event]:
    client = http.HttpClientConnection(LIMITS)
    client.receive(data)
    if end:
        client.receive(b"")
    return events(client)


def test_a_response_without_length_lasts_until_the_end() -> None:
    client = http.HttpClientConnection(LIMITS)
    client.receive(b"HTTP/1.0 200 OK\r\n\r\nhel")
    assert client.next_event() is None
    client.receive(b"lo")
    client.receive(b"")
    response = client.next_event()
    assert isinstance(response, http.Response)
    assert (response.body, response.keep_alive) == (b"hello", False)


def test_a_body_until_the_end_is_bounded() -> None:
    with pytest.raises(TooLarge, match="xml_body_bytes"):
        receive(b"HTTP/1.0 200 OK\r\n\r\n" + b"x" * 1001)


def test_notes_on_the_way_are_skipped() -> None:
    (response,) = receive(http.CONTINUE + b"HTTP/1.1 200 OK\r\nContent-Length: 2\r\n\r\nok")
    assert isinstance(response, http.Response)
    assert response.body == b"ok"


def test_every_split_of_a_response_gives_the_same() -> None:
    data = http.CONTINUE + b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n2\r\nok\r\n0\r\n\r\n"
    for pieces in every_split(data):
        client, found = http.HttpClientConnection(LIMITS), []
        for piece in pieces:
            client.receive(piece)
            found += events(client)
        assert [event.body for event in found if isinstance(event, http.Response)] == [b"ok"]


def test_a_reason_may_be_missing_or_long() -> None:
    assert receive(b"HTTP/1.1 404\r\nContent-Length: 0\r\n\r\n")[0][:2] == (404, "")
    assert receive(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n")[0][:2] == (404, "Not Found")


@pytest.mark.parametrize(
    "start", [b"HTTP/3 200 OK", b"HTTP/1.1 20 OK", b"HTTP/1.1 abc OK", b"SSH-2.0-OpenSSH"]
)
def test_other_protocols_are_the_peers_error(start: bytes) -> None:
    with pytest.raises(RemoteProtocolError, match="status"):
        receive(start + b"\r\n\r\n")


def test_a_response_that_is_cut_off_is_the_peers_error() -> None:
    with pytest.raises(RemoteProtocolError, match="middle"):
        receive(b"HTTP/1.1 200 OK\r\nContent-Length: 5\r\n\r\nhell", end=True)


def test_line_breaks_cannot_be_smuggled_into_a_head() -> None:
    with pytest.raises(LocalProtocolError, match="line break"):
        http.HttpClientConnection(LIMITS).encode_request("h", "/ HTTP/1.1\r\nX: y", b"")
