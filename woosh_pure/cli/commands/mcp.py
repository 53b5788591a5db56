"""`woosh mcp`: tools for an assistant, over stdio or HTTP."""

from __future__ import annotations

import sys
import time
from argparse import ArgumentParser, Namespace
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from rosproto.cli import add_token, host, is_terminal, port, positive, token_of
from rosproto.sentence import say
from woosh_pure.cli.arguments import add_watchdog, marks_here
from woosh_pure.cli.connection import connect, watchdog_of
from woosh_pure.cli.output import Output

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis
    from woosh_pure.mcp import Limits

TOKEN_VARIABLE = "WOOSH_MCP_TOKEN"
PORT = 8765


def add_limits(parser: ArgumentParser, prefix: str = "") -> None:
    """Add the options of what an assistant may do."""

    def add(name: str, **more: object) -> None:
        parser.add_argument(f"--{prefix}{name}", dest=f"mcp_{name.replace('-', '_')}", **more)  # type: ignore[arg-type]

    add("allow-motion", action="store_true", help="let an assistant move the robot; a person must watch")
    add("only-marks", action="store_true", help="it may drive to known marks only")
    add(
        "area",
        type=Path,
        metavar="FILE",
        help="it may drive inside a polygon only: a line X,Y for each corner, m",
    )
    add("max-distance", type=positive, metavar="M", help="at most so far from where a motion begins")
    add("max-speed", type=positive, metavar="V", help="m/s; a faster motion is ended")
    add("max-seconds", type=positive, default=120.0, metavar="S", help="a longer motion is ended (120)")
    add(
        "confirm",
        choices=("always", "when-possible", "never"),
        default="always",
        help="ask a person before each motion (always: who cannot be asked may not move)",
    )


def limits_of(args: Namespace) -> Limits:
    """The limits of the options."""
    from woosh_pure.mcp import Limits
    from woosh_pure.mcp.limits import area_of

    area = ()
    if args.mcp_area is not None:
        try:
            area = area_of(args.mcp_area.read_text("utf-8"))
        except ValueError as error:
            raise ValueError(say("{file}: {error}", file=args.mcp_area, error=error)) from error
    return Limits(args.mcp_only_marks, area, args.mcp_max_distance, args.mcp_max_speed, args.mcp_max_seconds)


def add_mcp(parser: ArgumentParser) -> None:
    add_limits(parser)
    parser.add_argument(
        "--http",
        nargs="?",
        type=port,
        const=PORT,
        metavar="PORT",
        help=f"serve over HTTP instead of stdio ({PORT})",
    )
    parser.add_argument(
        "--bind", type=host, default="127.0.0.1", metavar="ADDRESS", help="address to listen on (127.0.0.1)"
    )
    add_token(parser, TOKEN_VARIABLE, "what clients over HTTP have to know; needed off this computer")
    parser.add_argument(
        "--recordings", type=Path, metavar="FOLDER", help="folder of bags whose names are listed"
    )
    add_watchdog(parser)


def run_mcp(args: Namespace, out: Output) -> None:
    from rosproto.admission import AdmissionPolicy
    from woosh_pure.mcp import require

    require()
    limits = limits_of(args)
    if args.http is None:  # stdout carries the protocol, and nothing else
        out = Output(stream=sys.stderr, language=out.language)
        if is_terminal(sys.stdin):
            out.line(
                "an assistant starts this command and speaks to it; see docs/assistant.md. Ctrl-C ends it"
            )
    else:
        AdmissionPolicy(token_of(args, TOKEN_VARIABLE)).require_token_at(args.bind)
    with ExitStack() as stack:
        watchdog = stack.enter_context(watchdog_of(args))
        chassis = stack.enter_context(connect(args, out, watchdog=watchdog))
        (_http if args.http is not None else _stdio)(args, out, chassis, limits)


def _stdio(args: Namespace, out: Output, chassis: Chassis, limits: Limits) -> None:
    from woosh_pure.mcp import server

    server(
        {"sim" if args.sim else "robot": chassis},
        limits=limits,
        allow_motion=args.mcp_allow_motion,
        confirm=args.mcp_confirm,
        marks=marks_here(args).values(),
        recordings=args.recordings,
    ).run("stdio")


def _http(args: Namespace, out: Output, chassis: Chassis, limits: Limits) -> None:
    from woosh_pure.mcp import robots
    from woosh_pure.mcp.server import alone, mount
    from woosh_pure.web.access import AccessRules
    from woosh_pure.web.context import WebContext
    from woosh_pure.web.server import WebServer

    made = robots({"sim" if args.sim else "robot": chassis}, marks_here(args).values(), args.recordings)
    access = AccessRules(token_of(args, TOKEN_VARIABLE), (), [args.bind])
    app = alone(WebContext(made, access, allow_driving=False, max_viewers=1))
    mount(app, limits, allow_motion=args.mcp_allow_motion, confirm=args.mcp_confirm)
    with WebServer(app, bind=args.bind, port=args.http) as server:
        out.line("for assistants: {url}mcp", url=server.url)
        out.record({"url": f"{server.url}mcp", "port": server.port})
        while server.running:
            time.sleep(0.1)
