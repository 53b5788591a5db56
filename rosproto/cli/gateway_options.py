"""Options of the commands that serve other programs: where to listen, who may connect, what is open."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .background_output import hurry
from .failure import CommandError
from .options import count, host, port, seconds

if TYPE_CHECKING:
    import ssl

    from rosproto.gateway import Access, GatewayLimits
    from rosproto.node import Node
    from rosproto.watchdog import Watchdog


STEP = 0.5  # s; Windows delivers no Ctrl-C to a thread in an endless wait


def add_gateway_options(parser: argparse.ArgumentParser, default_port: int) -> None:
    """Address, token, TLS, origins, patterns."""
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
    parser.add_argument("--token", help="clients have to give it: ws://...?token=T")
    parser.add_argument("--tls-cert", type=Path, metavar="FILE", help="certificate (PEM), for wss://")
    parser.add_argument("--tls-key", type=Path, metavar="FILE", help="its key (PEM)")
    parser.add_argument(
        "--origin",
        action="append",
        default=[],
        metavar="URL",
        help="let a web page of this origin connect, such as https://robots.example.org",
    )
    parser.add_argument("--allow", action="append", metavar="PATTERN", help="show only these names")
    parser.add_argument("--deny", action="append", default=[], metavar="PATTERN", help="but not these")
    parser.add_argument(
        "--allow-write",
        action="append",
        default=[],
        metavar="PATTERN",
        help="let clients publish, call, set or send goals: /name, /space/*, topic:/x, service:/x, action:/x",
    )
    parser.add_argument("--read-only", action="store_true", help="refuse all of that in any case")
    parser.add_argument(
        "--message-bytes",
        type=count,
        metavar="N",
        help="longest message of a client (default: 1048576); one value or key is taken for every ten bytes",
    )
    parser.add_argument(
        "--no-watchdog",
        action="store_true",
        help="no process beside this one that sends zero where a client drives when this one is killed",
    )
    parser.add_argument(
        "--for", dest="seconds", type=seconds, metavar="S", help="end after this many seconds"
    )


def gateway_options(arguments: argparse.Namespace, *, write: Sequence[str] = ()) -> dict[str, Any]:
    """What a server is to be made with; off this computer with a token in any case.

    Args:
        arguments: Of the command line.
        write: Patterns besides those of --allow-write.

    Raises:
        CommandError: The certificate cannot be used.
    """
    hurry()
    from rosproto.gateway import Access
    from rosproto.transport.address import is_loopback

    token = arguments.token
    if token is None and not is_loopback(arguments.bind):
        import secrets

        token = secrets.token_urlsafe(18)
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
        "token": token,
        **({} if arguments.message_bytes is None else {"limits": _limits(arguments.message_bytes)}),
    }


def _limits(message_bytes: int) -> GatewayLimits:
    from rosproto.gateway import GatewayLimits

    usual = GatewayLimits()
    return usual._replace(
        message_bytes=message_bytes, message_values=max(usual.message_values, message_bytes // 10)
    )


@contextmanager
def gateway_watchdog(arguments: argparse.Namespace, access: Access) -> Iterator[Watchdog | None]:
    """The process that sends zero when this one is gone; none where nobody may drive, or nobody wants it."""
    if arguments.no_watchdog or not access.writes_anything:
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
        raise CommandError(f"--tls-cert {arguments.tls_cert}: it cannot be used: {problem}") from problem
    return context


def opened(access: Access) -> str:
    """What clients may write, in words."""
    if access.writes_anything:
        return f"writing: {', '.join(access.write)}"
    return "read only" if access.read_only else "read only: --allow-write PATTERN opens more"


def until_interrupted(node: Node, limit: float | None) -> None:
    """Wait for Ctrl-C, the end of the time given, or of the node.

    Raises:
        CommandError: The node was ended by somebody else.
    """
    end = None if limit is None else time.monotonic() + limit
    while end is None or time.monotonic() < end:
        if node.wait(STEP if end is None else max(0.0, min(STEP, end - time.monotonic()))):
            raise CommandError(f"the node was ended: {node.close_reason or 'closed'}")
