"""The threads that stop motions end with their Chassis, also those that a second caller starts, or a late one."""

from __future__ import annotations

import threading

import pytest

from woosh_pure.stopping.immediate_stop import ImmediateStop
from woosh_pure.stopping.stop_executor import StopExecutor


@pytest.fixture(params=["executor", "immediate stop"])
def owner(request: pytest.FixtureRequest) -> StopExecutor | ImmediateStop:
    return StopExecutor() if request.param == "executor" else ImmediateStop(lambda goals: (), lambda: False)


def test_two_motions_that_begin_at_the_same_time_leave_no_thread(
    owner: StopExecutor | ImmediateStop, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[threading.Thread] = []
    both, start = threading.Barrier(2), threading.Thread.start

    def start_together(thread: threading.Thread) -> None:
        if thread.name.startswith("woosh:"):
            both.wait(10.0)  # neither caller has seen the threads of the other
            made.append(thread)
        start(thread)

    monkeypatch.setattr(threading.Thread, "start", start_together)
    callers = [threading.Thread(target=owner.start) for _ in range(2)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join(10.0)
    assert made
    owner.end()
    for thread in made:
        thread.join(10.0)
    assert [thread for thread in made if thread.is_alive()] == []


def test_a_motion_that_begins_after_the_end_starts_none(
    owner: StopExecutor | ImmediateStop, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is refused later, when the end is noticed."""
    owner.end()
    monkeypatch.setattr(threading.Thread, "start", lambda thread: pytest.fail(f"started {thread}"))
    owner.start()
