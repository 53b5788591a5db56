"""Fuzz targets of rosproto.protocol: header, framing, handshake, XML-RPC, HTTP."""

from __future__ import annotations

from collections.abc import Callable

from rosproto.errors import LocalProtocolError, RemoteProtocolError
from rosproto.protocol import handshake, http, xmlrpc
from rosproto.protocol.framing import FrameDecoder
from rosproto.protocol.handshake import decode_header, encode_header
from rosproto.protocol.wire_limits import Limits
from tests.support.frames import feed

LIMITS = Limits(header_bytes=4096, xml_body_bytes=1 << 14, http_head_bytes=1024)


def header(data: bytes) -> str:
    """Fields that were read are written and read back the same."""
    try:
        fields = decode_header(data)
    except RemoteProtocolError as error:
        return str(error)
    assert decode_header(encode_header(fields)[4:]) == fields
    return f"{len(fields)} fields"


def framing(data: bytes) -> str:
    """However the stream is cut, the frames (and the refusal) are the same."""
    results = [_frames([data]), _frames([data[i : i + 1] for i in range(len(data))])]
    results.append(_frames([data[: len(data) // 2], data[len(data) // 2 :]]))
    assert results[0] == results[1] == results[2]
    return str(results[0][-1:])[:20]


def _frames(pieces: list[bytes]) -> list[bytes | str]:
    decoder = FrameDecoder(LIMITS.header_bytes)
    out: list[bytes | str] = []
    for piece in pieces:
        try:
            out += feed(decoder, piece)
        except RemoteProtocolError as error:
            return [*out, str(error)]
    return [*out, str(decoder.buffered)]


def shake(data: bytes) -> str:
    """A header that was read is accepted or refused by each role."""
    try:
        fields = decode_header(data)
    except RemoteProtocolError:
        return "no header"
    outcomes = []
    md5sum = "992ce8a1687cec8c8bd883ec73ca41d1"
    for check, name in (
        (handshake.check_subscriber_header, "topic"),
        (handshake.check_publisher_header, "topic"),
        (handshake.check_service_client_header, "service"),
        (handshake.check_service_server_header, "service"),
    ):
        wanted = {name: fields.get(name, "/t"), "type_name": "std_msgs/String", "md5sum": md5sum}
        try:
            check(fields, **wanted)  # type: ignore[operator]
            outcomes.append("ok")
        except RemoteProtocolError as error:
            # the text goes back to the peer in an error header
            decode_header(encode_header(handshake.error_header(str(error)))[4:])
            outcomes.append(type(error).__name__)
    return " ".join(outcomes)


def xmlrpc_call(data: bytes) -> str:
    """Arguments that were read can be written and read back, or are refused when written."""
    try:
        method, params = xmlrpc.decode_call(data, LIMITS)
    except RemoteProtocolError as error:
        return str(error)
    try:
        again = xmlrpc.encode_call(method, params)
    except LocalProtocolError as error:
        return str(error)
    assert repr(_no_returns(xmlrpc.decode_call(again))) == repr(_no_returns((method.strip(), params)))
    return "ok"


def _no_returns(value: object) -> object:
    """Carriage returns are read from `&#13;` but come back as newlines: XML's own rule."""
    if isinstance(value, str):
        return type(value)(value.replace("\r\n", "\n").replace("\r", "\n"))
    if isinstance(value, (list, tuple)):
        return [_no_returns(item) for item in value]
    if isinstance(value, dict):
        return {_no_returns(key): _no_returns(item) for key, item in value.items()}
    return value


def xmlrpc_response(data: bytes) -> str:
    try:
        xmlrpc.decode_response(data, LIMITS)
    except (RemoteProtocolError, xmlrpc.Fault) as error:
        return str(error)
    return "ok"


def http_request(data: bytes) -> str:
    return _http(http.HttpServerConnection, data)


def http_response(data: bytes) -> str:
    return _http(http.HttpClientConnection, data)


def _http(
    make: Callable[[Limits], http.HttpServerConnection | http.HttpClientConnection], data: bytes
) -> str:
    """However the stream is cut, the messages are the same."""
    whole = _messages(make(LIMITS), [data])
    half = len(data) // 2
    assert whole == _messages(make(LIMITS), [data[:half], data[half:]])
    if len(data) < 2000:
        assert whole == _messages(make(LIMITS), [data[i : i + 1] for i in range(len(data))])
    return str([item if isinstance(item, str) else type(item).__name__ for item in whole])


def _messages(
    connection: http.HttpServerConnection | http.HttpClientConnection, pieces: list[bytes]
) -> list[object]:
    out: list[object] = []
    for piece in [*filter(None, pieces), b""]:
        connection.receive(piece)
        try:
            while (event := connection.next_event()) is not None:
                if isinstance(event, http.PeerClosed):
                    return [*out, "closed"]
                if not isinstance(event, http.ContinueWanted):  # depends on what came along
                    out.append(event)
        except RemoteProtocolError as error:
            return [*out, f"refused {http.error_status(error)}"]
    return out


TARGETS = {
    "header": header,
    "framing": framing,
    "handshake": shake,
    "xmlrpc_call": xmlrpc_call,
    "xmlrpc_response": xmlrpc_response,
    "http_request": http_request,
    "http_response": http_response,
}

_XML = [
    *(
        b"<%b>" % tag
        for tag in b"value int i4 i8 boolean double string base64 array data struct member name".split()
    ),
    *(
        b"</%b>" % tag
        for tag in b"value int i4 i8 boolean double string base64 array data struct member name".split()
    ),
    *b"<nil/> <ex:nil/> <params> </params> <param> </param> <fault> </fault> <dateTime.iso8601> &amp; &lt; &#13;".split(),
    *b"&#0; &x; <![CDATA[ ]]> <!-- --> <!DOCTYPE <!ENTITY <?xml ?> encoding='utf-16' encoding='zlib' nan 1e999 \xff".split(),
]
_HTTP = [
    *b"Content-Length: Transfer-Encoding: chunked gzip Connection: close keep-alive Expect: 100-continue".split(),
    *(
        b"\r\n",
        b"\n",
        b"\r\n\r\n",
        b"0\r\n\r\n",
        b"HTTP/1.0",
        b"HTTP/1.1",
        b"POST",
        b"GET",
        b": ",
        b" ",
        b"\0",
    ),
]
_FIELDS = [
    *b"callerid= topic= md5sum= type= service= error= persistent= probe= * = 1 latching= message_definition=".split(),
    b"992ce8a1687cec8c8bd883ec73ca41d1",
]
TOKENS = {
    "header": _FIELDS,
    "handshake": _FIELDS,
    "xmlrpc_call": _XML,
    "xmlrpc_response": _XML,
    "http_request": _HTTP,
    "http_response": _HTTP,
}
