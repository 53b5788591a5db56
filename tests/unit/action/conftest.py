"""A client whose server, network and clock are played by the test."""

from __future__ import annotations

import pytest

from rosproto.action.client import ActionClient
from tests.support.clock import FakeClock
from tests.unit.action.fakegraph import ACTION, FakeNode, Graph


@pytest.fixture
def graph():
    graph = Graph()
    graph.connect_server()
    return graph


@pytest.fixture
def clock():
    return FakeClock()


@pytest.fixture
def node(graph):
    return FakeNode(graph, "/me")


@pytest.fixture
def client(node, clock):
    with ActionClient(node, "act", ACTION, clock=clock) as client:
        yield client
