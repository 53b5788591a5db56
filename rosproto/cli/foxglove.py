"""`rosproto foxglove`: the graph, live, in Foxglove and Lichtblick."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from rosproto.errors import ConnectionLost, LocalProtocolError

from .connection import add_graph_options, open_node
from .failure import CommandError, cannot_listen
from .gateway_options import add_gateway_options, gateway_options, gateway_watchdog, opened, until_interrupted
from .signals import interrupt_on_signals

if TYPE_CHECKING:
    from rosproto.gateway import Foxglove


WEB, DESKTOP = "https://app.foxglove.dev", "file://"
"""Foxglove's own page, and what desktop programs say: they may connect, as this command is run for them.

A browser says "null" for a page from a file, so such a page does not get in as a desktop program. Any link
can lead to the page on the internet with the address of this server in it: it may look, and where something
is open for writing it has to know the token or be named (`--origin`).
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Which graph, where to listen, what is open."""
    add_graph_options(parser, as_json=False)
    add_server_options(parser)


def add_server_options(parser: argparse.ArgumentParser) -> None:
    """What this and `woosh foxglove` share."""
    add_gateway_options(parser, 8765)
    parser.add_argument(
        "--assets",
        action="append",
        type=Path,
        default=[],
        metavar="FOLDER",
        help="a folder with packages: meshes and textures for package:// (also $ROS_PACKAGE_PATH)",
    )


def server_options(arguments: argparse.Namespace, *, write: Sequence[str] = ()) -> dict[str, Any]:
    """What `Foxglove` is to be made with.

    Args:
        arguments: Of the command line.
        write: Patterns besides those of --allow-write.
    """
    options = gateway_options(arguments, write=write)
    web = options["token"] is not None or not options["access"].writes_anything
    listed = filter(None, os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep))
    return {
        **options,
        "origins": (DESKTOP, *((WEB,) if web else ()), *options["origins"]),
        "assets": [*arguments.assets, *listed],
    }


@contextmanager
def serve(node: Any, options: dict[str, Any], **more: Any) -> Iterator[Foxglove]:
    """A server at a node, with errors as a command tells them.

    Raises:
        CommandError: The extra is not installed, or the address cannot be listened on.
    """
    from rosproto.gateway import Foxglove

    try:
        server = Foxglove(node, **options, **more)
    except LocalProtocolError as problem:
        raise CommandError(str(problem)) from problem
    except ConnectionLost as problem:
        # Nobody is out of reach: this computer does not let us listen there.
        raise CommandError(cannot_listen(problem, "--bind")) from problem
    with server:
        yield server


def announced(server: Foxglove, options: dict[str, Any]) -> list[str]:
    """What is said when it serves: the address, what is open, where to look."""
    token = options["token"]
    url = server.url + (f"/?token={quote(token, safe='')}" if token is not None else "")
    page = f"{WEB}/?ds=foxglove-websocket&ds.url={quote(url, safe='')}"
    if WEB in options["origins"] or "*" in options["origins"]:
        web = f"open:  {page}"
    else:
        web = f"Foxglove's page may not connect where writing is open: add --token T, or --origin {WEB}"
    return [
        f"Serving Foxglove at {url} ({opened(options['access'])})",
        web,
        "In Foxglove or Lichtblick: Open connection, Foxglove WebSocket, and that address",
    ]


def run(arguments: argparse.Namespace) -> int:
    """Serve until interrupted."""
    options = server_options(arguments)
    with ExitStack() as stack:
        stack.enter_context(interrupt_on_signals())
        watchdog = stack.enter_context(gateway_watchdog(arguments, options["access"]))
        node = stack.enter_context(open_node(arguments, "foxglove"))
        server = stack.enter_context(serve(node, options, watchdog=watchdog))
        for line in announced(server, options):
            print(line, flush=True)
        try:
            until_interrupted(node, arguments.seconds)
        except KeyboardInterrupt:
            pass  # the orderly end of this command
    return 0
