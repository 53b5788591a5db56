"""The queue to one client: bounded in every direction, oldest of a topic first to go, answers never."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosproto.gateway.client_limits import GatewayLimits
from rosproto.gateway.outbox import Outbox


def drained(box: Outbox[str]) -> list[str]:
    found = []
    while (item := box.take()) is not None:
        found.append(item)
    return found


def test_the_oldest_of_a_topic_makes_room() -> None:
    """`keep` of the same key; others keep their place."""
    box: Outbox[str] = Outbox(GatewayLimits())
    for i in range(5):
        box.put("/a", 10, f"a{i}", keep=2)
        box.put("/b", 10, f"b{i}", keep=1)
        box.put(None, 10, f"answer{i}")
    assert box.dropped == {"/a": 3, "/b": 4}
    assert (len(box), box.bytes, box.answer_bytes) == (8, 80, 50)
    assert drained(box) == ["answer0", "answer1", "answer2", "a3", "answer3", "a4", "b4", "answer4"]
    assert (len(box), box.bytes, box.answer_bytes) == (0, 0, 0)


def test_bytes_of_a_topic_and_of_all() -> None:
    """A large newest message stays whatever its size; then what takes most gives."""
    box: Outbox[str] = Outbox(GatewayLimits(topic_bytes=100, outbox_bytes=250))
    box.put("/small", 10, "small")
    for i in range(3):
        box.put("/cloud", 90, f"cloud{i}")
    assert box.dropped == {"/cloud": 2}
    box.put("/map", 1000, "map")
    assert box.dropped["/cloud"] == 3
    assert drained(box) == ["map"]
    box.put("/map", 1000, "map")
    box.put("/small", 10, "small")
    assert drained(box) == ["small"]


def test_answers_are_not_dropped_but_end_the_connection() -> None:
    """A client that asks and does not read."""
    box: Outbox[str] = Outbox(GatewayLimits(answer_bytes=100))
    for i in range(10):
        box.put(None, 10, f"{i}")
    assert not box.overflow
    box.put(None, 1, "more")
    assert box.overflow
    assert len(drained(box)) == 11


def test_it_wakes_once_for_what_comes_together() -> None:
    """The loop is woken for the first of a batch."""
    woken = []
    box: Outbox[str] = Outbox(GatewayLimits(), lambda: woken.append(1))
    box.put("/a", 1, "x")
    box.put("/a", 1, "y")
    assert woken == [1]
    drained(box)
    box.put("/a", 1, "z")
    assert woken == [1, 1]


def test_forgetting_and_closing() -> None:
    """`forget` removes a topic's payloads; a closed outbox takes none."""
    box: Outbox[str] = Outbox(GatewayLimits())
    for i in range(300):
        box.put("/a", 1, "x", keep=2)
        box.put("/b", 1, f"{i}", keep=3)
    box.forget("/a")
    assert "/a" not in box.dropped
    assert drained(box) == ["297", "298", "299"]
    box.put("/a", 1, "x")
    box.close()
    box.put("/a", 1, "x")
    assert (box.take(), len(box), box.bytes) == (None, 0, 0)


@pytest.mark.promise("loses the oldest messages of its topics and costs bounded memory")
@given(
    st.lists(
        st.one_of(
            st.tuples(st.sampled_from([None, "a", "b", "c"]), st.integers(0, 50), st.integers(1, 4)),
            st.just("take"),
        ),
        max_size=200,
    )
)
def test_bounds_hold_whatever_comes(steps: list[object]) -> None:
    """Order within a key, bytes and counts agree with a plain list."""
    limits = GatewayLimits(topic_bytes=60, outbox_bytes=100, outbox_messages=3)
    box: Outbox[tuple[object, int, int]] = Outbox(limits)
    put: dict[object, int] = {}
    taken: dict[object, int] = {}
    number = 0
    for step in steps:
        if step == "take":
            item = box.take()
            if item is not None:
                assert item[1] > taken.get(item[0], 0)
                taken[item[0]] = item[1]
        else:
            key, size, keep = step  # type: ignore[misc]
            number += 1
            put[key] = put.get(key, 0) + 1
            box.put(key, size, (key, number, size), keep=keep)
            if key is not None:
                assert box.waits(key) <= keep
                assert box.bytes - box.answer_bytes <= max(limits.outbox_bytes, size)
    left: list[tuple[object, int, int]] = []
    while (item := box.take()) is not None:
        left.append(item)
    assert (box.bytes, box.answer_bytes, len(box)) == (0, 0, 0)
    assert [n for _, n, _ in left] == sorted(n for _, n, _ in left)
