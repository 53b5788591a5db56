"""Many nodes of one process: they ask the master once for all of them, by no thread of their own."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack

import pytest

from rosproto.master import Master
from rosproto.node import MasterClient, Node
from rosproto.node.master_monitor import MAX_LOOKUPS, MasterMonitor, MasterView
from tests.support.waiting import until

NODES = 25


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """The calls that masters got, by method."""
    calls: Counter[str] = Counter()
    answer = Master.answer

    def count(master: Master, method: str, params: list[object], peer: object) -> object:
        calls[method] += 1
        return answer(master, method, params, peer)

    monkeypatch.setattr(Master, "answer", count)
    return calls


@pytest.fixture
def nodes(asked: Counter[str]) -> Iterator[list[Node]]:
    with ExitStack() as stack:
        master = stack.enter_context(Master())
        opened = [
            stack.enter_context(Node(f"/n{number}", master_uri=master.uri, rosout=False, timeout=20.0))
            for number in range(NODES)
        ]
        for node in opened:
            node.publisher(f"{node.name}/out", "std_msgs/String")
        yield opened


@pytest.fixture(autouse=True)
def looked(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """The looks at the master, by node."""
    counted: Counter[str] = Counter()
    look = MasterMonitor.look

    def count(monitor: MasterMonitor, view: MasterView, busy: float) -> None:
        look(monitor, view, busy)
        counted[monitor.name] += 1

    monkeypatch.setattr(MasterMonitor, "look", count)
    return counted


def test_the_master_is_asked_once_for_all_nodes(
    nodes: list[Node], asked: Counter[str], looked: Counter[str]
) -> None:
    """Its process id and the graph once in a round, not once for each node, and a few names."""
    for node in nodes:
        node.watch_master(period=0.2, full_check_every=2)
    until(lambda: {node.name for node in nodes} <= set(looked))
    before, first = Counter(asked), looked.total()
    until(lambda: looked.total() - first >= 10 * NODES)
    rounds = (looked.total() - first) / NODES
    during = asked - before
    assert during["getPid"] <= 3 * rounds  # one, as long as the computer is not too busy
    assert during["getSystemState"] <= 2 * rounds
    assert during["lookupNode"] <= MAX_LOOKUPS * during["getPid"]


def test_a_node_that_the_master_has_forgotten_is_registered_again(nodes: list[Node]) -> None:
    """Each of many, though their names are looked up in turn and their registrations compared together."""
    for node in nodes:
        node.watch_master(period=0.05, full_check_every=2)
        node.check_master_now()
    with MasterClient(nodes[0].master_uri, "/somebody") as somebody:
        for node in (nodes[0], nodes[11], nodes[-1]):
            with MasterClient(node.master_uri, node.name) as thief:
                assert thief.unregister_publisher(f"{node.name}/out", node.uri) == 1
        until(lambda: len(somebody.get_system_state().publishers) == NODES)


def test_no_thread_waits_for_one_node(nodes: list[Node], looked: Counter[str]) -> None:
    """A thread for the connections and a few that they share, whatever their number."""
    until(lambda: {node.name for node in nodes} <= set(looked))
    names = Counter(thread.name for thread in threading.enumerate() if "/n" in thread.name)
    assert not [name for name in names if "monitor" in name or "accept" in name]


def test_closing_a_node_ends_its_looks_and_no_others(nodes: list[Node], looked: Counter[str]) -> None:
    """The first one, which asks for all, and one behind it."""
    for node in nodes:
        node.watch_master(period=0.05, full_check_every=2)
        node.check_master_now()
    until(lambda: {node.name for node in nodes} <= set(looked))
    nodes[0].close()
    nodes[7].close()
    before = Counter(looked)
    until(lambda: all((looked - before)[node.name] > 3 for node in nodes if not node.closed))
    during = looked - before
    assert not during[nodes[0].name]
    assert not during[nodes[7].name]
