"""The table of what the master knows about a node."""

from __future__ import annotations

import threading
from typing import Any

import pytest

from rosproto.errors import ConnectionLost, LocalProtocolError, MasterError, RosTimeout
from rosproto.node.graph.registrations import RegistrationCall, Registrations
from rosproto.transport.deadline import Deadline


class Thing:
    """A registration that notes what is done with it, and raises what it is told."""

    def __init__(self, kind: str, name: str, log: list[str]) -> None:
        self.kind, self.name, self.log = kind, name, log
        self.error: Exception | None = None
        self.during: Any = None
        self.after: Any = None
        self.known: list[int] = []

    def registration_call(self) -> RegistrationCall:
        return RegistrationCall("register", (self,), lambda answer: None)

    def arrive(self) -> None:
        if self.error is not None:
            raise self.error
        self.log.append(f"+{self.name}")
        if self.during is not None:
            self.during()

    def unregister(self, master: Any) -> int:
        if self.error is not None:
            raise self.error
        self.log.append(f"-{self.name}")
        if self.after is not None:
            after, self.after = self.after, None
            after()
        return self.known.pop(0) if self.known else 1


class Master:
    """Has the things above done what they note."""

    uri = "http://master:1/"

    def call(self, method: str, thing: Thing) -> object:
        thing.arrive()
        return 1

    def batch(self, calls: Any, *, timeout: float | None = None) -> list[object]:
        ((method, (thing,)),) = calls
        try:
            return [self.call(method, thing)]
        except MasterError as error:
            return [error]


MASTER: Any = Master()


@pytest.fixture
def table() -> Registrations:
    return Registrations(MASTER)


def test_adding_registers_and_removing_takes_back(table: Registrations) -> None:
    """Once each; removing twice, or something never added, does nothing."""
    log: list[str] = []
    thing = Thing("publisher", "/a", log)
    table.add(thing)
    table.remove(thing)
    table.remove(thing)
    table.remove(Thing("publisher", "/b", log))
    assert log == ["+/a", "-/a"]
    assert len(table) == 0


def test_what_is_on_its_way_to_the_master_is_not_confirmed(table: Registrations) -> None:
    """Only what the master has answered to, and until it is taken back."""
    thing, seen = Thing("publisher", "/a", []), []
    thing.during = lambda: seen.append(table.confirmed())
    table.add(thing)
    assert seen == [[]]
    assert table.confirmed() == [thing]
    thing.after = lambda: seen.append(table.confirmed())
    table.remove(thing)
    assert seen == [[], []]


def test_what_is_removed_while_it_is_being_added_is_taken_back(table: Registrations) -> None:
    """By the end of a node, say: else it would stay in the graph."""
    log: list[str] = []
    thing = Thing("publisher", "/a", log)
    thing.during = lambda: table.remove(thing)
    table.add(thing)
    assert log[-1] == "-/a"
    assert (len(table), table.confirmed()) == (0, [])


def test_what_the_master_refuses_is_not_remembered(table: Registrations) -> None:
    """The error reaches the caller."""
    thing = Thing("publisher", "/a", [])
    thing.error = MasterError("registerPublisher", 0, "no")
    with pytest.raises(MasterError):
        table.add(thing)
    assert len(table) == 0


def test_after_a_restart_all_are_registered_and_one_refusal_stops_nothing(table: Registrations) -> None:
    """The others stand; the refused one is not tried for ever."""
    log: list[str] = []
    things = [Thing("subscriber", f"/{name}", log) for name in "abc"]
    for thing in things:
        table.add(thing)
    things[1].error = MasterError("registerSubscriber", -1, "no")
    log.clear()
    table.register_all()
    assert log == ["+/a", "+/c"]


def test_a_master_that_goes_away_in_the_middle_leaves_the_rest_pending(table: Registrations) -> None:
    """They are registered when it is back, and only they."""
    log: list[str] = []
    things = [Thing("subscriber", f"/{name}", log) for name in "abc"]
    for thing in things:
        table.add(thing)
    things[1].error = ConnectionLost("gone")
    log.clear()
    assert not table.register_all()
    assert log == ["+/a"]
    assert table.pending == {("subscriber", "/b"), ("subscriber", "/c")}
    things[1].error = None
    assert table.register_pending()
    assert log == ["+/a", "+/b", "+/c"]


def test_what_is_removed_while_it_is_registered_again_is_taken_back(table: Registrations) -> None:
    """No ghost stays at the master."""
    log: list[str] = []
    thing = Thing("service", "/s", log)
    table.add(thing)
    thing.during = lambda: table.remove(thing)
    table.register_all()
    assert log[-1] == "-/s"
    assert len(table) == 0


def test_what_stands_is_said_again_and_nothing_else(table: Registrations) -> None:
    """Not what was never added; and what is removed meanwhile is taken back."""
    log: list[str] = []
    thing, other = Thing("publisher", "/a", log), Thing("publisher", "/b", log)
    table.add(thing)
    table.register_again(thing)
    table.register_again(other)
    assert log == ["+/a", "+/a"]
    thing.during = lambda: table.remove(thing)
    table.register_again(thing)
    assert log[-1] == "-/a"
    assert len(table) == 0


def test_unregistering_all_goes_backwards_and_stops_when_the_master_is_gone(table: Registrations) -> None:
    """The newest first; a dead master is not asked again for each."""
    log: list[str] = []
    things = [Thing("publisher", f"/{name}", log) for name in "abc"]
    for thing in things:
        table.add(thing)
    log.clear()
    things[1].error = ConnectionLost("gone")
    table.unregister_all(Deadline(5.0), None)  # type: ignore[arg-type]
    assert log == ["-/c"]
    assert len(table) == 0


def test_nothing_is_registered_for_a_node_that_has_left(table: Registrations) -> None:
    """Another thread subscribes while the node closes: nobody would take that back any more."""
    log: list[str] = []
    table.unregister_all(Deadline(5.0), None)  # type: ignore[arg-type]
    with pytest.raises(LocalProtocolError, match="closed in the meantime"):
        table.add(Thing("publisher", "/late", log))
    assert (log, len(table)) == ([], 0)


def test_the_farewell_waits_for_what_is_on_its_way_to_the_master(table: Registrations) -> None:
    """On another connection it could arrive after the farewell, and stay in the graph."""
    log: list[str] = []
    thing = Thing("publisher", "/a", log)
    sent, leaving = threading.Event(), threading.Event()

    def during() -> None:
        sent.set()
        leaving.wait(20)
        log.append("arrived")

    thing.during = during
    adding = threading.Thread(target=table.add, args=(thing,), daemon=True)
    adding.start()
    assert sent.wait(20)
    farewell = threading.Thread(target=table.unregister_all, args=(Deadline(20.0), None), daemon=True)
    farewell.start()
    while not table._closed:  # it has begun
        pass
    leaving.set()
    farewell.join(20)
    adding.join(20)
    assert log == ["+/a", "arrived", "-/a"]


def test_the_farewell_says_again_what_is_being_taken_back(table: Registrations) -> None:
    """By another thread, whose call ends with the connections of the node."""
    log: list[str] = []
    thing = Thing("publisher", "/a", log)
    table.add(thing)
    thing.after = lambda: table.unregister_all(Deadline(5.0), None)  # type: ignore[arg-type]
    table.remove(thing)
    assert log == ["+/a", "-/a", "-/a"]


def test_what_a_silent_master_was_not_told_is_taken_back_later(table: Registrations) -> None:
    """It may be the network that was away, and a publisher that is gone would stay in the graph."""
    log: list[str] = []
    gone, refused = Thing("publisher", "/gone", log), Thing("subscriber", "/unsure", log)
    table.add(gone)
    gone.error = refused.error = RosTimeout("no answer")
    table.remove(gone)
    with pytest.raises(RosTimeout):
        table.add(refused)  # the master may have heard it all the same
    assert not table.register_pending()
    gone.error = refused.error = None
    assert table.register_pending()
    assert log == ["+/gone", "-/gone", "-/unsure"]
    assert table.register_pending()
    assert len(log) == 3


def test_what_was_interrupted_is_unregistered_until_it_has_arrived(table: Registrations) -> None:
    """Its request may reach the master after the one of the farewell."""

    def interrupted() -> None:
        raise KeyboardInterrupt

    log: list[str] = []
    thing = Thing("publisher", "/a", log)
    thing.during, thing.known = interrupted, [0, 0, 1]
    with pytest.raises(KeyboardInterrupt):
        table.add(thing)
    table.unregister_all(Deadline(5.0), None)  # type: ignore[arg-type]
    assert (log, thing.known) == (["+/a", "-/a", "-/a", "-/a"], [])


def test_a_master_that_is_known_to_be_away_is_not_waited_for() -> None:
    """Closing takes no time then."""
    log: list[str] = []
    away: list[bool] = []
    table = Registrations(MASTER, None, lambda: bool(away))
    thing = Thing("publisher", "/a", log)
    table.add(thing)
    away.append(True)
    table.remove(thing)
    assert log == ["+/a"]
    table.unregister_all(Deadline(5.0), None)  # type: ignore[arg-type]
    assert log == ["+/a", "-/a"]


def test_what_is_wanted_again_is_not_taken_back(table: Registrations) -> None:
    """Added again before the master was back; or while it was being taken back: then it is registered again."""
    log: list[str] = []
    first, second = Thing("publisher", "/a", log), Thing("publisher", "/a", log)
    table.add(first)
    first.error = RosTimeout("no answer")
    table.remove(first)
    table.add(second)
    assert table.register_pending()
    assert log == ["+/a", "+/a"]
    first.error, second.error = None, RosTimeout("no answer")
    table.remove(second)
    second.error = None
    second.after = lambda: table.add(first)
    log.clear()
    assert not table.register_pending()
    assert table.register_pending()
    assert log == ["-/a", "+/a", "+/a"]
