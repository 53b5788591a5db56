"""`rosproto foxglove`: the graph, live, in Foxglove and Lichtblick."""

from __future__ import annotations

import argparse
import os
import secrets
import ssl
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from rosproto.errors import ConnectionLost

from .bag_signals import interrupt_on_signals
from .connection import add_graph_options, open_node
from .failure import CommandError, cannot_listen
from .option_types import port, seconds

if TYPE_CHECKING:
    from rosproto.gateway.foxglove import Foxglove

__all__ = [
    "add_arguments",
    "add_server_options",
    "announced",
    "run",
    "serve",
    "server_options",
    "until_interrupted",
]

VIEWERS = ("https://app.foxglove.dev", "file://")
"""Foxglove's own page, and what desktop programs say: they may connect, as this command is run for them."""
STEP = 0.5  # s; Windows delivers no Ctrl-C to a thread in an endless wait


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Which graph, where to listen, what is open."""
    add_graph_options(parser, as_json=False)
    add_server_options(parser)


def add_server_options(parser: argparse.ArgumentParser) -> None:
    """What this and `woosh foxglove` share."""
    parser.add_argument(
        "--bind",
        default="127.0.0.1",
        metavar="ADDRESS",
        help="address to listen on; this computer alone by default; with another one, a token is asked for",
    )
    parser.add_argument("--port", type=port, default=8765, help="port, 0 for a free one (default: 8765)")
    parser.add_argument("--token", help="viewers have to give it: ws://...?token=T")
    parser.add_argument("--tls-cert", type=Path, metavar="FILE", help="certificate (PEM), for wss://")
    parser.add_argument("--tls-key", type=Path, metavar="FILE", help="its key (PEM)")
    parser.add_argument(
        "--origin",
        action="append",
        default=[],
        metavar="URL",
        help="let a web page of this origin connect, such as https://lichtblick.example.org",
    )
    parser.add_argument("--allow", action="append", metavar="PATTERN", help="show only these names")
    parser.add_argument("--deny", action="append", default=[], metavar="PATTERN", help="but not these")
    parser.add_argument(
        "--allow-write",
        action="append",
        default=[],
        metavar="PATTERN",
        help="let viewers publish, call or set what matches: /name, /space/*, topic:/x, service:/x, param:/x",
    )
    parser.add_argument("--read-only", action="store_true", help="refuse all of that in any case")
    parser.add_argument(
        "--assets",
        action="append",
        type=Path,
        default=[],
        metavar="FOLDER",
        help="a folder with packages: meshes and textures for package:// (also $ROS_PACKAGE_PATH)",
    )
    parser.add_argument(
        "--for", dest="seconds", type=seconds, metavar="S", help="end after this many seconds"
    )


def server_options(arguments: argparse.Namespace, *, write: Sequence[str] = ()) -> dict[str, Any]:
    """What `Foxglove` is to be made with.

    Args:
        arguments: Of the command line.
        write: Patterns besides those of --allow-write.
    """
    from rosproto.gateway.access import Access, is_loopback_host

    token = arguments.token
    if token is None and not is_loopback_host(arguments.bind):
        token = secrets.token_urlsafe(18)
    folders = [*arguments.assets, *filter(None, os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep))]
    return {
        "host": arguments.bind,
        "port": arguments.port,
        "access": Access(
            allow=arguments.allow or ("*",),
            deny=arguments.deny,
            write=[*arguments.allow_write, *write],
            read_only=arguments.read_only,
        ),
        "tls": _tls(arguments),
        "origins": (*VIEWERS, *arguments.origin),
        "token": token,
        "assets": folders,
    }


def _tls(arguments: argparse.Namespace) -> ssl.SSLContext | None:
    if arguments.tls_cert is None and arguments.tls_key is None:
        return None
    if arguments.tls_cert is None:
        raise CommandError("--tls-key needs --tls-cert, too")
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    try:
        context.load_cert_chain(arguments.tls_cert, arguments.tls_key)
    except (OSError, ssl.SSLError) as problem:
        raise CommandError(f"--tls-cert {arguments.tls_cert}: it cannot be used: {problem}") from problem
    return context


@contextmanager
def serve(node: Any, options: dict[str, Any], **more: Any) -> Iterator[Foxglove]:
    """A server at a node, with errors as a command tells them.

    Raises:
        CommandError: The extra is not installed, or the address cannot be listened on.
    """
    import logging

    from rosproto.gateway.foxglove import Foxglove

    # What the SDK logs of clients that hang up is for those who ask for logs (-v).
    logging.getLogger("foxglove").addHandler(logging.NullHandler())
    try:
        server = Foxglove(node, **options, **more)
    except ImportError as problem:
        raise CommandError(str(problem)) from problem
    except ConnectionLost as problem:
        # Nobody is out of reach: this computer does not let us listen there.
        raise CommandError(cannot_listen(problem, "--bind")) from problem
    with server:
        yield server


def announced(server: Foxglove, options: dict[str, Any]) -> list[str]:
    """What is said when it serves: the address, what is open, where to look."""
    token = options["token"]
    url = server.url + (f"?token={quote(token, safe='')}" if token is not None else "")
    access = options["access"]
    opened = f"writing: {', '.join(access.write)}" if access.writes_anything else "read only"
    hint = "" if access.writes_anything or access.read_only else "; --allow-write PATTERN opens more"
    page = f"https://app.foxglove.dev/?ds=foxglove-websocket&ds.url={quote(url, safe='')}"
    return [
        f"Serving Foxglove at {url} ({opened}{hint})",
        f"open:  {page}",
        "or in Foxglove or Lichtblick: Open connection, Foxglove WebSocket, and that address",
    ]


def until_interrupted(server: Foxglove, limit: float | None) -> None:
    """Wait for Ctrl-C, the end of the time given, or of the node.

    Raises:
        CommandError: The node was ended by somebody else.
    """
    end = None if limit is None else time.monotonic() + limit
    while end is None or time.monotonic() < end:
        if server.node.wait(STEP if end is None else max(0.0, min(STEP, end - time.monotonic()))):
            raise CommandError(f"the node was ended: {server.node.close_reason or 'closed'}")


def run(arguments: argparse.Namespace) -> int:
    """Serve until interrupted."""
    options = server_options(arguments)
    with ExitStack() as stack:
        stack.enter_context(interrupt_on_signals())
        node = stack.enter_context(open_node(arguments, "foxglove"))
        server = stack.enter_context(serve(node, options))
        for line in announced(server, options):
            print(line, flush=True)
        try:
            until_interrupted(server, arguments.seconds)
        except KeyboardInterrupt:
            pass  # the orderly end of this command
    return 0
