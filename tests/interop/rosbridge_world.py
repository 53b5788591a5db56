"""A robot of rospy, a bridge before it (the original or ours), and a node of the test's own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from rosproto.node import Node
from tests.support import ros, rosbridge_suite

__all__ = ["World", "our_bridge", "world"]

ROBOT = Path(__file__).parent / "rosbridge_robot.py"
PARAMETERS = {"/speed": 0.5, "/robot": {"name": "ö", "size": [1, 2.5, True]}, "/ask_whom": "/browser"}


@dataclass(frozen=True)
class World:
    """What web clients are let loose on.

    Attributes:
        url: Of the bridge.
        bridge: "original" or "ours".
        master_uri: Debian's master.
        node: The test's own.
    """

    url: str
    bridge: str
    master_uri: str
    node: Node

    @property
    def port(self) -> int:
        """The bridge's port, on 127.0.0.1."""
        return int(self.url.rpartition(":")[2].strip("/"))


@contextmanager
def world(
    bridge: str, master_uri: str, packages: Path, built: Path | None = None, *, layer: bool = False
) -> Iterator[World]:
    """A world around a master.

    Args:
        bridge: "original" or "ours".
        master_uri: Where.
        packages: Generated messages for rospy.
        built: What `rosbridge_suite.build` made, for the original.
        layer: The original on our own rospy.
    """
    with ExitStack() as stack:
        node = stack.enter_context(Node("/test", master_uri=master_uri, host="127.0.0.1"))
        for key, value in PARAMETERS.items():
            node.params[key] = value
        robot = stack.enter_context(ros.start_rospy(ROBOT, master_uri.rstrip("/"), packages=packages))
        robot.wait_for("ready")
        if bridge == "original":
            assert built is not None
            served = rosbridge_suite.served(
                rosbridge_suite.checkout(), built, master_uri, layer=layer, messages=packages
            )
            url = stack.enter_context(served)
        else:
            url = stack.enter_context(our_bridge(master_uri))
        yield World(url.rstrip("/"), bridge, master_uri, node)


@contextmanager
def our_bridge(master_uri: str, name: str = "/rosbridge_websocket") -> Iterator[str]:
    """Ours, with everything open that the original opens."""
    from rosproto.gateway import Access, Rosbridge

    with (
        Node(name, master_uri=master_uri, host="127.0.0.1") as node,
        Rosbridge(node, port=0, access=Access(write=("*",))) as bridge,
    ):
        yield bridge.url
