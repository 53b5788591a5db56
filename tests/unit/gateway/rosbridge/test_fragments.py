"""Messages in fragments: cut and put together, within bounds."""

from __future__ import annotations

import json
from typing import Any

import pytest

from rosproto.gateway.rosbridge.fragments import (
    INCOMPLETE,
    MAX_RECEIVED,
    MAX_SENT,
    SECONDS,
    FragmentError,
    Reassembly,
    split,
)


def part(num: int, total: int, data: str = "x", id: Any = "f") -> dict[str, Any]:
    return {"op": "fragment", "id": id, "num": num, "total": total, "data": data}


@pytest.mark.parametrize("size", [1, 2, 3, 7, 18, 19])
def test_what_is_cut_is_put_together(size: int) -> None:
    """Every piece has at most `size` characters, and the other end gets the text again."""
    text = json.dumps({"data": "Wüste"})
    sent = [json.loads(payload) for payload in split(text, size, "f")]
    assert all(len(piece["data"]) <= size for piece in sent)
    pending = Reassembly(10_000)
    results = [pending.add(piece, 0.0) for piece in sent]
    assert results == [None] * (len(sent) - 1) + [text]
    assert len(pending) == 0
    assert pending.held == 0


@pytest.mark.promise("A message is sent in at most 4096 fragments")
def test_small_fragments_of_a_large_text_are_made_larger() -> None:
    """A tiny fragment size does not cause a million fragments."""
    sent = split("x" * 1_000_000, 1, "f")
    assert len(sent) <= MAX_SENT
    assert "".join(json.loads(payload)["data"] for payload in sent) == "x" * 1_000_000


@pytest.mark.parametrize(
    "wrong",
    [
        {"id": None}, {"id": 1.5}, {"id": True}, {"id": []}, {"data": 5}, {"data": None}, {"num": -1}, {"num": 3},
        {"num": "0"}, {"num": True}, {"num": 1.0}, {"total": 0}, {"total": MAX_RECEIVED + 1}, {"total": "3"},
        {"total": None}, {"num": None}, {"total": 10**400}, {"num": 10**400},
    ],
)  # fmt: skip
def test_wrong_fields(wrong: dict[str, Any]) -> None:
    """A sentence, and nothing is held."""
    pending = Reassembly(10_000)
    with pytest.raises(FragmentError, match="of a fragment"):
        pending.add({**part(0, 3), **wrong}, 0.0)
    assert pending.held == 0


def test_a_fragment_that_contradicts() -> None:
    """Twice the same, or another total: the whole message is given up."""
    for second, why in ((part(0, 3), "fragment 0 was received twice"), (part(1, 4), "has total 4")):
        pending = Reassembly(10_000)
        pending.add(part(0, 3), 0.0)
        with pytest.raises(FragmentError, match=why):
            pending.add(second, 0.0)
        assert len(pending) == 0
        assert pending.held == 0


@pytest.mark.promise("16 may be incomplete, together as large as one message, for ten minutes")
def test_what_is_incomplete_is_bounded() -> None:
    """In number, in bytes and in time."""
    pending = Reassembly(100_000)
    for number in range(INCOMPLETE):
        pending.add(part(0, 2, id=number), float(number))
    with pytest.raises(FragmentError, match="16 messages are incomplete already"):
        pending.add(part(0, 2, id="more"), 0.0)
    assert len(pending) == INCOMPLETE
    assert pending.add(part(0, 2, id="more"), SECONDS + 0.5) is None  # the oldest was forgotten
    assert len(pending) == INCOMPLETE

    pending = Reassembly(10_000)
    with pytest.raises(FragmentError, match="more than the limit of 10000 bytes"):
        pending.add(part(0, 2, "x" * 10_000), 0.0)
    assert pending.held == 0
    for number in range(9):
        pending.add(part(number, 1000, "x" * 900, id=number), 0.0)
    with pytest.raises(FragmentError, match="more than the limit of 10000 bytes"):
        pending.add(part(10, 1000, "x" * 900, id=8), 0.0)
    assert len(pending) == 8
    for number in range(8):
        with pytest.raises(FragmentError):
            pending.add(part(number, 1000, id=number), 0.0)
    assert pending.held == 0


def test_messages_side_by_side() -> None:
    """Ids tell them apart; a text and a number are not the same id."""
    pending = Reassembly(10_000)
    assert pending.add(part(0, 2, "a", id="1"), 0.0) is None
    assert pending.add(part(0, 2, "b", id=1), 0.0) is None
    assert pending.add(part(1, 2, "c", id=1), 0.0) == "bc"
    assert pending.add(part(1, 2, "d", id="1"), 0.0) == "ad"
