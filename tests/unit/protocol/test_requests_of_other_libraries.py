"""HTTP requests as libraries of other languages write them, read in one piece and byte by byte."""

from __future__ import annotations

import pytest

from rosproto.protocol import xmlrpc
from rosproto.protocol.http import ContinueWanted, HttpServerConnection, Request
from rosproto.protocol.wire_limits import Limits

PARAMS = ["/me", "/chatter", "std_msgs/String", "http://10.0.0.9:40001/"]


def values(form: str) -> str:
    return "".join(f"<param><value>{form.format(text)}</value></param>" for text in PARAMS)


def chunked(body: str) -> str:
    half = len(body) // 2
    return "".join(f"{len(part):x}\r\n{part}\r\n" for part in (body[:half], body[half:])) + "0\r\n\r\n"


def call(head: str, params: str, attributes: str = "") -> str:
    return f"{head}<methodCall{attributes}><methodName>registerPublisher</methodName><params>{params}</params></methodCall>"


APACHE = ' xmlns:ex="http://ws.apache.org/xmlrpc/namespaces/extensions"'
PEERS = {
    # Apache XML-RPC 3, under rosjava and MATLAB's ROS Toolbox: strings without a type, either way of framing.
    "apache": (
        "POST / HTTP/1.1\r\nContent-Type: text/xml\r\nUser-Agent: Apache XML RPC 3.1.3 (Jakarta Commons httpclient Transport)\r\n"
        "Cache-Control: no-cache\r\nPragma: no-cache\r\nHost: robot:11311\r\nConnection: keep-alive\r\n",
        call('<?xml version="1.0" encoding="UTF-8"?>', values("{}"), APACHE), False,
    ),
    "apache, streaming": (
        "POST / HTTP/1.1\r\nContent-Type: text/xml\r\nHost: robot:11311\r\nTransfer-Encoding: chunked\r\n",
        call('<?xml version="1.0" encoding="UTF-8"?>', values("{}"), APACHE), True,
    ),
    # Go's net/http, under goroslib: a body of unknown length is chunked.
    "go": (
        "POST / HTTP/1.1\r\nHost: robot:11311\r\nUser-Agent: Go-http-client/1.1\r\nTransfer-Encoding: chunked\r\n"
        "Content-Type: text/xml\r\nAccept-Encoding: gzip\r\n",
        call('<?xml version="1.0" encoding="UTF-8"?>\n', values("<string>{}</string>")), True,
    ),
    # npm's xmlrpc, under rosnodejs: CDATA for what would need escaping.
    "node": (
        "POST / HTTP/1.1\r\nUser-Agent: NodeJS XML-RPC Client\r\nContent-Type: text/xml\r\nAccept: text/xml\r\n"
        "Accept-Charset: UTF8\r\nHost: robot:11311\r\nConnection: Keep-Alive\r\n",
        call('<?xml version="1.0"?>', values("<string><![CDATA[{}]]></string>")), False,
    ),
    # Python 2's xmlrpclib, with the line breaks that it puts between elements, through a proxy.
    "python, proxy": (
        "POST http://robot:11311/RPC2 HTTP/1.0\r\nHost: robot:11311\r\nUser-Agent: xmlrpclib.py/1.0.1\r\nContent-Type: text/xml\r\n",
        call("<?xml version='1.0'?>\n", values("<string>{}</string>").replace("><", ">\n<")) + "\n", False,
    ),
    # curl -d @file, which asks first when the body is long; a byte order mark from an editor.
    "curl": (
        "POST / HTTP/1.1\r\nHost: robot:11311\r\nUser-Agent: curl/7.88.1\r\nAccept: */*\r\nExpect: 100-continue\r\n"
        "Content-Type: application/x-www-form-urlencoded\r\n",
        call("\ufeff", values("<string>{}</string>")), False,
    ),
}  # fmt: skip


@pytest.mark.parametrize("peer", PEERS)
@pytest.mark.parametrize("step", [1, 1 << 20], ids=["bytes", "whole"])
def test_a_registration_is_read(peer: str, step: int) -> None:
    """Path, method and all four arguments."""
    head, text, in_chunks = PEERS[peer]
    if in_chunks:
        data = f"{head}\r\n{chunked(text)}".encode()
    else:
        data = f"{head}Content-Length: {len(text.encode())}\r\n\r\n{text}".encode()
    connection = HttpServerConnection(Limits())
    events = []
    for start in range(0, len(data), step):
        connection.receive(data[start : start + step])
        while (event := connection.next_event()) is not None:
            events.append(event)
    asked = [event for event in events if isinstance(event, ContinueWanted)]
    (request,) = (event for event in events if isinstance(event, Request))
    assert len(asked) == (1 if peer == "curl" and step == 1 else 0)
    assert request.target in ("/", "/RPC2")
    assert xmlrpc.decode_call(request.body, Limits()) == ("registerPublisher", PARAMS)


@pytest.mark.parametrize(
    ("target", "path"),
    [
        ("http://robot:11311/", "/"),
        ("http://robot:11311", "/"),
        ("HTTP://[::1]:11311/RPC2?x=http://y/", "/RPC2?x=http://y/"),
        ("/a?to=http://b/", "/a?to=http://b/"),
        ("*", "*"),
    ],
)
def test_the_host_in_a_target_is_left_out(target: str, path: str) -> None:
    """RFC 9112, 3.2.2; what is behind a path or question mark is none."""
    connection = HttpServerConnection(Limits())
    connection.receive(f"GET {target} HTTP/1.1\r\n\r\n".encode())
    event = connection.next_event()
    assert isinstance(event, Request)
    assert event.target == path
