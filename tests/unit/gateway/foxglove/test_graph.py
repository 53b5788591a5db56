"""The graph as it is polled: which run of the master answers."""

from __future__ import annotations

import queue

import pytest

from rosproto.errors import RosError
from rosproto.gateway.foxglove import graph
from rosproto.gateway.foxglove.graph import GraphView, GraphWatch, MasterRun
from rosproto.master import Master
from rosproto.node import Node


@pytest.mark.parametrize(
    ("before", "now", "another"),
    [
        (None, MasterRun(1, "a"), False),
        (MasterRun(1, "a"), MasterRun(1, "a"), False),
        (MasterRun(1, "a"), MasterRun(1, "b"), True),
        (MasterRun(1, "a"), MasterRun(2, "a"), True),
        (MasterRun(1), MasterRun(1, "a"), False),
        (MasterRun(1, "a"), MasterRun(1), False),
        (MasterRun(1), MasterRun(2), True),
        (MasterRun(1), MasterRun(2, "a"), True),
    ],
)
def test_another_run_of_the_master(before: MasterRun | None, now: MasterRun, another: bool) -> None:
    """By its process, and by /run_id where it is known."""
    assert now.is_another(before) is another


def test_a_run_id_that_is_set_later_is_the_same_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """roscore sets /run_id a moment after its master answers; what was lost and came back is that run."""
    monkeypatch.setattr(graph, "PERIOD", 0.05)
    views: queue.Queue[GraphView] = queue.Queue()
    lost: queue.Queue[RosError] = queue.Queue()
    back: queue.Queue[bool] = queue.Queue()
    with Master() as master, Node("/gateway", master_uri=master.uri, rosout=False) as node:
        node.params.delete("/run_id")
        watch = GraphWatch(node, wanted=lambda: True, changed=views.put, lost=lost.put, back=back.put)
        try:
            first = views.get(timeout=10).master
            assert first is not None
            assert first.run_id is None
            node.params["/run_id"] = "set by roslaunch"
            second = views.get(timeout=10).master
            assert second == MasterRun(first.pid, "set by roslaunch")
            watch.problem = RosError("the master was away")
            assert back.get(timeout=10) is False
            assert lost.empty()
        finally:
            watch.close(5.0)
