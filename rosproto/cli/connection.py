"""What every command that talks to a graph shares: which master, as whom, and how results are printed."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, cast

from rosproto.errors import ConnectionLost, RemoteProtocolError, RosTimeout
from rosproto.text import printable

from .console import json_text
from .exit_codes import CommandError
from .options import AddArguments, add_json
from .parser import near

if TYPE_CHECKING:  # imported when they are used: --help has no use for them
    from rosproto.msg import DefinitionLibrary
    from rosproto.node.graph.master_client import MasterClient
    from rosproto.node.graph.slave_client import NodeClient
    from rosproto.transport.robot_host_names import HostNames


CALLER_ID = "/rosproto"
TIMEOUT = 5.0


def add_graph_options(parser: argparse.ArgumentParser, *, as_json: bool = True) -> None:
    """--master, --msg-path, --no-learned, --resolve, --json: understood by every verb."""
    parser.add_argument(
        "--master",
        metavar="URI",
        help="the ROS master (default: $ROS_MASTER_URI, else http://localhost:11311)",
    )
    parser.add_argument(
        "--msg-path",
        action="append",
        metavar="FOLDER",
        help="definitions of your own or another firmware",
    )
    parser.add_argument(
        "--no-learned", action="store_true", help="do without what `woosh learn` has kept for you"
    )
    parser.add_argument(
        "--resolve",
        action="append",
        metavar="NAME=IP",
        help="the address of a host name that this computer does not know (also $ROSPROTO_RESOLVE)",
    )
    if as_json:
        add_json(parser)


def master_uri(arguments: argparse.Namespace) -> str:
    """--master, else the environment, else this computer."""
    return arguments.master or os.environ.get("ROS_MASTER_URI") or "http://localhost:11311"


@contextmanager
def master_client(arguments: argparse.Namespace) -> Iterator[MasterClient]:
    """Typed calls to the master, without being a node: nothing is registered.

    Raises:
        ConnectionLost: It is not there, keeps silent, or is no master: the same to a script.
    """
    from .escaped_api import ShownMaster

    hosts = host_names(arguments)
    with ShownMaster(master_uri(arguments), CALLER_ID, timeout=TIMEOUT, hosts=hosts) as master:
        try:
            yield master
        except (RosTimeout, RemoteProtocolError) as error:
            raise ConnectionLost(str(error), peer=error.peer, why=error.why) from error


def node_client(uri: str, arguments: argparse.Namespace, *, guess: bool = True) -> NodeClient:
    """Typed calls to a node's slave API; without `guess` never at the master's host for an unknown one."""
    from .escaped_api import ShownNode

    return ShownNode(uri, CALLER_ID, timeout=TIMEOUT, hosts=host_names(arguments, guess=guess))


def host_names(arguments: argparse.Namespace, *, guess: bool = True) -> HostNames:
    """--resolve, then $ROSPROTO_RESOLVE, then the master's host for what nobody knows.

    One for each command, so that a name is looked up once.
    """
    from rosproto.transport.robot_host_names import HostNames
    from rosproto.transport.uri import parse_uri

    if not guess:
        return HostNames(given_names(arguments))
    if getattr(arguments, "hosts", None) is None:
        arguments.hosts = HostNames(given_names(arguments), master=parse_uri(master_uri(arguments))[0])
    return cast("HostNames", arguments.hosts)


def given_names(arguments: argparse.Namespace) -> dict[str, str]:
    """Host names given by hand: those of --resolve, then those of the environment."""
    from rosproto.node.options import host_names as of_environment
    from rosproto.transport.robot_host_names import parse_host_names

    return {**of_environment(), **parse_host_names(arguments.resolve or ())}


def open_node(arguments: argparse.Namespace, name: str = "rosproto") -> Any:
    """A node with a name of its own, for commands that publish, subscribe or call.

    ROS_IP, ROS_HOSTNAME and ROS_NAMESPACE are honoured: this is a program of its own.
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


def msg_path(arguments: argparse.Namespace) -> list[Any]:
    """The user's own folders (--msg-path, the environment), then what `woosh learn` has kept."""
    from rosproto.msg.user_folder import own_and_learned

    return own_and_learned(arguments.msg_path or (), learned=not arguments.no_learned)


def library_for(arguments: argparse.Namespace, name: str, kind: str = "msg") -> DefinitionLibrary | None:
    """Where a type's definition is; None for the bundled ones. The user's own go first, learned ones last."""
    from rosproto.msg.user_folder import library_of

    learned = not getattr(arguments, "no_learned", False)
    return library_of(name, kind, arguments.msg_path or (), learned=learned)


def absolute(name: str) -> str:
    """A name as typed, with the slash that people leave out, below $ROS_NAMESPACE."""
    if name.startswith("/"):
        return name
    space = os.environ.get("ROS_NAMESPACE", "").strip("/")
    return f"/{space}/{name}" if space else f"/{name}"


def below(names: Iterable[str], asked: str) -> list[str]:
    """Those of a namespace, or that match a pattern (`/move_base/*`); sorted."""
    if asked in ("", "/"):
        return sorted(names)
    if any(sign in asked for sign in "*?["):
        import fnmatch

        return sorted(fnmatch.filter(names, absolute(asked)))
    space = absolute(asked).rstrip("/")
    return sorted(name for name in names if name == space or name.startswith(space + "/"))


def warn_if_none(found: Collection[object], what: str, asked: str, names: Iterable[str]) -> None:
    """Nothing to list where something was asked for: perhaps the name is mistyped."""
    if asked and asked != "/" and not found:
        warn(f"no {what} is called {absolute(asked)} or lies below it{near(absolute(asked), names)}")


def unknown(what: str, name: str, names: Iterable[str], see: str) -> CommandError:
    """The error for a name that is not there: what is near it, and where to look."""
    return CommandError(f"{what} {name!r}{near(name, names)}; see: rosproto {see}")


def warn(text: str) -> None:
    """A line on stderr that does not end the command."""
    print(printable(f"WARNING: {text}"), file=sys.stderr, flush=True)


def print_json(value: object) -> None:
    """One line of JSON."""
    print(json_text(value, ascii_only=not _utf8(), default=str))


def _utf8() -> bool:
    return (sys.stdout.encoding or "").lower().replace("-", "") == "utf8"


Verb = tuple[AddArguments | None, Callable[[argparse.Namespace], int], str]
"""What adds its arguments, what runs it, help."""


def verbs(parser: argparse.ArgumentParser, table: dict[str, Verb], *, graph: bool = True) -> None:
    """Add the verbs of a command: `rosproto topic list`."""
    choices = parser.add_subparsers(title="verbs", metavar="VERB", dest="verb", required=True)
    for name, (add, run, text) in table.items():
        sub = choices.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        if graph:
            add_graph_options(sub)
        if add is not None:
            add(sub)
        sub.set_defaults(run=run)
