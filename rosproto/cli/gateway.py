"""`rosproto bridge` and `rosproto foxglove`: servers for programs without ROS, and their options.

`woosh foxglove` shares the options for address, access and open names.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, TypeVar
from urllib.parse import quote

from rosproto.cli.background_output import never_wait_for_stdout
from rosproto.cli.exit_codes import CommandError, cannot_listen
from rosproto.cli.graph_clients import open_node
from rosproto.cli.graph_options import add_graph_options
from rosproto.cli.options import add_token, count, host, port, seconds, token_of
from rosproto.cli.signals import interrupt_on_signals
from rosproto.errors import ConnectionLost, LocalProtocolError
from rosproto.sentence import say

if TYPE_CHECKING:
    import ssl

    from rosproto.gateway import Access, Foxglove, GatewayLimits, GatewayServer, Rosbridge
    from rosproto.node import Node
    from rosproto.watchdog import Watchdog

S = TypeVar("S", bound="GatewayServer")
TOKEN_VARIABLE = "ROSPROTO_TOKEN"
SPARE_FILES = 200  # for the graph, beside the clients and the connections that are not admitted yet
STEP = 0.5  # s; Windows delivers no Ctrl-C during an endless wait
WEB, DESKTOP = "https://app.foxglove.dev", "file://"
"""Foxglove's own page, and what desktop programs say: they may connect, as this command is run for them.

A browser says "null" for a page from a file, so such a page does not get in as a desktop program. Any link
can lead to the page on the internet with the address of this server in it: it may look, and where something
is open for writing it has to know the token or be named (`--origin`).
"""


class ServerOptions(TypedDict):
    """The arguments of a server that the command line decides."""

    host: str
    port: int
    access: Access
    tls: ssl.SSLContext | None
    origins: tuple[str, ...]
    hosts: tuple[str, ...]
    token: str | None
    limits: GatewayLimits


class _BridgeOptions(ServerOptions):
    authenticate: bool


class FoxgloveOptions(ServerOptions):
    """The arguments of `Foxglove`."""

    assets: list[str | Path]


def add_bridge_arguments(parser: argparse.ArgumentParser) -> None:
    """Which graph, where to listen, what is open."""
    add_graph_options(parser, as_json=False)
    add_gateway_options(parser, 9090)
    parser.add_argument(
        "--authenticate",
        action="store_true",
        help="serve a client only after the service /authenticate (rosauth) has accepted its credentials",
    )
    parser.set_defaults(run=_bridge)


def _bridge(arguments: argparse.Namespace) -> None:
    """Serve until interrupted; stdout has only the address."""
    from rosproto.gateway import Rosbridge

    options: _BridgeOptions = {**gateway_options(arguments), "authenticate": arguments.authenticate}
    interval = sys.getswitchinterval()
    # A message passes several threads; the default switch interval is 5 ms each.
    sys.setswitchinterval(0.0005)
    try:
        _serve(arguments, "rosbridge", Rosbridge, options, _announced)
    finally:
        sys.setswitchinterval(interval)


def _announced(server: Rosbridge, options: ServerOptions, token: str | None) -> list[str]:
    return [serving_line("rosbridge", server, options, token)]


def serving_line(name: str, server: GatewayServer, options: ServerOptions, token: str | None) -> str:
    """Return the first line at the start: the address and the open names; for the token see `shown_token`."""
    url, opened = _url(server, options, token), _opened(options["access"])
    return say("Serving {name} at {url} ({opened})", name=name, url=url, opened=opened)


def add_foxglove_arguments(parser: argparse.ArgumentParser) -> None:
    """Which graph, where to listen, what is open."""
    add_graph_options(parser, as_json=False)
    add_server_options(parser)
    parser.set_defaults(run=_foxglove)


def _foxglove(arguments: argparse.Namespace) -> None:
    from rosproto.gateway import Foxglove

    _serve(arguments, "foxglove", Foxglove, server_options(arguments), announced)


def _serve(
    arguments: argparse.Namespace,
    name: str,
    kind: Callable[..., S],
    options: ServerOptions,
    announced: Callable[[S, ServerOptions, str | None], list[str]],
) -> None:
    """Serve with a new node until interrupted."""
    with (
        interrupt_on_signals(),
        watchdog_if(options["access"].writes_anything and not arguments.no_watchdog) as watchdog,
        open_node(arguments, name) as node,
        serving(kind, node, options, watchdog=watchdog) as server,
    ):
        try:
            for line in announced(server, options, shown_token(arguments, options)):
                print(line, flush=True)
            until_interrupted(node, arguments.seconds)
        except KeyboardInterrupt:
            pass  # the normal end of this command


@contextmanager
def serving(kind: Callable[..., S], node: Node, options: ServerOptions, **more: object) -> Iterator[S]:
    """Run a server at a node, and convert its errors to `CommandError`.

    Raises:
        CommandError: The extra is not installed, or the address cannot be bound.
    """
    try:
        server = kind(node, **options, **more)
    except LocalProtocolError as problem:
        raise CommandError(str(problem)) from problem
    except ConnectionLost as problem:
        # A local error: the address cannot be bound.
        raise CommandError(cannot_listen(problem, "--bind")) from problem
    with server:
        yield server


def shown_token(arguments: argparse.Namespace, options: ServerOptions) -> str | None:
    """Return the server's token, or None if it must not be printed: it is in a file or the environment."""
    kept = os.environ.get(TOKEN_VARIABLE) if arguments.token is None else None
    return None if arguments.token_file is not None or kept else options["token"]


def _url(server: GatewayServer, options: ServerOptions, token: str | None) -> str:
    shown = "..." if token is None else quote(token, safe="")
    return server.url + (f"/?token={shown}" if options["token"] is not None else "")


def announced(server: Foxglove, options: ServerOptions, token: str | None) -> list[str]:
    """Return the lines at the start: the address, the open names, the viewer.

    Args:
        server: It serves.
        options: Of the server.
        token: See `shown_token`.
    """
    url = _url(server, options, token)
    page = f"{WEB}/?ds=foxglove-websocket&ds.url={quote(url, safe='')}"
    if options["token"] is not None and token is None:
        web = say("The token is not shown: put it in place of the dots")
    elif WEB in options["origins"] or "*" in options["origins"]:
        web = say("open:  {page}", page=page)
    else:
        text = "Foxglove's page may not connect where writing is open: add --token T, or --origin {origin}"
        web = say(text, origin=WEB)
    return [
        serving_line("Foxglove", server, options, token),
        web,
        say("In Foxglove or Lichtblick: Open connection, Foxglove WebSocket, and that address"),
    ]


def add_gateway_options(parser: argparse.ArgumentParser, default_port: int) -> None:
    """Add the options for address, token, TLS, origins and patterns."""
    parser.add_argument(
        "--bind",
        type=host,
        default="127.0.0.1",
        metavar="ADDRESS",
        help="address to listen on; this computer alone by default, and with another one a token is needed",
    )
    parser.add_argument(
        "--port", type=port, default=default_port, help=f"port, 0 for a free one (default: {default_port})"
    )
    add_token(parser, TOKEN_VARIABLE, "clients have to give it: ws://...?token=T")
    parser.add_argument("--tls-cert", type=Path, metavar="FILE", help="certificate (PEM), for wss://")
    parser.add_argument("--tls-key", type=Path, metavar="FILE", help="its key (PEM)")
    parser.add_argument(
        "--origin",
        action="append",
        default=[],
        metavar="URL",
        help="let a web page of this origin connect, such as https://robots.example.org",
    )
    parser.add_argument(
        "--host-name",
        action="append",
        default=[],
        metavar="NAME",
        help="a name by which clients may reach this server, besides localhost and addresses",
    )
    add_max_clients(parser)
    parser.add_argument("--allow", action="append", metavar="PATTERN", help="show only these names")
    parser.add_argument("--deny", action="append", default=[], metavar="PATTERN", help="but not these")
    parser.add_argument(
        "--allow-write",
        action="append",
        default=[],
        metavar="PATTERN",
        help="let clients publish, call, set, send goals: /x, /a/*, topic:/x, service:/x, action:/x, api:X",
    )
    parser.add_argument("--read-only", action="store_true", help="never allow any of these")
    parser.add_argument(
        "--message-bytes",
        type=count,
        metavar="N",
        help="largest message of a client in bytes (default: 1048576), with one value or key for every ten",
    )
    parser.add_argument(
        "--no-watchdog",
        action="store_true",
        help="do not start the watchdog process, which sends zero if this one dies while a client drives",
    )
    parser.add_argument(
        "--for", dest="seconds", type=seconds, metavar="S", help="end after this many seconds"
    )


def add_max_clients(parser: argparse.ArgumentParser) -> None:
    """Add --max-clients, of every server; see `require_open_files`."""
    from rosproto.admission import MAX_CLIENTS

    parser.add_argument(
        "--max-clients",
        type=count,
        default=MAX_CLIENTS,
        metavar="N",
        help=f"maximum number of clients (default: {MAX_CLIENTS})",
    )


def require_open_files(clients: int) -> None:
    """Check that the process may open as many files as this number of clients needs.

    Raises:
        CommandError: It may not, and there are more clients than usual.
    """
    from rosproto.admission import MAX_CLIENTS
    from rosproto.transport.os_errors import allow_open_files, open_file_limit

    files = clients + MAX_CLIENTS + SPARE_FILES
    allow_open_files(max(4096, files))
    allowed = open_file_limit()
    if clients > MAX_CLIENTS and allowed is not None and allowed < files:
        text = (
            "--max-clients {clients} needs {files} open files, and the system allows {allowed}: "
            "allow more with `ulimit -n {files}`, or give a smaller number"
        )
        raise CommandError(say(text, clients=clients, files=files, allowed=allowed))


def add_server_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that `woosh foxglove` shares."""
    add_gateway_options(parser, 8765)
    parser.add_argument(
        "--assets",
        action="append",
        type=Path,
        default=[],
        metavar="FOLDER",
        help="a folder with packages: meshes and textures for package:// (also $ROS_PACKAGE_PATH)",
    )


def gateway_options(arguments: argparse.Namespace, *, write: Sequence[str] = ()) -> ServerOptions:
    """Return the arguments of a server; a token is always set beyond this computer.

    Args:
        arguments: Of the command line.
        write: Patterns besides those of --allow-write.

    Raises:
        CommandError: The certificate cannot be used, or the system allows fewer open files than clients.
    """
    never_wait_for_stdout()
    from rosproto.admission import AdmissionPolicy
    from rosproto.gateway import Access
    from rosproto.transport.uri import is_loopback

    token = token_of(arguments, TOKEN_VARIABLE)
    if token is None and not is_loopback(arguments.bind):
        import secrets

        token = secrets.token_urlsafe(18)
    AdmissionPolicy(token, arguments.origin, arguments.host_name)  # refuses them before the master is asked
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
        "origins": tuple(arguments.origin),
        "hosts": tuple(arguments.host_name),
        "token": token,
        "limits": limits_of(arguments.message_bytes, arguments.max_clients),
    }


def server_options(arguments: argparse.Namespace, *, write: Sequence[str] = ()) -> FoxgloveOptions:
    """Return the arguments of `Foxglove`.

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


def limits_of(message_bytes: int | None, clients: int) -> GatewayLimits:
    """Return the limits, in which all clients together cost no more memory than 64 of the usual ones.

    Raises:
        CommandError: The system allows fewer open files.
    """
    from rosproto.gateway import GatewayLimits

    require_open_files(clients)
    usual = GatewayLimits()
    share = min(1.0, usual.connections / clients)
    return usual._replace(
        connections=clients,
        message_bytes=message_bytes or usual.message_bytes,
        message_values=max(usual.message_values, (message_bytes or 0) // 10),
        outbox_bytes=int(usual.outbox_bytes * share),
        topic_bytes=min(usual.topic_bytes, int(usual.outbox_bytes * share)),
        answer_bytes=int(usual.answer_bytes * share),
    )


@contextmanager
def watchdog_if(wanted: bool) -> Iterator[Watchdog | None]:
    """Start the process that stops the robot if this one dies, or yield None."""
    if not wanted:
        yield None
        return
    from rosproto.watchdog import Watchdog

    with Watchdog() as watchdog:
        yield watchdog


def _tls(arguments: argparse.Namespace) -> ssl.SSLContext | None:
    if arguments.tls_cert is None and arguments.tls_key is None:
        return None
    if arguments.tls_cert is None:
        raise CommandError("--tls-key needs --tls-cert, too")
    import ssl

    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    try:
        context.load_cert_chain(arguments.tls_cert, arguments.tls_key)
    except (OSError, ssl.SSLError) as problem:
        text = "--tls-cert {file}: it cannot be used: {problem}"
        raise CommandError(say(text, file=arguments.tls_cert, problem=problem)) from problem
    return context


def _opened(access: Access) -> str:
    """Describe what clients may write."""
    if access.writes_anything:
        return say("writing: {names}", names=list(access.write))
    return say("read only" if access.read_only else "read only: --allow-write PATTERN opens more")


def until_interrupted(node: Node, limit: float | None) -> None:
    """Wait for Ctrl-C, the time limit, or the end of the node.

    Raises:
        CommandError: The node was ended.
    """
    end = None if limit is None else time.monotonic() + limit
    while end is None or time.monotonic() < end:
        if node.wait(STEP if end is None else max(0.0, min(STEP, end - time.monotonic()))):
            raise CommandError(say("the node was ended: {why}", why=node.close_reason or say("closed")))
