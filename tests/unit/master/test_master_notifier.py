"""Notifications to nodes: order, replacement, and that no node waits for a silent one."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator

import pytest

from rosproto.master import notifier as notifier_module
from rosproto.master.notifications import Notification, ParamUpdate, PublisherUpdate
from rosproto.master.notifier import DeliveryOutcome, Notifier
from tests.support.victim import eventually

DEADLINE = 20.0


class Nodes:
    """Stands for all nodes of a graph: records calls, and does per URI what a test wants."""

    def __init__(self) -> None:
        self.calls: list[Notification] = []
        self.groups: list[str] = []  # of the threads that called: prompt or patient
        self.behave: dict[str, Callable[[Notification], DeliveryOutcome]] = {}
        self.opened = 0
        self.closed = 0
        self.changed = threading.Condition()

    def connect(self, uri: str) -> Nodes._Sender:
        with self.changed:
            self.opened += 1
        return Nodes._Sender(self, uri)

    def wait_for_calls(self, count: int) -> None:
        with self.changed:
            assert self.changed.wait_for(lambda: len(self.calls) >= count, DEADLINE), self.calls

    class _Sender:
        def __init__(self, nodes: Nodes, uri: str) -> None:
            self.nodes = nodes
            self.uri = uri

        def send(self, note: Notification) -> DeliveryOutcome:
            with self.nodes.changed:
                self.nodes.calls.append(note)
                self.nodes.groups.append(threading.current_thread().name.rpartition("-")[2])
                self.nodes.changed.notify_all()
            return self.nodes.behave.get(self.uri, lambda _: DeliveryOutcome.DONE)(note)

        def close(self) -> None:
            with self.nodes.changed:
                self.nodes.closed += 1


@pytest.fixture
def nodes() -> Nodes:
    return Nodes()


@pytest.fixture
def notifier(nodes: Nodes, monkeypatch: pytest.MonkeyPatch) -> Iterator[Notifier]:
    monkeypatch.setattr(notifier_module, "PAUSES", (0.0, 0.0))
    monkeypatch.setattr(notifier_module, "IDLE_SECONDS", 0.05)
    made = Notifier(nodes.connect, prompt_workers=3, patient_workers=2)
    yield made
    made.close()


def update(uri: str, *publishers: str, topic: str = "/t") -> PublisherUpdate:
    return PublisherUpdate(uri, topic, publishers)


def test_notifications_of_one_node_arrive_in_order(nodes: Nodes, notifier: Notifier) -> None:
    """Over one sender, which is closed when the queue is empty."""
    release = threading.Event()
    nodes.behave["a"] = lambda _: DeliveryOutcome.DONE if release.wait(DEADLINE) else DeliveryOutcome.GONE
    sent = [update("a", topic=f"/{i}") for i in range(5)]
    for note in sent:
        notifier.post(note)
    release.set()
    assert notifier.wait_until_quiet(DEADLINE)
    assert nodes.calls == sent
    assert nodes.opened == 1


def test_only_the_newest_list_of_a_topic_is_sent(nodes: Nodes, notifier: Notifier) -> None:
    """While a node is busy, later lists replace earlier ones that wait."""
    release = threading.Event()
    nodes.behave["a"] = lambda _: DeliveryOutcome.DONE if release.wait(DEADLINE) else DeliveryOutcome.GONE
    notifier.post(update("a", topic="/first"))
    nodes.wait_for_calls(1)
    for count in range(1000):
        notifier.post(update("a", *["p"] * (count % 7)))
    release.set()
    assert notifier.wait_until_quiet(DEADLINE)
    assert nodes.calls[1:] == [update("a", *["p"] * (999 % 7))]
    assert notifier.stats()["replaced"] == 999


def test_a_replaced_parameter_update_moves_behind_its_parents(nodes: Nodes, notifier: Notifier) -> None:
    """/a/b=1, /a={}, /a/b=2 ends with /a/b=2, not with the deletion."""
    release = threading.Event()
    nodes.behave["a"] = lambda _: DeliveryOutcome.DONE if release.wait(DEADLINE) else DeliveryOutcome.GONE
    notifier.post(update("a"))
    nodes.wait_for_calls(1)
    for key, value in (("/a/b/", 1), ("/a/", {}), ("/a/b/", 2)):
        notifier.post(ParamUpdate("a", key, value))
    release.set()
    assert notifier.wait_until_quiet(DEADLINE)
    assert nodes.calls[1:] == [ParamUpdate("a", "/a/", {}), ParamUpdate("a", "/a/b/", 2)]


def test_a_stuck_node_delays_nobody(nodes: Nodes, notifier: Notifier) -> None:
    """Others get theirs while one call has not returned."""
    release = threading.Event()
    nodes.behave["stuck"] = lambda _: DeliveryOutcome.DONE if release.wait(DEADLINE) else DeliveryOutcome.GONE
    notifier.post(update("stuck"))
    nodes.wait_for_calls(1)
    for name in "bcdef":
        notifier.post(update(name))
    nodes.wait_for_calls(6)
    release.set()
    assert notifier.wait_until_quiet(DEADLINE)


def test_more_silent_nodes_than_workers_delay_only_each_other(nodes: Nodes, notifier: Notifier) -> None:
    """Once known as silent they share the patient lane, and the prompt one is free."""
    release = threading.Event()
    silent = [f"silent{i}" for i in range(10)]
    first: set[str] = set()

    def slow(note: Notification) -> DeliveryOutcome:
        if note.uri not in first:  # the first attempt fails fast, every later one hangs
            first.add(note.uri)
            return DeliveryOutcome.SILENT
        release.wait(DEADLINE)
        return DeliveryOutcome.SILENT

    for name in silent:
        nodes.behave[name] = slow
        notifier.post(update(name))
    nodes.wait_for_calls(10)
    notifier.post(update("healthy"))
    with nodes.changed:
        assert nodes.changed.wait_for(lambda: update("healthy") in nodes.calls, DEADLINE)
    assert notifier.stats()["threads"] <= 5
    release.set()
    assert notifier.wait_until_quiet(DEADLINE)


def test_a_silent_node_is_tried_again_and_then_given_up(nodes: Nodes, notifier: Notifier) -> None:
    """Once and once more per pause; then its queue is dropped and counted."""
    nodes.behave["a"] = lambda _: DeliveryOutcome.SILENT
    notifier.post(update("a"))
    assert notifier.wait_until_quiet(DEADLINE)
    assert len(nodes.calls) == 3
    assert notifier.stats()["failed"] == 1


def test_a_node_that_wakes_up_gets_what_it_missed(nodes: Nodes, notifier: Notifier) -> None:
    """The same call again, then the rest; afterwards it is served promptly again."""
    answers = iter([DeliveryOutcome.SILENT, DeliveryOutcome.DONE, DeliveryOutcome.DONE, DeliveryOutcome.DONE])
    nodes.behave["a"] = lambda _: next(answers)
    notifier.post(update("a", "p"))
    assert notifier.wait_until_quiet(DEADLINE)
    notifier.post(update("a", "q"))
    assert notifier.wait_until_quiet(DEADLINE)
    assert nodes.calls == [update("a", "p"), update("a", "p"), update("a", "q")]
    assert nodes.groups == ["prompt", "patient", "prompt"]


def test_nobody_listening_is_final(nodes: Nodes, notifier: Notifier) -> None:
    """A refused connection is not tried again: the node is gone, and will register when it returns."""
    nodes.behave["a"] = lambda _: DeliveryOutcome.GONE
    notifier.post(update("a"))
    assert notifier.wait_until_quiet(DEADLINE)
    assert len(nodes.calls) == 1


def test_news_for_who_comes_to_a_dead_nodes_address_are_not_lost(nodes: Nodes, notifier: Notifier) -> None:
    """What was queued before the refused call is dropped, what was posted during it is sent."""
    release = threading.Event()

    def first_refused(note: Notification) -> DeliveryOutcome:
        if note != update("a", topic="/1"):
            return DeliveryOutcome.DONE
        release.wait(DEADLINE)
        return DeliveryOutcome.GONE

    nodes.behave["a"] = first_refused
    notifier.post(update("a", topic="/1"))
    nodes.wait_for_calls(1)
    notifier.post(update("a", topic="/2"))
    release.set()
    assert notifier.wait_until_quiet(DEADLINE)
    assert nodes.calls == [update("a", topic="/1"), update("a", topic="/2")]
    assert notifier.stats()["failed"] == 1


def test_what_was_queued_for_a_dead_node_goes_with_it(nodes: Nodes, notifier: Notifier) -> None:
    """One refused connection, not one per notification."""
    holder, release = update("busy"), threading.Event()
    nodes.behave["a"] = lambda _: DeliveryOutcome.GONE
    for name in ("b", "c", "d"):
        nodes.behave[name] = lambda _: (
            DeliveryOutcome.DONE if release.wait(DEADLINE) else DeliveryOutcome.GONE
        )
        notifier.post(holder._replace(uri=name))
    nodes.wait_for_calls(3)  # all prompt workers are busy
    notifier.post(update("a", topic="/1"))
    notifier.post(update("a", topic="/2"))
    release.set()
    assert notifier.wait_until_quiet(DEADLINE)
    assert nodes.calls[3:] == [update("a", topic="/1")]
    assert notifier.stats()["failed"] == 2


def test_a_failing_sender_costs_only_its_own_node(nodes: Nodes, notifier: Notifier) -> None:
    """An exception out of a sender is logged and the worker lives on."""

    def broken(note: Notification) -> DeliveryOutcome:
        raise RuntimeError("a bug")

    nodes.behave["a"] = broken
    notifier.post(update("a"))
    notifier.post(update("b"))
    assert notifier.wait_until_quiet(DEADLINE)
    assert update("b") in nodes.calls


def test_a_flooded_node_drops_its_oldest(nodes: Nodes) -> None:
    """The queue of a node is bounded and drops are counted."""
    release = threading.Event()
    nodes.behave["a"] = lambda _: DeliveryOutcome.DONE if release.wait(DEADLINE) else DeliveryOutcome.GONE
    notifier = Notifier(nodes.connect, pending_per_node=3)
    notifier.post(update("a", topic="/first"))
    nodes.wait_for_calls(1)
    for number in range(5):
        notifier.post(update("a", topic=f"/{number}"))
    release.set()
    assert notifier.wait_until_quiet(DEADLINE)
    assert [note.topic for note in nodes.calls[1:]] == ["/2", "/3", "/4"]  # type: ignore[union-attr]
    assert notifier.stats()["dropped"] == 2
    notifier.close()


def test_threads_end_when_idle_and_start_again(nodes: Nodes, notifier: Notifier) -> None:
    """An idle master has no notification thread."""
    for _ in range(2):
        notifier.post(update("a"))
        assert notifier.wait_until_quiet(DEADLINE)
        eventually(lambda: notifier.stats()["threads"] == 0)
    assert len(nodes.calls) == 2
    assert nodes.opened == nodes.closed == 2


def test_close_is_bounded_idempotent_and_final(nodes: Nodes, notifier: Notifier) -> None:
    """A hanging call is abandoned through its sender; nothing is sent afterwards."""
    release = threading.Event()
    nodes.behave["a"] = lambda _: DeliveryOutcome.DONE if release.wait(DEADLINE) else DeliveryOutcome.GONE
    notifier.post(update("a"))
    nodes.wait_for_calls(1)
    notifier.post(update("a", topic="/later"))
    notifier.close(timeout=0.05)
    assert nodes.closed == 1
    notifier.close(timeout=0.05)
    notifier.post(update("b"))
    release.set()
    eventually(lambda: notifier.stats()["threads"] == 0)
    assert nodes.calls == [update("a")]


def test_without_a_further_thread_the_running_one_serves_everybody(
    nodes: Nodes, notifier: Notifier, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """A process at its limit of threads: slower, but nothing is lost."""
    busy, go = threading.Event(), threading.Event()

    def hold(note: Notification) -> DeliveryOutcome:
        busy.set()
        assert go.wait(DEADLINE)
        return DeliveryOutcome.DONE

    nodes.behave["http://one/"] = hold
    notifier.post(update("http://one/", "a"))
    assert busy.wait(DEADLINE)

    def refuse(thread: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", refuse)
    notifier.post(update("http://two/", "a"))
    notifier.post(update("http://three/", "a"))
    go.set()
    assert notifier.wait_until_quiet(DEADLINE)
    assert [note.uri for note in nodes.calls] == ["http://one/", "http://two/", "http://three/"]
    assert "cannot start another thread for notifications" in caplog.text


def test_the_list_of_silent_nodes_is_bounded(
    nodes: Nodes, notifier: Notifier, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Thousands of registered addresses where nobody answers cost no memory for ever."""
    monkeypatch.setattr(notifier_module, "MAX_SLOW_NODES", 3)
    uris = [f"http://silent{number}/" for number in range(6)]
    for uri in uris:
        nodes.behave[uri] = lambda _: DeliveryOutcome.SILENT
        notifier.post(update(uri, "a"))
        assert notifier.wait_until_quiet(DEADLINE)
    nodes.behave.clear()
    nodes.groups.clear()
    for uri in uris:
        notifier.post(update(uri, "b"))
        assert notifier.wait_until_quiet(DEADLINE)
    assert nodes.groups == ["prompt"] * 3 + ["patient"] * 3
