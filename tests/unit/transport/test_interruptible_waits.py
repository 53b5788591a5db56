"""Waits in slices, as on Windows, where Ctrl-C would not end them otherwise; whole waits elsewhere."""

from __future__ import annotations

import sys
import threading

import pytest

from rosproto.transport import deadline
from rosproto.transport.deadline import wait_event, wait_for


class Told(threading.Event):
    """Notes the waits; is set after so many."""

    def __init__(self, after: int) -> None:
        super().__init__()
        self.waits: list[float | None] = []
        self._after = after

    def wait(self, timeout: float | None = None) -> bool:
        self.waits.append(timeout)
        if len(self.waits) > self._after:
            self.set()
        return self.is_set()


@pytest.fixture
def sliced(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(deadline, "SLICE", 0.01)


@pytest.mark.usefixtures("sliced")
def test_a_wait_without_an_end_goes_on_slice_by_slice() -> None:
    event = Told(after=5)
    assert wait_event(event, None)
    assert event.waits == [0.01] * 6


@pytest.mark.usefixtures("sliced")
def test_a_wait_ends_with_its_timeout_and_not_before() -> None:
    event = threading.Event()
    assert not wait_event(event, 0.025)
    assert not wait_event(event, 0.0)
    told = Told(after=10_000)
    assert not wait_event(told, -1.0)
    assert told.waits == [0.0]


@pytest.mark.usefixtures("sliced")
def test_what_comes_true_between_slices_ends_the_wait() -> None:
    condition, said = threading.Condition(), []

    def say() -> None:
        with condition:
            said.append("it")
            condition.notify_all()

    timer = threading.Timer(0.05, say)
    timer.start()
    with condition:
        assert wait_for(condition, lambda: said, 10.0)
        assert wait_for(condition, lambda: said, None)
        assert not wait_for(condition, lambda: not said, 0.02)
    timer.join()


@pytest.mark.skipif(sys.platform == "win32", reason="sliced there")
def test_elsewhere_a_wait_is_one_wait() -> None:
    event = Told(after=0)
    assert wait_event(event, None)
    assert event.waits == [None]
