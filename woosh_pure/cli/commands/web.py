"""`woosh web`: the robot in a browser, and a REST API."""

from __future__ import annotations

import io
import socket
import sys
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from rosproto.cli import (
    CommandError,
    add_max_clients,
    add_token,
    host,
    is_terminal,
    never_wait_for_stdout,
    port,
    require_open_files,
    shows_unicode,
    token_of,
)
from rosproto.errors import RosError
from rosproto.sentence import say
from rosproto.transport import is_loopback, local_address_towards, make_uri
from woosh_pure.cli.arguments import (
    add_limits,
    add_watchdog,
    each_chassis,
    limits_of,
    named_host,
    simulated_marks,
)
from woosh_pure.cli.commands.mission import add_webhook, use_webhook
from woosh_pure.cli.connection import connect, reaching, watchdog_of
from woosh_pure.cli.output import Output
from woosh_pure.maps.marks import MarkFile, UserMark, mark_file

if TYPE_CHECKING:
    from fastapi import FastAPI

    from rosproto.watchdog import Watchdog
    from woosh_pure.chassis import Chassis
    from woosh_pure.sim import SimulatedChassis
    from woosh_pure.web.server import WebServer


TOKEN_VARIABLE = "WOOSH_WEB_TOKEN"
AGAIN_SECONDS = 1.0
"""Seconds between two attempts to reach a robot that is off."""


def add_web(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--bind", type=host, default="127.0.0.1", metavar="ADDRESS", help="address to listen on (127.0.0.1)"
    )
    parser.add_argument("--port", type=port, default=8080, help="port to listen on, 0 for a free one (8080)")
    add_token(parser, TOKEN_VARIABLE, "what everybody has to know; needed off this computer")
    parser.add_argument(
        "--allow-driving",
        action="store_true",
        help="let a page drive by velocity, WITHOUT obstacle avoidance; a person must watch",
    )
    parser.add_argument("--no-browser", action="store_true", help="do not open a browser")
    parser.add_argument(
        "--tls-cert", type=Path, metavar="FILE", help="certificate (PEM): https instead of http"
    )
    parser.add_argument("--tls-key", type=Path, metavar="FILE", help="its key, if it is in another file")
    parser.add_argument(
        "--host-name", action="append", default=[], metavar="NAME", help="a further host name of this server"
    )
    parser.add_argument(
        "--origin", action="append", default=[], metavar="URL", help="allow web pages of this origin"
    )
    parser.add_argument(
        "--robot",
        action="append",
        default=[],
        metavar="NAME=HOST",
        help="one more robot, as a further --chassis NAME=HOST",
    )
    marks = "list of marks (default: that of `woosh marks`)"
    parser.add_argument("--marks", type=Path, metavar="FILE", help=marks)
    parser.add_argument("--recordings", type=Path, metavar="FOLDER", help="folder for bags (a temporary one)")
    missions = "folder of missions (default: that of `woosh mission list`)"
    parser.add_argument("--missions", type=Path, metavar="FOLDER", help=missions)
    add_webhook(parser)
    parser.add_argument("--mcp", action="store_true", help="serve assistants, too, at /mcp (extra mcp)")
    add_limits(parser, "mcp-")
    add_max_clients(parser)
    add_watchdog(parser)


def run_web(args: Namespace, out: Output) -> int:
    from rosproto.admission import AdmissionPolicy
    from woosh_pure.web.optional_libraries import require

    require()
    AdmissionPolicy(token_of(args, TOKEN_VARIABLE)).require_token_at(args.bind)  # before a robot is asked
    with ExitStack() as stack:
        watchdog = stack.enter_context(watchdog_of(args))
        robots = connect_all(args, out, stack, watchdog, patient=True)
        simulators = {next(iter(robots)): args.simulator} if args.sim else {}
        server, waiting = stack.enter_context(page_of(robots, args, out, _marks(args, out), simulators))
        if args.allow_driving:
            out.line("a page can drive WITHOUT obstacle avoidance: a person must watch all the time")
        while server.running:
            time.sleep(0.1)
            waiting.try_again()
    return 1


def connect_all(
    args: Namespace, out: Output, stack: ExitStack, watchdog: Watchdog | None, *, patient: bool = False
) -> dict[str, Chassis]:
    """Connect to the chassis of each --chassis and --robot until the end of `stack`; return them by name."""
    more = _further(args)
    first = stack.enter_context(connect(args, out, watchdog=watchdog, patient=patient))
    robots: dict[str, Chassis] = {_first(args, alone=not more): first}
    for name, address in more:
        if name in robots:
            wrong = "two robots are called {name}; give names, as --chassis hall2=192.168.1.20"
            raise ValueError(say(wrong, name=name))
        robots[name] = stack.enter_context(connect(args, out, to=address, watchdog=watchdog, patient=patient))
    return robots


@contextmanager
def page_of(
    robots: dict[str, Chassis],
    args: Namespace,
    out: Output,
    marks: Iterable[UserMark],
    simulators: Mapping[str, SimulatedChassis],
) -> Iterator[tuple[WebServer, _Waiting]]:
    """Serve the page of these robots by the arguments of `woosh web` within the block; print addresses."""
    never_wait_for_stdout()
    require_open_files(args.max_clients)
    from woosh_pure import web
    from woosh_pure.web.server import WebServer

    token = token_of(args, TOKEN_VARIABLE)
    app = web.app(
        robots,
        token=token,
        allow_driving=args.allow_driving or len(simulators) == len(robots),  # not for a real one beside it
        origins=args.origin,
        hosts=[*args.host_name, args.bind],
        marks=marks,
        recordings=args.recordings,
        missions=args.missions,
        max_clients=args.max_clients,
        simulator=simulators,
    )
    if args.mcp:
        from woosh_pure.mcp import require

        require()
        from woosh_pure.mcp.door import mount

        mount(app, limits_of(args), allow_motion=args.mcp_allow_motion, confirm=args.mcp_confirm)
    try:
        server = WebServer(app, bind=args.bind, port=args.port, tls_cert=args.tls_cert, tls_key=args.tls_key)
    except OSError as error:
        if error.filename:  # a file of TLS
            raise
        raise CommandError(error.strerror or str(error)) from error
    for chassis in robots.values():
        use_webhook(chassis.missions, args)
    waiting = _Waiting(app, robots, out)
    with server:
        # A pipe, a log or a browser's command line gets no token that is not on our own command line.
        given = f"#token={args.token}" if args.token else ""
        shown = f"#token={token}" if token and is_terminal(sys.stdout) else given
        out.line("the page: {page}", page=server.url + shown)
        reached, others = _own_address(args.bind), not is_loopback(args.bind)
        for name in robots if len(robots) > 1 else [""] if others else []:
            path = f"robots/{name}/" if name else ""
            page = f"{make_uri(reached, server.port, server.scheme)}{path}{shown}"
            out.line(
                "the page of {name}: {page}" if name else "the page for others: {page}", name=name, page=page
            )
            if others:
                _say_code(page, out)
        out.line("for programs: {url}api/v1/status, {url}openapi.json", url=server.url)
        out.record({"url": server.url, "port": server.port, "robots": list(robots)})
        if not args.no_browser and not out.as_json:
            _open_browser(server.url + given)
        yield server, waiting


def page_arguments(args: Namespace, *words: str) -> Namespace:
    """Return the arguments of `woosh web` for the page of another command, with these."""
    from woosh_pure.cli.entry import parser_for

    return parser_for(["web"]).parse_args(["web", "--port", str(args.page_port), *words])


def _own_address(bind: str) -> str:
    """Return an address at which others reach a server that listens here, of several the usual route's."""
    if bind not in ("0.0.0.0", "::"):
        return bind
    with suppress(RosError):
        return local_address_towards("198.51.100.1", 9)  # one for documentation: nothing is sent to it
    return socket.gethostname()


def _say_code(url: str, out: Output) -> None:
    """Print a QR code on a terminal, where the library for it is installed."""
    if not (is_terminal(sys.stdout) and shows_unicode(sys.stdout)):
        return
    from woosh_pure.web.optional_libraries import segno

    drawn = io.StringIO()
    with suppress(ImportError):
        segno().make(url, error="l", micro=False).terminal(drawn, border=2, compact=True)
    for line in drawn.getvalue().splitlines():
        out.line(line)


class _Waiting:
    """The robots not reached yet: their pages are served, and each is entered once it is reachable."""

    def __init__(self, app: FastAPI, robots: dict[str, Chassis], out: Output) -> None:
        from woosh_pure.chassis import components_of

        self._out = out
        self._served = app.state.context.robots
        self._left = {name: one for name, one in robots.items() if not components_of(one).in_block}
        self._due = 0.0
        for name in self._left:
            self._served[name].unreachable = str(say("it has not answered yet"))
            out.line("{name}: no answer; waiting for it, and serving its page meanwhile", name=name)

    def try_again(self) -> None:
        """Try each robot once a second. Blocks while a robot does not answer."""
        if not self._left or time.monotonic() < self._due:
            return
        for name, chassis in list(self._left.items()):
            try:
                with reaching():
                    chassis.__enter__()
            except RosError as error:
                self._served[name].unreachable = str(error)
                continue
            del self._left[name]
            self._served[name].unreachable = ""
            self._out.line("{name}: connected", name=name)
        self._due = time.monotonic() + AGAIN_SECONDS


def _first(args: Namespace, *, alone: bool) -> str:
    """Return the name of the robot at the plain paths."""
    name, address = next(iter(each_chassis(args)), ("", ""))
    if name or alone or not address:
        return name or ("sim" if args.sim else "robot")
    return _called(address)


def _further(args: Namespace) -> list[tuple[str, str]]:
    """Return name and address of each robot but the first."""
    first, *more = each_chassis(args) or [("", "")]
    if more:
        args.chassis = first[1]  # with several, the first is the default
    for text in getattr(args, "robot", ()):
        name, address = named_host(text)
        if not (name and address):
            raise ValueError(say("--robot {text}: expected NAME=HOST, such as hall2=192.168.1.20", text=text))
        more.append((name, address))
    for name, address in more:
        if not address.strip():
            raise ValueError(
                say(
                    "--chassis {name}: an address is missing, such as {example}=192.168.1.20",
                    name=name,
                    example=name or "hall2",
                )
            )
    return [(name or _called(address), address) for name, address in more]


def _called(address: str) -> str:
    """Return the default name of a robot: its host, and its port unless it is the default."""
    from rosproto.transport import MASTER_PORT
    from woosh_pure.connection.arguments import master_uri_of
    from woosh_pure.robot_api.wire import PORT

    master = urlsplit(master_uri_of(address))
    port = "" if master.port in (None, MASTER_PORT, PORT) else f":{master.port}"
    return f"{master.hostname or address}{port}".replace("%", "-")


def _marks(args: Namespace, out: Output) -> Iterable[UserMark]:
    """Return the marks of the file, the simulated hall or the user's list; the page saves to the file."""

    if args.marks is not None:
        if not args.marks.exists():
            raise ValueError(say("--marks {marks}: there is no such file", marks=args.marks))
        return MarkFile(args.marks)
    if marks := simulated_marks(args):
        return marks.values()
    try:
        return MarkFile(mark_file())
    except (OSError, ValueError) as error:
        out.line("no marks: {error}", error=error)
        return []


def _open_browser(page: str) -> None:
    import threading
    import webbrowser

    threading.Thread(target=webbrowser.open, args=(page,), name="woosh:browser", daemon=True).start()
