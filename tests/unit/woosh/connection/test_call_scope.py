"""What a call has begun is ended without a handle, and what it only prepares does not begin."""

from __future__ import annotations

import threading

import pytest

from woosh_pure.connection.call_scope import CallScope, current
from woosh_pure.errors import MotionRefused
from woosh_pure.motion.action_goal import ActionMotion


def test_what_has_begun_is_ended_and_nothing_more_begins():
    scope, ended = CallScope(), []
    assert not scope
    scope.add("goal", "to A1", lambda: ended.append("A1"))
    assert scope
    scope.end()
    assert ended == ["A1"]
    with pytest.raises(MotionRefused, match="cancelled; nothing was sent"):
        scope.add("goal", "to A2", lambda: ended.append("A2"))
    with pytest.raises(MotionRefused):
        scope.require_wanted("/rgbled")
    assert scope.calling.cancelled


def test_one_that_cannot_be_ended_does_not_keep_the_others_going(caplog):
    scope, ended = CallScope(), []

    def fails() -> None:
        raise OSError("no answer")

    scope.add("one", "to A1", fails)
    scope.add("other", "velocity", lambda: ended.append("velocity"))
    scope.end()
    assert ended == ["velocity"]
    assert "to A1: its task was cancelled, and it may go on: no answer" in caplog.text


def test_a_thread_notes_what_it_begins_and_no_other_does():
    scope, seen = CallScope(), []
    with scope:
        assert current() is scope
        other = threading.Thread(target=lambda: seen.append(current()))
        other.start()
        other.join(20)
        with CallScope():
            assert current() is not scope
        assert current() is scope
    assert current() is None
    assert seen == [None]


def test_a_goal_is_cancelled_although_the_thread_that_sends_it_has_not_started(monkeypatch):
    """The thread is made, then started; a cancel of another thread came between, and raised RuntimeError."""
    motion, between = ActionMotion(None, "/a", "a goal"), []  # type: ignore[arg-type]
    start = threading.Thread.start

    def cancelled_first(thread):
        motion.await_sent(0.1)
        between.append(motion.being_sent)
        start(thread)

    monkeypatch.setattr(threading.Thread, "start", cancelled_first)
    assert motion.send(lambda: "sent") == "sent"
    assert between == [False]
