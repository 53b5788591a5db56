"""What a gateway asks of a handshake beyond the rules of every server: the token in the address, the subprotocol."""

from __future__ import annotations

import pytest

from rosproto.gateway.handshake import HandshakeRules
from rosproto.protocol.http import Request

TOKEN, HOST = "kd83-hsa2", {"host": ["localhost:9090"]}
FOXGLOVE = ("foxglove.sdk.v1", "foxglove.websocket.v1")


@pytest.mark.promise("admit clients by the same rules")
@pytest.mark.parametrize(
    ("path", "headers", "reason"),
    [
        ("/?token=kd83-hsa3", {}, "wrong-token"),
        ("/", {}, "token"),
        ("/?token=kd83-hsa2", {}, "protocol"),
        ("/?token=kd83-hsa2", {"sec-websocket-protocol": ["chat"]}, "protocol"),
        ("/?token=kd83-hsa2", {"sec-websocket-protocol": ["chat, foxglove.websocket.v1"]}, None),
        ("/?token=kd83-hsa2", {"sec-websocket-protocol": ["chat", "foxglove.sdk.v1"]}, None),
        ("/", {"sec-websocket-protocol": [FOXGLOVE[0]], "authorization": ["bearer kd83-hsa2"]}, None),
        ("/", {"sec-websocket-protocol": [FOXGLOVE[0]], "authorization": ["Basic kd83-hsa2"]}, "token"),
        ("/?token=kd83-hsa2&" + "a=1&" * 200, {"sec-websocket-protocol": [FOXGLOVE[0]]}, "token"),
        ("/?token=kd83-hsa2&token=kd83-hsa2", {"sec-websocket-protocol": [FOXGLOVE[0]]}, "token"),
        ("/?token=kd83-hsa2", {"host": ["evil.com"]}, "host"),
        ("/?token=kd83-hsa2", {"host": ["localhost", "localhost"]}, "headers"),
        ("/?token=kd83-hsa2", {"origin": ["https://evil.com"]}, "origin"),
        ("/?token=kd83-hsa2", {"origin": ["http://localhost", "http://localhost"]}, "headers"),
    ],
)
def test_a_verdict(path: str, headers: dict[str, list[str]], reason: str | None) -> None:
    """One word and a sentence for the first thing that is wrong; None where nothing is."""
    strangers = HandshakeRules("127.0.0.1", (), TOKEN, FOXGLOVE)
    headers = {**HOST, **headers}
    refusal = strangers.check(path, lambda name: headers.get(name, []), "10.0.0.9", 0.0)
    assert (refusal.reason if refusal else None) == reason
    assert refusal is None or refusal.text


def test_without_a_protocol_none_has_to_be_offered() -> None:
    """What a client offers anyway is its own affair."""
    strangers = HandshakeRules("127.0.0.1")
    offered = {**HOST, "sec-websocket-protocol": ["chat"]}
    for headers in (HOST, offered):
        assert strangers.check("/", lambda name, of=headers: of.get(name, []), "10.0.0.9", 0.0) is None


def test_the_address_it_listens_on_is_a_name_of_it() -> None:
    bridge = HandshakeRules("robot.local", (), TOKEN)
    assert bridge.check_host("robot.local:9090") is None
    assert bridge.check_host("other.local:9090") is not None


@pytest.mark.promise("answers requests by POST, too, by the same rules")
@pytest.mark.parametrize(
    ("method", "headers", "reason"),
    [
        ("POST", {}, None),
        ("POST", {"content-type": "text/plain"}, None),
        ("POST", {"origin": "http://localhost:9090", "content-type": "application/json;charset=utf-8"}, None),
        ("POST", {"origin": "http://localhost:9090", "content-type": "text/plain"}, "content type"),
        ("POST", {"origin": "http://localhost:9090"}, "content type"),
        ("POST", {"origin": "https://evil.com", "content-type": "application/json"}, "origin"),
        ("POST", {"origin": "", "content-type": "application/json"}, "origin"),
        ("POST", {"host": "evil.com"}, "host"),
        ("POST", {"authorization": ""}, "token"),
        ("POST", {"authorization": "Basic cm9ib3Q6a2Q4My1oc2Ey"}, None),
        ("POST", {"authorization": "Basic a2Q4My1oc2EyOg=="}, "wrong-token"),
        ("PUT", {}, "method"),
        ("post", {}, "method"),
    ],
)
def test_a_verdict_on_a_post(method: str, headers: dict[str, str], reason: str | None) -> None:
    """A page's body must be JSON, which no page may send elsewhere unasked; the password of Basic is the token."""
    rules = HandshakeRules("127.0.0.1", (), TOKEN)
    given = {"host": "localhost:9090", "authorization": f"Bearer {TOKEN}", **headers}
    refusal = rules.check_post(Request(method, "/woosh/robot/Mode", given, b"{}"), "10.0.0.9", 0.0)
    assert (refusal.reason if refusal else None) == reason
    assert refusal is None or refusal.text
