"""What a publication does before its first message."""

from __future__ import annotations

import sys
from typing import Any

import pytest

from rosproto import Master, Node, define
from rosproto.codec.generated_source import Source
from rosproto.node.outgoing import subscriber_link
from rosproto.transport.unsent_bytes import UnsentBytes


def test_the_encoder_is_made_when_somebody_subscribes(monkeypatch: pytest.MonkeyPatch) -> None:
    """A constructor does not wait for it, and most publishers of a robot never send anything."""
    kind = define("start_msgs/Once", "int32 number\nstring text\n")
    made, compile_ = [], Source.compile

    def noted(source: Source, name: str, type_name: str) -> Any:
        made.append((name, type_name))
        return compile_(source, name, type_name)

    monkeypatch.setattr(Source, "compile", noted)
    with (
        Master(host="127.0.0.1", port=0) as master,
        Node("/n", master_uri=master.uri, host="127.0.0.1", rosout=False) as node,
        node.publisher("/t", kind) as publisher,
    ):
        publisher.publish(number=0, text="to nobody")
        assert ("encode", "start_msgs/Once") not in made
        with node.subscriber("/t", kind) as subscriber:
            publisher.wait_for_connection(20)
            publisher.publish(number=1, text="a")
            publisher.publish(number=2, text="b")
            assert made.count(("encode", "start_msgs/Once")) == 1
            assert [(m.number, m.text) for m in (subscriber.next(timeout=5), subscriber.next(timeout=5))] == [
                (1, "a"),
                (2, "b"),
            ]


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells")
@pytest.mark.parametrize("local", [True, False])
def test_what_was_published_is_waited_for(local: bool) -> None:
    """On the way to a program, and at once within this process; a closed publication keeps nobody waiting."""
    with (
        Master(host="127.0.0.1", port=0) as master,
        Node("/n", master_uri=master.uri, host="127.0.0.1", rosout=False, intraprocess=local) as node,
        node.subscriber("/t", "std_msgs/String") as subscriber,
        node.publisher("/t", "std_msgs/String") as publisher,
    ):
        publisher.wait_for_connection(20)
        publisher.publish(data="a")
        assert publisher.wait_arrived(20) is True
        assert subscriber.next(20).data == "a"


def test_who_has_not_read_is_waited_for_no_longer_than_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    """And where nobody tells, nobody is waited for."""
    monkeypatch.setattr(subscriber_link, "unsent_bytes", lambda sock: answer)
    with (
        Master(host="127.0.0.1", port=0) as master,
        Node("/n", master_uri=master.uri, host="127.0.0.1", rosout=False, intraprocess=False) as node,
        node.subscriber("/t", "std_msgs/String"),
        node.publisher("/t", "std_msgs/String") as publisher,
    ):
        publisher.wait_for_connection(20)
        answer: UnsentBytes | None = UnsentBytes(52, True)
        assert publisher.wait_arrived(0.05) is False
        answer = None
        assert publisher.wait_arrived(20) is None
