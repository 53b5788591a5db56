"""A stop is not overtaken: what was asked for before it, and has not begun by then, does not begin.

STOP_TRIALS=50 in the environment repeats the trials of chance so often.
"""

from __future__ import annotations

import os
import random
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from tests.support.doors import held, in_thread
from tests.support.waiting import until

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

from tests.support.web import PageClient, Served, Velocities, serving
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.web.goals import GoalManager
from woosh_pure.web.live.manual_drive import ManualDrive

TRIALS = int(os.environ.get("STOP_TRIALS", "2"))
WATCH = 1.0
"""Seconds for which nothing may move after a stop."""


@pytest.fixture
def web(chassis: Chassis, real_time: Callable[[], None]) -> Iterator[Served]:
    """A server that allows driving, and a robot in real time."""
    with serving(chassis, allow_driving=True) as served:
        yield served


@pytest.fixture
def page(web: Served) -> Iterator[PageClient]:
    """A page that may drive."""
    with PageClient(web.port) as connected:
        connected.ready()
        yield connected


@pytest.fixture
def witness(sim: SimulatedChassis) -> Iterator[Velocities]:
    """Hears what is sent to the robot."""
    with Velocities(sim.master_uri) as heard:
        yield heard


def moved(witness: Velocities, since: float, seconds: float = WATCH) -> list[tuple[float, float]]:
    """Velocities other than zero that came within that time."""
    time.sleep(max(0.0, since + seconds - time.monotonic()))
    return [(round(at - since, 3), vx) for at, vx, _ in list(witness.heard) if at > since and vx]


@pytest.mark.promise("STOP in the page")
def test_a_press_that_waits_for_a_thread_is_ended_by_somebody_elses_stop(
    web: Served, page: PageClient, witness: Velocities, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The press has arrived, the drive is not being opened yet; the stop is answered before it is."""
    with held(monkeypatch, ManualDrive, "open") as (came, go_on):
        page.hold()
        assert came.wait(10.0)
        assert web.post("stop").json["stands_still"] is True
        assert page.of("drive", state="ended")["reason"] == "stopped"
        go_on.set()
        assert not moved(witness, time.monotonic())
    page.let_go()
    assert page.drive()["state"] == "driving"  # a new press drives


@pytest.mark.promise("STOP in the page")
def test_a_goal_whose_request_waits_for_a_thread_does_not_begin_after_a_stop(
    web: Served, sim: SimulatedChassis, monkeypatch: pytest.MonkeyPatch
) -> None:
    answers: list[Any] = []
    with held(monkeypatch, GoalManager, "begin") as (came, go_on):
        body = {"kind": "move", "distance": 1.0}
        thread, _ = in_thread(lambda: answers.append(web.post("goals", body)))
        assert came.wait(10.0)
        assert web.post("stop").json["stands_still"] is True
        go_on.set()
        thread.join(10.0)
    assert answers[0].status == 409, answers
    assert "stop" in answers[0].problem
    assert sim.world.motion is None
    assert web.post("goals", body).status == 201  # a new request begins


@pytest.mark.slow
@pytest.mark.promise("STOP in the page")
@pytest.mark.parametrize("again", [False, True], ids=["first press", "again right after letting go"])
def test_a_stop_within_milliseconds_of_a_press_is_not_passed_over(
    web: Served, page: PageClient, witness: Velocities, again: bool
) -> None:
    """What moves when the stop has been answered had begun before it and is over, or never begins."""
    chance, passed_over = random.Random(7), []
    for trial in range(TRIALS):
        if again:
            page.drive()
            page.let_go()
        delay = chance.uniform(0.003, 0.090)
        answers: list[Any] = []

        def stop(after: float = delay, answers: list[Any] = answers) -> None:
            time.sleep(after)
            web.post("stop")
            answers.append(time.monotonic())

        stopping = threading.Thread(target=stop)
        page.forget()
        page.hold()
        stopping.start()
        stopping.join(30)
        if after := moved(witness, answers[0] + 0.05):
            passed_over.append((trial, round(delay, 3), after[:2]))
        page.let_go()
        until(lambda: web.app.state.context.robot(None).manual_drive.driver is None)  # type: ignore[attr-defined]
    print(f"passed over: {len(passed_over)} of {TRIALS}: {passed_over[:5]}")
    assert not passed_over
