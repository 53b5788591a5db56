"""A robot's node and a gateway's, at one master."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any, NamedTuple

import pytest

from rosproto import Master, Node
from rosproto.gateway import Access, GatewayLimits
from tests.support.rosbridge_client import RosbridgeClient


class Graph(NamedTuple):
    robot: Node
    node: Node


@pytest.fixture
def graph() -> Iterator[Graph]:
    with (
        Master() as master,
        Node("/robot", master_uri=master.uri, intraprocess=False) as robot,
        Node("/gateway", master_uri=master.uri, intraprocess=False) as node,
    ):
        yield Graph(robot, node)


@pytest.fixture
def serve(graph: Graph) -> Iterator[Callable[..., Any]]:
    """`serve(write=[...], **options)`: a Rosbridge on the gateway's node."""
    pytest.importorskip("websockets", reason='websockets is not installed: pip install ".[bridge]"')
    from rosproto.gateway import Rosbridge

    with ExitStack() as stack:

        def make(write: list[str] | None = None, limits: GatewayLimits | None = None, **options: Any) -> Any:
            access = options.pop("access", None) or Access(write=write or [])
            limits = limits or GatewayLimits(linger_seconds=0.05)
            return stack.enter_context(Rosbridge(graph.node, port=0, access=access, limits=limits, **options))

        yield make


@pytest.fixture
def connect() -> Iterator[Callable[..., RosbridgeClient]]:
    """`connect(bridge)`: a client, closed at the end."""
    with ExitStack() as stack:
        yield lambda bridge, **options: stack.enter_context(RosbridgeClient(bridge.url, **options))
