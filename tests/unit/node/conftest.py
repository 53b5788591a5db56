"""What the tests of topics and of services share."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest

from rosproto.master import Master
from rosproto.node import Node
from tests.support.small_node import SmallNode


@pytest.fixture(scope="module")
def master() -> Iterator[Master]:
    with Master() as master:
        yield master


@pytest.fixture(params=[False, True], ids=["tcp", "local"])
def nodes(master: Master, request: pytest.FixtureRequest) -> Iterator[tuple[Node, Node]]:
    """Two nodes that exchange messages over TCP, or in the process."""
    name = f"n{threading.get_ident()}_{time.monotonic_ns()}"
    options: Any = {"master_uri": master.uri, "intraprocess": request.param, "rosout": False}
    options["timeout"] = 20.0
    with Node(f"/a_{name}", **options) as a, Node(f"/b_{name}", **options) as b:
        yield a, b


@pytest.fixture
def node() -> Iterator[SmallNode]:
    with SmallNode() as small:
        yield small


@pytest.fixture(params=[False, True], ids=["one-shot", "persistent"])
def persistent(request) -> bool:
    return request.param
