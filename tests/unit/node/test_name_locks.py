"""One at a time for each name."""

from __future__ import annotations

import threading

import pytest

from rosproto.errors import RosTimeout
from rosproto.node.name_locks import Turns
from rosproto.transport.deadline import Deadline


def test_another_name_does_not_wait_and_the_same_one_does() -> None:
    turns = Turns()
    order: list[str] = []

    def later() -> None:
        with turns.take("/a"):
            order.append("second")

    with turns.take("/a"), turns.take("/b", Deadline(0)):
        thread = threading.Thread(target=later)
        thread.start()
        with (
            pytest.raises(
                RosTimeout, match=r"/a: another thread .* 0.01 s; does the master answer"
            ) as caught,
            turns.take("/a", Deadline(0.01)),
        ):
            pass
        assert (caught.value.what, caught.value.seconds) == ("/a", 0.01)
        order.append("first")
    thread.join(20)
    assert order == ["first", "second"]
    assert len(turns) == 0


def test_an_error_inside_gives_the_turn_back() -> None:
    turns = Turns()
    with pytest.raises(KeyError), turns.take("/a"):
        raise KeyError
    with turns.take("/a", Deadline(0)):
        pass
    assert len(turns) == 0
