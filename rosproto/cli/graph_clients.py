"""Connections of a command: a client of the master, a client of a node, a node."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rosproto.errors import ConnectionLost, RemoteProtocolError, RosTimeout

from .graph_options import given_names, host_names, master_uri, msg_path

if TYPE_CHECKING:  # imported late: --help does not need them
    from rosproto.node.graph.master_client import MasterClient
    from rosproto.node.graph.slave_client import NodeClient

CALLER_ID = "/rosproto"
TIMEOUT = 5.0


@contextmanager
def master_client(arguments: argparse.Namespace) -> Iterator[MasterClient]:
    """Open a client of the master, without registering a node.

    Raises:
        ConnectionLost: The address is unreachable, does not answer, or is no master.
    """
    from .escaped_api import EscapedMasterClient

    hosts = host_names(arguments)
    with EscapedMasterClient(master_uri(arguments), CALLER_ID, timeout=TIMEOUT, hosts=hosts) as master:
        try:
            yield master
        except (RosTimeout, RemoteProtocolError) as error:
            raise ConnectionLost(str(error), peer=error.peer, why=error.why) from error


def node_client(uri: str, arguments: argparse.Namespace, *, guess: bool = True) -> NodeClient:
    """Return a client of a node's slave API; `guess` uses the master's address for an unknown host."""
    from .escaped_api import EscapedNodeClient

    return EscapedNodeClient(uri, CALLER_ID, timeout=TIMEOUT, hosts=host_names(arguments, guess=guess))


def open_node(arguments: argparse.Namespace, name: str = "rosproto") -> Any:
    """Open a node with a unique name, for commands that publish, subscribe or call.

    It follows ROS_IP, ROS_HOSTNAME and ROS_NAMESPACE.
    """
    from rosproto.node import Node

    return Node(
        name,
        master_uri=master_uri(arguments),
        anonymous=True,
        use_environment=True,
        rosout=False,
        msg_path=msg_path(arguments),
        resolve=given_names(arguments),
    )
