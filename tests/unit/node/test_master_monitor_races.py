"""What the master monitor asks the master, and what the node does meanwhile."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

import rosproto
from rosproto.master import Master
from rosproto.node.master_monitor import MasterMonitor


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> list[MasterMonitor]:
    """The monitors that were to start: their looks at the master are taken by hand."""
    monitors: list[MasterMonitor] = []
    monkeypatch.setattr(MasterMonitor, "start", lambda monitor: monitors.append(monitor))
    return monitors


@pytest.fixture
def node(started: list[MasterMonitor]) -> Iterator[rosproto.Node]:
    with Master() as master, rosproto.Node("/busy", master_uri=master.uri, rosout=False) as node:
        yield node


@pytest.fixture
def monitor(node: rosproto.Node, started: list[MasterMonitor]) -> MasterMonitor:
    return started[0]


def answered_before(monkeypatch: pytest.MonkeyPatch, holder: Any, name: str, then: Callable[[], Any]) -> None:
    """Have something happen between the master's answer and its arrival, as on a slow network."""
    ask = getattr(holder, name)

    def late(*args: Any, **options: Any) -> Any:
        answer = ask(*args, **options)
        then()
        return answer

    monkeypatch.setattr(holder, name, late)


def test_a_topic_that_is_opened_while_the_graph_is_on_its_way_is_not_missing(
    node, monitor, monkeypatch
) -> None:
    """The master was asked before it was told: no reason to register everything again."""
    node.publisher("/first", "std_msgs/String")
    answered_before(
        monkeypatch,
        node.master,
        "get_system_state",
        lambda: node.publisher("/second", "std_msgs/String"),
    )
    assert monitor.graph_has_all()


def test_a_topic_that_is_closed_meanwhile_is_not_missing(node, monitor, monkeypatch) -> None:
    first = node.publisher("/first", "std_msgs/String")
    first_state = node.master.get_system_state
    monkeypatch.setattr(node.master, "get_system_state", lambda **o: (first.close(), first_state(**o))[1])
    assert monitor.graph_has_all()


def test_the_first_topic_of_a_node_is_not_missed_while_it_is_being_opened(node, monitor, monkeypatch) -> None:
    """Before it the master does not know the node, and that is no sign of a restart."""
    assert monitor.check_registration()
    answered_before(monkeypatch, monitor, "ask", lambda: node.publisher("/first", "std_msgs/String"))
    assert monitor.check_registration()


def test_a_registration_that_the_master_has_lost_is_missing(node, monitor) -> None:
    node.publisher("/first", "std_msgs/String")
    assert monitor.graph_has_all()
    node.master.unregister_publisher("/first", node.uri)
    assert not monitor.graph_has_all()
    assert not monitor.check_registration()
