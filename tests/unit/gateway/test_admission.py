"""Who may become a client of a gateway: whole tables of tokens, hosts, origins and protocols."""

from __future__ import annotations

import pytest

from rosproto.gateway.admission import (
    Admission,
    foreign_host,
    foreign_origin,
    require_token_off_loopback,
    token_fits,
)
from rosproto.transport.uri import is_loopback


@pytest.mark.parametrize(
    ("given", "expected", "fits"),
    [
        (None, None, True),
        ("x", None, True),
        (None, "t", False),
        ("", "t", False),
        ("t", "t", True),
        ("tt", "t", False),
        ("\udc80", "t", False),
    ],
)
def test_token(given: str | None, expected: str | None, fits: bool) -> None:
    """Asked for only where there is one."""
    assert token_fits(given, expected) is fits


@pytest.mark.parametrize(
    ("host", "loopback"),
    [
        ("127.0.0.1", True),
        ("127.9.9.9", True),
        ("::1", True),
        ("[::1]", True),
        ("localhost", True),
        ("LOCALHOST", True),
        ("0.0.0.0", False),
        ("::", False),
        ("", False),
        ("10.0.0.7", False),
        ("localhost.evil.com", False),
        ("127.0.0.1.evil.com", False),
    ],
)
def test_what_is_loopback(host: str, loopback: bool) -> None:
    """And what only looks so; off it, no token is no start."""
    assert is_loopback(host) is loopback
    if loopback:
        require_token_off_loopback(host, None)
    else:
        with pytest.raises(ValueError, match="token"):
            require_token_off_loopback(host, None)
    require_token_off_loopback(host, "secret")
    with pytest.raises(ValueError, match="empty"):
        require_token_off_loopback(host, "")


@pytest.mark.promise("Web pages of other sites are refused by their origin", "unless its origin is allowed")
@pytest.mark.parametrize(
    ("origin", "origins", "may"),
    [
        (None, (), True),
        ("http://localhost:8080", (), True),
        ("https://127.0.0.1", (), True),
        ("http://[::1]:3000", (), True),
        ("http://evil.com", (), False),
        ("http://localhost.evil.com", (), False),
        ("http://localhost@evil.com", (), False),
        ("http://evil.com/localhost", (), False),
        ("null", (), False),
        ("null", ("null",), True),
        ("", (), False),
        ("file://", (), False),
        ("chrome-extension://localhost", (), False),
        ("http://[::1", (), False),
        ("https://studio.example", ("https://studio.example",), True),
        ("http://studio.example", ("https://studio.example",), False),
        ("http://evil.com", ("*",), True),
    ],
)
def test_origins(origin: str | None, origins: tuple[str, ...], may: bool) -> None:
    """A page from elsewhere may not connect; a client without an origin may."""
    assert (foreign_origin(origin, origins) is None) is may


@pytest.mark.promise("Web pages of other sites are refused by their origin", "unless its origin is allowed")
@pytest.mark.parametrize(
    ("host", "bound", "ours"),
    [
        ("localhost:9090", "127.0.0.1", True),
        ("127.0.0.1", "127.0.0.1", True),
        ("[::1]:9090", "::1", True),
        (None, "127.0.0.1", True),
        ("evil.com:9090", "127.0.0.1", False),
        ("evil.com", "127.0.0.1", False),
        ("evil.com:9090", "10.0.0.7", True),
    ],
)
def test_hosts(host: str | None, bound: str, ours: bool) -> None:
    """On loopback a foreign name is a page that was led here."""
    assert (foreign_host(host, bound) is None) is ours


FOXGLOVE = ("foxglove.sdk.v1", "foxglove.websocket.v1")


@pytest.mark.promise("It listens on 127.0.0.1; other addresses need a token.")
@pytest.mark.parametrize(
    ("path", "headers", "reason"),
    [
        ("/", {}, "token"),
        ("/?token=t", {}, "protocol"),
        ("/?token=t", {"Sec-WebSocket-Protocol": ["chat"]}, "protocol"),
        ("/?token=t", {"Sec-WebSocket-Protocol": ["chat, foxglove.websocket.v1"]}, None),
        ("/?token=t", {"Sec-WebSocket-Protocol": ["chat", "foxglove.sdk.v1"]}, None),
        ("/", {"Sec-WebSocket-Protocol": [FOXGLOVE[0]], "Authorization": ["bearer t"]}, None),
        ("/", {"Sec-WebSocket-Protocol": [FOXGLOVE[0]], "Authorization": ["Basic t"]}, "token"),
        ("/?token=t&" + "a=1&" * 200, {"Sec-WebSocket-Protocol": [FOXGLOVE[0]]}, "token"),
        ("/?token=t&token=t", {"Sec-WebSocket-Protocol": [FOXGLOVE[0]]}, "token"),
        ("/?token=t", {"Host": ["evil.com"]}, "host"),
        ("/?token=t", {"Host": ["localhost", "localhost"]}, "headers"),
        ("/?token=t", {"Origin": ["https://evil.com"]}, "origin"),
        ("/?token=t", {"Origin": ["http://localhost", "http://localhost"]}, "headers"),
    ],
)
def test_a_verdict(path: str, headers: dict[str, list[str]], reason: str | None) -> None:
    """One word and a sentence for the first thing that is wrong; None where nothing is."""
    strangers = Admission("127.0.0.1", (), "t", FOXGLOVE)
    refusal = strangers.check(path, lambda name: headers.get(name, []))
    assert (refusal.reason if refusal else None) == reason
    assert refusal is None or refusal.text


def test_without_a_protocol_none_has_to_be_offered() -> None:
    """What a client offers anyway is its own affair."""
    strangers = Admission("127.0.0.1")
    assert strangers.check("/", lambda name: []) is None
    offered = {"Sec-WebSocket-Protocol": ["chat"]}
    assert strangers.check("/", lambda name: offered.get(name, [])) is None
