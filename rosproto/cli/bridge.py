"""`rosproto bridge`: a rosbridge server, for web pages and programs without ROS."""

from __future__ import annotations

import argparse
import sys
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from rosproto.errors import ConnectionLost, LocalProtocolError
from rosproto.transport.open_files import allow_open_files

from .connection import add_graph_options, open_node
from .failure import CommandError, cannot_listen
from .gateway_options import add_gateway_options, gateway_options, gateway_watchdog, opened, until_interrupted
from .signals import interrupt_on_signals

if TYPE_CHECKING:
    from rosproto.gateway import Rosbridge


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Which graph, where to listen, what is open."""
    add_graph_options(parser, as_json=False)
    add_gateway_options(parser, 9090)
    parser.add_argument(
        "--authenticate",
        action="store_true",
        help="serve a client only after the service /authenticate (rosauth) has accepted its credentials",
    )


def run(arguments: argparse.Namespace) -> int:
    """Serve until interrupted; where it serves is the only thing on stdout."""
    options = {**gateway_options(arguments), "authenticate": arguments.authenticate}
    allow_open_files(4096)
    with ExitStack() as stack:
        stack.enter_context(interrupt_on_signals())
        # A thread that waits for the interpreter gets it after 5 ms by default, and a message passes several.
        stack.callback(sys.setswitchinterval, sys.getswitchinterval())
        sys.setswitchinterval(0.0005)
        watchdog = stack.enter_context(gateway_watchdog(arguments, options["access"]))
        node = stack.enter_context(open_node(arguments, "rosbridge"))
        server = stack.enter_context(_serving(node, {**options, "watchdog": watchdog}))
        token = options["token"]
        url = server.url + (f"/?token={quote(token, safe='')}" if token is not None else "")
        print(f"Serving rosbridge at {url} ({opened(options['access'])})", flush=True)
        try:
            until_interrupted(node, arguments.seconds)
        except KeyboardInterrupt:
            pass  # the orderly end of this command
    return 0


def _serving(node: Any, options: dict[str, Any]) -> Rosbridge:
    from rosproto.gateway import Rosbridge

    try:
        return Rosbridge(node, **options)
    except LocalProtocolError as problem:
        raise CommandError(str(problem)) from problem
    except ConnectionLost as problem:
        # Nobody is out of reach: this computer does not let us listen there.
        raise CommandError(cannot_listen(problem, "--bind")) from problem
