"""One at a time for each name."""

from __future__ import annotations

import threading

import pytest

from rosproto.errors import RosTimeout
from rosproto.node.topics import NameLocks
from rosproto.transport.deadline import Deadline


def test_another_name_does_not_wait_and_the_same_one_does() -> None:
    locks = NameLocks()
    order: list[str] = []

    def later() -> None:
        with locks.hold("/a"):
            order.append("second")

    with locks.hold("/a"), locks.hold("/b", Deadline(0)):
        thread = threading.Thread(target=later)
        thread.start()
        with (
            pytest.raises(
                RosTimeout, match=r"/a: another thread .* 0.01 s; does the master answer"
            ) as caught,
            locks.hold("/a", Deadline(0.01)),
        ):
            pass
        assert (caught.value.what, caught.value.seconds) == ("/a", 0.01)
        order.append("first")
    thread.join(20)
    assert order == ["first", "second"]
    assert len(locks) == 0


def test_an_error_inside_gives_the_turn_back() -> None:
    locks = NameLocks()
    with pytest.raises(KeyError), locks.hold("/a"):
        raise KeyError
    with locks.hold("/a", Deadline(0)):
        pass
    assert len(locks) == 0
