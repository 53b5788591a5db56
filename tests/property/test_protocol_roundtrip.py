"""Decoding undoes encoding, however the bytes are cut, and agrees with Python's own xmlrpc."""

from __future__ import annotations

import math
import xmlrpc.client as stdlib
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosproto.errors import LocalProtocolError, RemoteProtocolError
from rosproto.protocol import http, xmlrpc
from rosproto.protocol.framing import FrameDecoder, frame
from rosproto.protocol.handshake import decode_header, encode_header
from rosproto.protocol.wire_limits import Limits
from tests.support.frames import feed


# what header fields can hold: any text and, as surrogate escapes, any bytes
def as_field_text(data: bytes) -> str:
    return data.decode("utf-8", "surrogateescape")


raw_text = st.binary(max_size=50).map(as_field_text)
keys = (
    st.binary(max_size=50).map(lambda data: data.replace(b"=", b"").strip()).filter(bool).map(as_field_text)
)
headers = st.dictionaries(keys, raw_text, max_size=6)

# what XML 1.0 carries unchanged
xml_text = st.text(
    st.characters(
        exclude_categories=["Cs", "Cc"], exclude_characters="\ufffe\uffff", include_characters="\t\n"
    ),
    max_size=30,
)
scalars = (
    xml_text
    | st.integers(-(2**31), 2**31 - 1)
    | st.booleans()
    | st.floats(allow_nan=False)
    | st.binary(max_size=40)
)
values = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(xml_text, inner, max_size=4),
    max_leaves=15,
)


@st.composite
def cut(draw: st.DrawFn, data: bytes) -> list[bytes]:
    """The data in pieces."""
    cuts = sorted(draw(st.lists(st.integers(0, len(data)), max_size=8)))
    return [data[start:end] for start, end in pairwise([0, *cuts, len(data)])]


@given(headers)
def test_headers(fields: dict[str, str]) -> None:
    data = encode_header(fields)
    assert int.from_bytes(data[:4], "little") == len(data) - 4
    assert decode_header(data[4:]) == fields
    assert encode_header(decode_header(data[4:])) == data


@given(st.binary(max_size=60))
def test_any_header_bytes_give_fields_or_a_refusal(data: bytes) -> None:
    try:
        fields = decode_header(data)
    except RemoteProtocolError:
        return
    assert decode_header(encode_header(fields)[4:]) == fields


@given(st.lists(st.binary(max_size=30), max_size=5), st.binary(max_size=3), st.data())
def test_frames(payloads: list[bytes], rest: bytes, data: st.DataObject) -> None:
    decoder, frames = FrameDecoder(100), []
    for piece in data.draw(cut(b"".join(map(frame, payloads)) + rest)):
        frames += feed(decoder, piece)
    assert frames == payloads
    assert decoder.buffered == len(rest)


def same(one: object, other: object) -> bool:
    return one == other and repr(one) == repr(other)  # tells True from 1, 1 from 1.0, 0.0 from -0.0


@given(xml_text.filter(str.strip), st.lists(values, max_size=3))
def test_calls(method: str, params: list[object]) -> None:
    assert same(xmlrpc.decode_call(xmlrpc.encode_call(method, params)), (method.strip(), params))


@given(values)
def test_pythons_xmlrpc_reads_what_we_write(value: object) -> None:
    (theirs,), _ = stdlib.loads(xmlrpc.encode_response(value), use_builtin_types=True)
    assert same(theirs, value)


@given(values)
def test_we_read_what_pythons_xmlrpc_writes(value: object) -> None:
    document = stdlib.dumps((value,), methodresponse=True).encode()  # type: ignore[arg-type]
    assert same(xmlrpc.decode_response(document), value)


@given(st.floats())
def test_doubles_keep_every_bit_that_python_shows(value: float) -> None:
    read = xmlrpc.decode_response(xmlrpc.encode_response(value))
    assert isinstance(read, float)
    assert read == value or (math.isnan(read) and math.isnan(value))


@given(st.text(max_size=20))
def test_text_is_carried_or_refused_never_changed(text: str) -> None:
    try:
        document = xmlrpc.encode_response(text)
    except LocalProtocolError:
        return
    expected = text.replace("\r\n", "\n").replace("\r", "\n")  # XML's own rule for line ends
    assert xmlrpc.decode_response(document) == expected
    assert b"&#" not in document.replace(b"&amp;", b"")


@given(st.binary(max_size=80) | st.text("<>/ valueintrgmhodCPps1&;", max_size=120).map(str.encode))
def test_any_document_gives_values_or_a_refusal(document: bytes) -> None:
    with_errors = (RemoteProtocolError, xmlrpc.Fault)
    for decode in (xmlrpc.decode_call, xmlrpc.decode_response):
        try:
            decode(document)
        except with_errors:
            continue


@given(st.lists(st.binary(max_size=50), min_size=1, max_size=4), st.data())
def test_http_requests_and_responses(bodies: list[bytes], data: st.DataObject) -> None:
    client, server = http.HttpClientConnection(Limits()), http.HttpServerConnection(Limits())
    received: list[bytes] = []
    for piece in data.draw(cut(b"".join(client.encode_request("h:1", "/", body) for body in bodies))):
        if piece:
            server.receive(piece)
        while isinstance(event := server.next_event(), http.Request):
            received.append(event.body)
    assert received == bodies
    answers: list[bytes] = []
    for piece in data.draw(cut(b"".join(server.encode_response(200, body) for body in bodies))):
        if piece:
            client.receive(piece)
        while isinstance(answer := client.next_event(), http.Response):
            answers.append(answer.body)
    assert answers == bodies


@given(st.lists(st.binary(min_size=1, max_size=20), max_size=5), st.data())
def test_chunked_bodies(chunks: list[bytes], data: st.DataObject) -> None:
    stream = b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n"
    stream += b"".join(b"%x\r\n%b\r\n" % (len(chunk), chunk) for chunk in chunks) + b"0\r\n\r\n"
    server = http.HttpServerConnection(Limits())
    found = []
    for piece in data.draw(cut(stream)):
        if piece:
            server.receive(piece)
        while (event := server.next_event()) is not None:
            found.append(event)
    (request,) = found
    assert isinstance(request, http.Request)
    assert request.body == b"".join(chunks)


@pytest.mark.parametrize("value", [-0.0, 5e-324, 2.2250738585072014e-308])
def test_special_doubles(value: float) -> None:
    assert same(xmlrpc.decode_response(xmlrpc.encode_response(value)), value)
