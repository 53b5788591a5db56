"""Who may try to connect: one while nobody answers, a few together when somebody does."""

from __future__ import annotations

from itertools import pairwise

import pytest

from woosh_pure.fleet.mqtt.attempts import TOGETHER, ConnectionAttempts


def turns(lines: int) -> ConnectionAttempts[int]:
    found: ConnectionAttempts[int] = ConnectionAttempts(uniform=lambda low, high: 0.0)
    for line in range(lines):
        found.request(line)
    return found


def test_a_few_try_together_while_the_broker_answers() -> None:
    """And the next one when one of them is in."""
    many = turns(200)
    assert many.begin(0.0) == list(range(TOGETHER))
    assert many.begin(0.0) == []
    assert many.due() is None
    many.succeeded(3)
    assert many.begin(0.0) == [TOGETHER]


def test_one_knocks_while_nobody_answers() -> None:
    """Each in its turn, about once a second at most."""
    many = turns(200)
    now = 0.0
    for line in many.begin(now):
        many.failed(line, now, there=False)
        many.request(line)
    knocks = []
    for _ in range(20):
        due = many.due()
        assert due is not None
        now = due
        (line,) = many.begin(now)
        knocks.append((line, now))
        many.failed(line, now, there=False)
        many.request(line)
    assert [line for line, _ in knocks] == list(range(TOGETHER, TOGETHER + 20))
    gaps = [b - a for (_, a), (_, b) in pairwise(knocks)]
    assert gaps[3:] == pytest.approx([1.0] * len(gaps[3:]))
    assert max(gaps) == pytest.approx(1.0)


def test_all_follow_the_one_who_found_the_broker() -> None:
    """At once, and together."""
    many = turns(20)
    for line in many.begin(0.0):
        many.failed(line, 0.0, there=False)
        many.request(line)
    due = many.due()
    assert due is not None
    (scout,) = many.begin(due)
    assert many.begin(due + 5.0) == []
    many.succeeded(scout)
    assert len(many.begin(due)) == TOGETHER


def test_who_is_sent_away_waits_for_itself() -> None:
    """The others need not."""
    two = turns(1)
    assert two.begin(0.0) == [0]
    two.failed(0, 0.0, there=True)
    two.request(0, 30.0)
    two.request(1)
    assert two.begin(1.0) == [1]
    two.succeeded(1)
    assert two.due() == 30.0
    assert two.begin(29.0) == []
    assert two.begin(30.0) == [0]


def test_who_has_left_is_not_waited_for() -> None:
    """Neither one who waits, nor one who tries."""
    many = turns(TOGETHER + 2)
    many.begin(0.0)
    many.forget(0)
    many.forget(TOGETHER)
    assert many.begin(0.0) == [TOGETHER + 1]
    for line in range(TOGETHER + 2):
        many.forget(line)
    assert not many
    assert many.due() is None
