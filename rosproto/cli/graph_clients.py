"""Connections of a command (clients of the master and of nodes, a node), and names as they are typed."""

from __future__ import annotations

import argparse
import os
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rosproto.cli.console import warn
from rosproto.cli.exit_codes import CommandError
from rosproto.cli.graph_options import given_names, host_names, master_uri, msg_path
from rosproto.cli.parser import near
from rosproto.errors import ConnectionLost, RemoteProtocolError, RosTimeout

if TYPE_CHECKING:
    from rosproto.node import Node

if TYPE_CHECKING:  # imported late: --help does not need them
    from rosproto.node.graph.master_client import MasterClient
    from rosproto.node.graph.slave_client import NodeClient

CALLER_ID = "/rosproto"
TIMEOUT = 5.0


@contextmanager
def master_client(arguments: argparse.Namespace) -> Iterator[MasterClient]:
    """Open a client of the master, without registering a node.

    Raises:
        ConnectionLost: The address is unreachable, does not answer, or is not a master.
    """
    from rosproto.cli.escaped_api import EscapedMasterClient

    hosts = host_names(arguments)
    with EscapedMasterClient(master_uri(arguments), CALLER_ID, timeout=TIMEOUT, hosts=hosts) as master:
        try:
            yield master
        except (RosTimeout, RemoteProtocolError) as error:
            raise ConnectionLost(str(error), peer=error.peer, why=error.why) from error


def node_client(uri: str, arguments: argparse.Namespace, *, guess: bool = True) -> NodeClient:
    """Return a client of a node's slave API; `guess` uses the master's address for an unknown host."""
    from rosproto.cli.escaped_api import EscapedNodeClient

    return EscapedNodeClient(uri, CALLER_ID, timeout=TIMEOUT, hosts=host_names(arguments, guess=guess))


def open_node(arguments: argparse.Namespace, name: str = "rosproto") -> Node:
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


# -- names as typed ------------------------------------------------------------------------------------------


def absolute(name: str) -> str:
    """Return a typed name as absolute, below $ROS_NAMESPACE; "" is that namespace.

    Raises:
        ValueError: It is private: a command has no names of its own.
    """
    if name.startswith("/"):
        return name
    if name.startswith("~"):
        raise ValueError(f"{name}: a private name belongs to a node; write /NODE/{name[1:]}")
    space = os.environ.get("ROS_NAMESPACE", "").strip("/")
    return f"/{space}/{name}".rstrip("/") if space else f"/{name}"


def below(names: Iterable[str], asked: str) -> list[str]:
    """Return the names in a namespace, or that match a pattern (`/move_base/*`), sorted."""
    if asked in ("", "/"):
        return sorted(names)
    if any(sign in asked for sign in "*?["):
        import fnmatch

        return sorted(fnmatch.filter(names, absolute(asked)))
    space = absolute(asked).rstrip("/")
    return sorted(name for name in names if name == space or name.startswith(space + "/"))


def warn_if_none(found: Collection[object], what: str, asked: str, names: Iterable[str]) -> None:
    """Warn if a name was given and not found: it may be mistyped."""
    if asked and asked != "/" and not found:
        warn(f"no {what} is called {absolute(asked)} or lies below it{near(absolute(asked), names)}")


def unknown(what: str, name: str, names: Iterable[str], see: str) -> CommandError:
    """Return the error for an unknown name, with similar names and the command that lists them."""
    return CommandError(f"{what} {name!r}{near(name, names)}; see: rosproto {see}")
