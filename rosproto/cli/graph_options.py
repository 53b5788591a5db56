"""The verbs of a command (`list` in `rosproto topic list`), and options to choose a graph and definitions."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from typing import TYPE_CHECKING, cast

from rosproto.cli.options import AddArguments, add_json

if TYPE_CHECKING:  # imported late: --help does not need them
    from rosproto.msg import DefinitionLibrary
    from rosproto.transport.robot_host_names import HostNames


def add_graph_options(parser: argparse.ArgumentParser, *, as_json: bool = True) -> None:
    """Add --master, --msg-path, --no-learned, --resolve and --json to a verb."""
    parser.add_argument(
        "--master",
        metavar="URI",
        help="the ROS master, a URI or a host (default: $ROS_MASTER_URI, else that of `woosh connect`, "
        "else http://localhost:11311)",
    )
    parser.add_argument(
        "--msg-path",
        action="append",
        metavar="FOLDER",
        help="definitions of your own or another firmware",
    )
    parser.add_argument(
        "--no-learned", action="store_true", help="ignore the definitions that `woosh learn` has saved"
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
    """Return --master, else the environment's, else the saved one, else this computer's URI."""
    from rosproto.profile import remembered
    from rosproto.transport.uri import DEFAULT_MASTER_URI, master_uri_of

    if not arguments.master and (profile := remembered()) is not None:
        return master_uri_of(profile.chassis)
    return master_uri_of(arguments.master or os.environ.get("ROS_MASTER_URI") or DEFAULT_MASTER_URI)


def host_names(arguments: argparse.Namespace, *, guess: bool = True) -> HostNames:
    """Return the host names of --resolve, then $ROSPROTO_RESOLVE; `guess` adds the master's for unknown ones.

    There is one object per command, so that each name is looked up once.
    """
    from rosproto.transport.robot_host_names import HostNames
    from rosproto.transport.uri import parse_uri

    if not guess:
        return HostNames(given_names(arguments))
    if getattr(arguments, "hosts", None) is None:
        arguments.hosts = HostNames(given_names(arguments), master=parse_uri(master_uri(arguments))[0])
    return cast("HostNames", arguments.hosts)


def given_names(arguments: argparse.Namespace) -> dict[str, str]:
    """Return the host names of --resolve and the environment; --resolve has priority."""
    from rosproto.node.options import host_names as of_environment
    from rosproto.transport.robot_host_names import parse_host_names

    return {**of_environment(), **parse_host_names(arguments.resolve or ())}


def msg_path(arguments: argparse.Namespace) -> list[str | os.PathLike[str]]:
    """Return the user's folders (--msg-path, the environment), then that of `woosh learn`."""
    from rosproto.msg.user_folder import own_and_learned

    return own_and_learned(arguments.msg_path or (), learned=not arguments.no_learned)


def library_for(arguments: argparse.Namespace, name: str, kind: str = "msg") -> DefinitionLibrary | None:
    """Return the library that defines a type, None for the bundled one; the user's folders have priority."""
    from rosproto.msg.user_folder import library_of

    learned = not getattr(arguments, "no_learned", False)
    return library_of(name, kind, arguments.msg_path or (), learned=learned)


# -- verbs ---------------------------------------------------------------------------------------------------


Verb = tuple[AddArguments | None, Callable[[argparse.Namespace], int | None], str]
"""What adds its arguments, what runs it and returns the exit code (None: done), help."""


def add_verbs(parser: argparse.ArgumentParser, table: dict[str, Verb], *, graph: bool = True) -> None:
    """Add the verbs of a command: `rosproto topic list`."""
    choices = parser.add_subparsers(title="verbs", metavar="VERB", dest="verb", required=True)
    for name, (add, run, text) in table.items():
        sub = choices.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        if graph:
            add_graph_options(sub)
        if add is not None:
            add(sub)
        sub.set_defaults(run=run)
