"""`Background`: one question at a time, only while somebody wants to know, and nobody waits for a slow one."""

from __future__ import annotations

import threading

from rosproto.errors import ConnectionLost
from tests.support.waiting import until
from woosh_pure.robot_api.background import Background


def test_the_first_one_waits_and_later_ones_do_not() -> None:
    answers = iter([1, 2])
    asked = Background(lambda: next(answers), 0.0)
    assert asked.want(10.0) == 1
    assert asked.want() in (1, 2)
    until(lambda: asked.answer == 2)
    assert asked.age < 60.0


def test_nobody_waits_longer_than_asked_and_only_one_question_is_under_way() -> None:
    began, go_on = [], threading.Event()

    def ask() -> int:
        began.append(1)
        go_on.wait(30.0)
        return 5

    asked = Background(ask, 0.0)
    assert [asked.want(0.01) for _ in range(5)] == [None] * 5
    assert len(began) == 1
    go_on.set()
    assert asked.want(10.0) == 5


def test_without_an_answer_the_last_one_stays_and_grows_old() -> None:
    def ask() -> int:
        raise ConnectionLost("no")

    asked = Background(ask, 0.0)
    assert asked.want(10.0) is None
    assert asked.age == float("inf")
    before = threading.active_count()
    assert asked.want() is None
    assert threading.active_count() <= before, "it is not asked again at once"
