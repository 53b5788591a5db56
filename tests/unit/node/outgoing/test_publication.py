"""What a publication does before its first message."""

from __future__ import annotations

from rosproto import Master, Node, define


def test_the_encoder_is_made_with_the_first_message() -> None:
    """A constructor does not wait for it, and most publishers of a robot never send anything."""
    kind = define("start_msgs/Once", "int32 number\nstring text\n")
    with (
        Master(host="127.0.0.1", port=0) as master,
        Node("/n", master_uri=master.uri, host="127.0.0.1", rosout=False) as node,
        node.publisher("/t", kind) as publisher,
        node.subscriber("/t", kind) as subscriber,
    ):
        assert "encode" not in kind._binding._functions
        publisher.publish(number=1, text="a")
        publisher.publish(number=2, text="b")
        assert "encode" in kind._binding._functions
        assert [(m.number, m.text) for m in (subscriber.next(timeout=5), subscriber.next(timeout=5))] == [
            (1, "a"),
            (2, "b"),
        ]
