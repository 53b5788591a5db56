"""Programs that drive by velocity, when a stop is to end them; the graph is a script of what is seen of it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from types import SimpleNamespace

import pytest

from rosproto.errors import RosTimeout
from rosproto.transport import Deadline
from woosh_pure.connection.other_drivers import OtherDriver
from woosh_pure.stopping import other_clients
from woosh_pure.stopping.other_clients import OtherPrograms
from woosh_pure.stopping.report import StopReport


class Graph:
    """Tells, look by look, who can send velocities; notes who is asked to end."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.asked: list[str] = []
        self.looks: Callable[[int], list[str]] = lambda look: []
        self._look = 0
        self._lock = threading.Lock()
        monkeypatch.setattr(other_clients, "other_drivers", self._drivers)
        monkeypatch.setattr(
            OtherPrograms, "_ask_to_end", lambda programs, driver: self.asked.append(driver.node)
        )

    def _drivers(self, node: object) -> tuple[OtherDriver, ...]:
        with self._lock:
            self._look += 1
            return tuple(
                OtherDriver(name, ("/cmd_vel",), f"http://{address or '10.0.0.1'}:1")
                for name, _, address in (each.partition(" ") for each in self.looks(self._look))
            )

    def end_them(self, seconds: float = 20.0) -> StopReport:
        report = StopReport()
        connection = SimpleNamespace(open_node=lambda: None)
        OtherPrograms(connection, Deadline(seconds), end=True).wait(report)  # type: ignore[arg-type]
        return report


@pytest.fixture
def graph(monkeypatch: pytest.MonkeyPatch) -> Graph:
    return Graph(monkeypatch)


def test_who_comes_for_a_moment_to_send_zeros_is_neither_asked_nor_blamed(graph: Graph) -> None:
    """As a velocity block of ours does whose node was shut down."""
    graph.looks = lambda look: [["/driver"], ["/driver"], ["/driver_zero"], []][min(look, 4) - 1]
    report = graph.end_them()
    assert (report.problems, report.cancelled) == ([], ["the program /driver"])
    assert graph.asked == ["/driver"]


@pytest.mark.parametrize("again", ["/again", "/driver 10.0.0.2"], ids=["another name", "the same name"])
def test_a_program_that_something_starts_at_once_again_is_asked_again(
    graph: Graph, monkeypatch: pytest.MonkeyPatch, again: str
) -> None:
    monkeypatch.setattr(other_clients, "_LOOK_AGAIN", 0.1)
    graph.looks = lambda look: ["/driver"] if look < 3 else [] if len(graph.asked) > 1 else [again]
    report = graph.end_them()
    name = again.partition(" ")[0]
    assert graph.asked == ["/driver", name]
    assert (report.problems, report.cancelled) == (
        [],
        [f"the program {n}" for n in dict.fromkeys(graph.asked)],
    )


def test_who_came_too_late_to_be_asked_is_not_said_to_have_been(
    graph: Graph, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(other_clients, "_MIN_STEP_SECONDS", 0.2)
    monkeypatch.setattr(other_clients, "_LOOK_AGAIN", 60.0)
    graph.looks = lambda look: ["/driver"] if look < 2 else ["/driver", "/late"]
    report = graph.end_them(0.0)
    assert report.cancelled == []
    driver, late = report.problems
    assert driver.endswith("on /cmd_vel, it was asked to end and has not")
    assert late.startswith("/late ")
    assert "which stops only when that program ends" in late


def test_a_master_that_is_slow_once_is_asked_again(graph: Graph) -> None:
    def looks(look: int) -> list[str]:
        if look == 2:
            raise RosTimeout("the master is busy", what="the master", seconds=2.0)
        return ["/driver"] if look < 4 else []

    graph.looks = looks
    report = graph.end_them()
    assert (report.problems, report.cancelled) == ([], ["the program /driver"])


def test_only_goals_that_were_there_are_cancelled_again() -> None:
    """A goal that somebody sends after the stop goes on."""
    told = iter([{"old": 1}, {"old": 1, "new": 0}, {"old": 1, "new": 1}, {"old": 6, "new": 1}])
    sent: list[str] = []

    class Statuses:
        def next(self, timeout: float) -> object:
            time.sleep(0.3)
            goals = next(told).items()
            return SimpleNamespace(
                status_list=[SimpleNamespace(goal_id=SimpleNamespace(id=id), status=s) for id, s in goals]
            )

    publisher = SimpleNamespace(publish=lambda id: sent.append(id))
    first = other_clients.goals_of(Statuses(), 1.0)  # type: ignore[arg-type]
    assert other_clients.cancel_by_id(publisher, Statuses(), first, Deadline(20.0))  # type: ignore[arg-type]
    assert set(sent) == {"old"}
    assert next(told, None) is None
