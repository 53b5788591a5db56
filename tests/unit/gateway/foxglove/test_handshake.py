"""The opening handshake: who may connect, and what is passed on to the SDK's server."""

from __future__ import annotations

import pytest

from rosproto.gateway.foxglove.handshake import (
    MAX_HEAD_BYTES,
    BadRequest,
    check_request,
    client_response,
    error_response,
    parse_request,
    upstream_request,
)

KEY = "dGhlIHNhbXBsZSBub25jZQ=="


def request(*more: str, target: str = "/", host: str = "localhost:8765", method: str = "GET") -> bytes:
    lines = [
        f"{method} {target} HTTP/1.1", f"Host: {host}", "Upgrade: WebSocket", "Connection: Upgrade",
        f"Sec-WebSocket-Key: {KEY}", "Sec-WebSocket-Version: 13", *more, "", "",
    ]  # fmt: skip
    return "\r\n".join(lines).encode("latin-1")


SDK = "Sec-WebSocket-Protocol: foxglove.sdk.v1"


def check(
    head: bytes, *, bound: str = "127.0.0.1", origins: tuple[str, ...] = (), token: str | None = None
) -> str:
    return check_request(parse_request(head), bound=bound, origins=origins, token=token)


def refusal(head: bytes, **how: object) -> BadRequest:
    with pytest.raises(BadRequest) as caught:
        check(head, **how)  # type: ignore[arg-type]
    return caught.value


@pytest.mark.parametrize(
    ("offered", "name"),
    [
        ("foxglove.sdk.v1", "foxglove.sdk.v1"),
        ("foxglove.websocket.v1", "foxglove.websocket.v1"),
        ("foxglove.websocket.v1, foxglove.sdk.v1", "foxglove.sdk.v1"),
        ("soap,foxglove.websocket.v1", "foxglove.websocket.v1"),
    ],
)
def test_both_names_of_the_protocol(offered: str, name: str) -> None:
    """Viewers of before the SDK are let in under the name they know."""
    assert check(request(f"Sec-WebSocket-Protocol: {offered}")) == name


def test_a_client_of_another_protocol_is_told_so() -> None:
    """Such as a page for rosbridge."""
    assert refusal(request()).status == 400
    assert "foxglove.sdk.v1" in refusal(request("Sec-WebSocket-Protocol: soap")).text


@pytest.mark.promise("unless its origin is open")
@pytest.mark.parametrize(
    ("origin", "comes_in"),
    [
        (None, True),
        ("http://localhost:8080", True),
        ("http://127.0.0.1:3000", True),
        ("https://app.foxglove.dev", True),
        ("https://evil.example", False),
        ("null", False),
        ("https://app.foxglove.dev.evil.example", False),
        ("http://localhost.evil.example", False),
    ],
)
def test_pages_from_elsewhere(origin: str | None, comes_in: bool) -> None:
    """A page comes in from this computer, or from where it was said."""
    head = request(SDK, *([] if origin is None else [f"Origin: {origin}"]))
    if comes_in:
        assert check(head, origins=("https://app.foxglove.dev",))
    else:
        assert refusal(head, origins=("https://app.foxglove.dev",)).status == 403


@pytest.mark.promise("unless its origin is open")
def test_another_name_for_this_computer_is_no_way_in() -> None:
    """A page whose own name leads to 127.0.0.1 is of that name, and not ours."""
    assert refusal(request(SDK, host="evil.example:8765")).status == 403
    assert check(request(SDK, host="robot.local:8765"), bound="10.0.0.7", token=None)


@pytest.mark.promise("on an address that others reach only with a token")
def test_the_token() -> None:
    """In the address or in a header; wrong and missing are the same."""
    for head in (
        request(SDK, target="/?token=se%20cret"),
        request(SDK, "Authorization: Bearer se cret"),
    ):
        assert check(head, token="se cret") == "foxglove.sdk.v1"
    for head in (
        request(SDK),
        request(SDK, target="/?token="),
        request(SDK, target="/?token=other"),
        request(SDK, "Authorization: Basic se cret"),
        request(SDK, "Authorization: Bearer"),
    ):
        problem = refusal(head, token="se cret")
        assert problem.status == 401
        assert b"WWW-Authenticate: Bearer" in error_response(problem)
        assert "se cret" not in problem.text


def test_what_is_passed_on_has_no_token_and_no_extension() -> None:
    """The SDK is asked for what it has, by fields we made."""
    head = request(
        SDK,
        "Authorization: Bearer secret",
        "Sec-WebSocket-Extensions: permessage-deflate",
        target="/?token=secret",
    )
    text = upstream_request(parse_request(head), 4711).decode()
    assert text.startswith("GET / HTTP/1.1\r\nHost: 127.0.0.1:4711\r\n")
    assert "secret" not in text
    assert "Extensions" not in text
    assert f"Sec-WebSocket-Key: {KEY}\r\n" in text
    assert text.endswith("\r\n\r\n")


def test_the_answer_says_the_name_that_was_offered() -> None:
    """A browser hangs up when it is told another one."""
    head = b"HTTP/1.1 101 Switching Protocols\r\nsec-websocket-protocol: foxglove.sdk.v1\r\nUpgrade: websocket\r\n\r\n"
    text = client_response(head, "foxglove.websocket.v1").decode()
    assert text.lower().count("sec-websocket-protocol") == 1
    assert "Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n" in text
    with pytest.raises(BadRequest):
        client_response(b"HTTP/1.1 400 Bad Request\r\n\r\n", "foxglove.sdk.v1")


@pytest.mark.parametrize(
    ("head", "status"),
    [
        (b"\r\n\r\n", 400),
        (b"GET /\r\n\r\n", 400),
        (b"GET / HTTP/2\r\n\r\n", 400),
        (b"GET / HTTP/1.1\r\nno colon\r\n\r\n", 400),
        (b"GET / HTTP/1.1\r\n: value\r\n\r\n", 400),
        (b"GET / HTTP/1.1\r\nHost : a\r\n\r\n", 400),
        (b"GET / HTTP/1.1\r\nA: b\nC: d\r\n\r\n", 400),
        (request(SDK, method="POST"), 405),
        (request(SDK).replace(b"Upgrade: WebSocket\r\n", b""), 426),
        (request(SDK).replace(b"Sec-WebSocket-Key", b"Other"), 426),
        (b"GET / HTTP/1.1\r\n" + b"A: " + b"b" * MAX_HEAD_BYTES + b"\r\n\r\n", 431),
        (bytes(range(256)) + b"\r\n\r\n", 400),
    ],
)
def test_everything_else_is_answered(head: bytes, status: int) -> None:
    """With the status, and a sentence of plain text."""
    problem = refusal(head)
    assert problem.status == status
    assert error_response(problem).startswith(f"HTTP/1.1 {status} ".encode())
    assert problem.text.encode() in error_response(problem)
