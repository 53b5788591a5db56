"""The first round of a stop: it makes nothing, opens nothing, waits for nobody, and is repeated until the end is seen."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator

import pytest

from woosh_pure.stopping.immediate_stop import ImmediateStop, Stoppable, StopRequest
from woosh_pure.stopping.stop_executor import Flag

MADE = ("open", "import", "socket", "subprocess", "_thread.start_new_thread", "os.fork", "logging")


class Thing:
    """Something under way."""

    def __init__(self) -> None:
        self.asked: list[str] = []
        self.again = 0
        self.twice = Flag()
        self.end_due = False

    def end_now(self, why: str) -> None:
        self.asked.append(why)
        self.end_due = True

    def end_again(self) -> None:
        self.again += 1
        if self.again == 2:
            self.twice.set()


class Broken(Thing):
    """One that cannot be written."""

    def end_now(self, why: str) -> None:
        raise ConnectionError("no connection")

    def __str__(self) -> str:
        return "the broken one"


class World:
    """A line, and what is under way."""

    def __init__(self) -> None:
        self.things: list[Thing] = []
        self.chores = 0
        self.line = ImmediateStop(self._under_way, self._do)

    def _under_way(self, goals: bool) -> list[Stoppable]:
        return list(self.things) if goals else []

    def _do(self) -> bool:
        self.chores += 1
        return False


@pytest.fixture
def world() -> Iterator[World]:
    made = World()
    made.line.start()
    yield made
    made.line.end()


def test_everything_is_asked_to_end_and_one_that_cannot_be_holds_up_no_other(world: World) -> None:
    world.things = [Thing(), Broken(), Thing()]
    ending = world.line.ask(StopRequest("stop() was called"))
    assert ending.written.wait(5.0)
    assert [thing.asked for thing in world.things] == [["stop() was called"], [], ["stop() was called"]]
    assert ending.problems == ["ending the broken one at once (no connection)"]


def test_goals_are_left_where_only_drives_end(world: World) -> None:
    world.things = [Thing()]
    assert world.line.ask(StopRequest("closed", goals=False)).written.wait(5.0)
    assert world.things[0].asked == []


def test_it_is_asked_again_until_the_end_is_seen(world: World) -> None:
    thing = Thing()
    world.things = [thing]
    world.line.ask(StopRequest("stop() was called"))
    assert thing.twice.wait(5.0)
    thing.end_due = False
    seen = thing.again
    assert not Flag().wait(0.3)
    assert thing.again <= seen + 1


def test_what_asks_for_its_own_end_is_asked_again_too(world: World) -> None:
    thing = Thing()
    world.things = [thing]
    world.line.start()  # as with each motion
    thing.end_due = True  # its time is up, say
    assert thing.twice.wait(5.0)


def test_what_else_is_due_is_done_while_something_is_under_way(world: World) -> None:
    """A drive that is over, and still in its block, is under way; its last zero may be due all the same."""
    thing = Thing()
    world.things = [thing]
    world.line.ask(StopRequest("stop() was called"))
    assert thing.twice.wait(5.0)
    assert world.chores >= 2


def test_the_first_round_makes_nothing(world: World) -> None:
    """Seen by the interpreter's own audit: no file, module, socket or thread is made by anybody meanwhile."""
    world.things = [Thing(), Thing()]
    world.line.ask(StopRequest("once before")).written.wait(5.0)
    seen: list[str] = []
    looking = [True]

    def audit(event: str, arguments: object) -> None:
        if (
            looking[0]
            and threading.current_thread().name == "woosh:immediate-stop"
            and event.startswith(MADE)
        ):
            seen.append(event)

    sys.addaudithook(audit)
    assert world.line.ask(StopRequest("now")).written.wait(5.0)
    looking[0] = False
    assert seen == []


def test_in_a_fork_it_touches_nothing(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    world.things = [Thing()]
    monkeypatch.setattr("woosh_pure.stopping.immediate_stop.os.getpid", lambda: -1)
    assert world.line.ask(StopRequest("the program ended")).written.is_set
    assert world.things[0].asked == []
