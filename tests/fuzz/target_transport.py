"""Fuzz targets of rosproto.transport: URIs and hosts that peers send."""

from __future__ import annotations

from rosproto.transport.own_address import host_from_environment
from rosproto.transport.uri import is_loopback, make_uri, parse_uri, same_uri, uri_path


def uri(data: bytes) -> str:
    """A URI gives host and port that make the same URI again, or a ValueError; never a name lookup."""
    text = data.decode("utf-8", "surrogateescape")
    assert same_uri(text, text)
    assert uri_path(text).startswith("/")
    is_loopback(text)
    try:
        host, port = parse_uri(text)
    except ValueError as error:
        return str(error)
    assert host
    assert 0 <= port <= 65535
    assert parse_uri(make_uri(host, port)) == (host, port)
    return "ok"


def environment(data: bytes) -> str:
    text = data.decode("utf-8", "surrogateescape")
    try:
        return "set" if host_from_environment({"ROS_HOSTNAME": text}) else "not set"
    except ValueError as error:
        return str(error)


TARGETS = {"uri": uri, "environment": environment}
_WORDS = [
    *b"http:// rosrpc:// [ ] :: ::1 localhost 10.0.0.7 :11311 : / // ? # @ %eth0 65536 ::ffff:127.0.0.1".split()
]
TOKENS = {"uri": _WORDS, "environment": _WORDS}
