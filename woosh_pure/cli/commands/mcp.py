"""`woosh mcp`: tools for an assistant, over stdio or HTTP."""

from __future__ import annotations

import sys
import threading
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from concurrent.futures import Future, wait
from contextlib import ExitStack
from pathlib import Path

from rosproto.cli import add_token, host, port, token_of
from woosh_pure.cli.arguments import add_limits, add_watchdog, limits_of, marks_here
from woosh_pure.cli.connection import watchdog_of
from woosh_pure.cli.output import Output

TOKEN_VARIABLE, PORT = "WOOSH_MCP_TOKEN", 8766
SLICE = 0.1  # seconds: on Windows a wait cannot be interrupted


def add_mcp(parser: ArgumentParser) -> None:
    add_limits(parser)
    over = f"serve over HTTP instead of stdio ({PORT})"
    parser.add_argument("--http", nargs="?", type=port, const=PORT, metavar="PORT", help=over)
    bind = "address to listen on (127.0.0.1)"
    parser.add_argument("--bind", type=host, default="127.0.0.1", metavar="ADDRESS", help=bind)
    add_token(parser, TOKEN_VARIABLE, "what clients over HTTP have to know; needed off this computer")
    bags = "folder of bags whose names and sizes are listed"
    parser.add_argument("--recordings", type=Path, metavar="FOLDER", help=bags)
    add_watchdog(parser)


def run_mcp(args: Namespace, out: Output) -> None:
    from rosproto.admission import AdmissionPolicy
    from woosh_pure import mcp
    from woosh_pure.cli.commands.web import connect_all

    mcp.require()
    from woosh_pure.mcp.door import Door, alone
    from woosh_pure.web.access import AccessRules
    from woosh_pure.web.server import WebServer

    limits, token = limits_of(args), token_of(args, TOKEN_VARIABLE)
    if args.http is None:
        out = Output(stream=sys.stderr, language=out.language)  # stdout carries the protocol alone
    else:
        AdmissionPolicy(token).require_token_at(args.bind)
    with ExitStack() as stack:
        watchdog = stack.enter_context(watchdog_of(args))
        chassis = connect_all(args, out, stack, watchdog)
        robots = mcp.robots(chassis, marks_here(args).values(), args.recordings)
        door = Door(robots, limits, allow_motion=args.mcp_allow_motion, confirm=args.mcp_confirm)
        if args.http is None:
            _serve(door.mcp.run)
            return
        app = alone(door, AccessRules(token, (), [args.bind]))
        with WebServer(app, bind=args.bind, port=args.http) as serving:
            out.line("for assistants: {url}mcp", url=serving.url)
            out.record({"url": f"{serving.url}mcp", "port": serving.port})
            while serving.running:
                time.sleep(0.1)


def _serve(run: Callable[[], None]) -> None:
    """Serve in a daemon thread, so that its read of stdin does not keep a process from ending."""
    ended: Future[None] = Future()

    def work() -> None:
        try:
            run()
        except BaseException as error:
            ended.set_exception(error)
        else:
            ended.set_result(None)

    threading.Thread(target=work, name="woosh:mcp", daemon=True).start()
    while not wait([ended], SLICE).done:
        pass
    ended.result()
