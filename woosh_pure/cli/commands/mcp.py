"""`woosh mcp`: tools for an assistant, over stdio or HTTP."""

from __future__ import annotations

import sys
import threading
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from concurrent.futures import Future, wait
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any

from rosproto.cli import add_token, host, port, token_of
from woosh_pure.cli.arguments import add_limits, add_watchdog, limits_of, marks_here
from woosh_pure.cli.connection import watchdog_of
from woosh_pure.cli.output import Output

TOKEN_VARIABLE, PORT = "WOOSH_MCP_TOKEN", 8766
SLICE = 0.1  # seconds: on Windows a wait cannot be interrupted


def add_mcp(parser: ArgumentParser) -> None:
    add_limits(parser)
    over = f"serve over HTTP instead of stdio, with the extra web, too ({PORT})"
    parser.add_argument("--http", nargs="?", type=port, const=PORT, metavar="PORT", help=over)
    bind = "address to listen on (127.0.0.1)"
    parser.add_argument("--bind", type=host, default="127.0.0.1", metavar="ADDRESS", help=bind)
    add_token(parser, TOKEN_VARIABLE, "what clients over HTTP have to know; needed off this computer")
    bags = "folder of bags whose names and sizes are listed"
    parser.add_argument("--recordings", type=Path, metavar="FOLDER", help=bags)
    add_watchdog(parser)


def run_mcp(args: Namespace, out: Output) -> None:
    from rosproto.admission import AdmissionPolicy
    from woosh_pure.cli.commands.web import connect_all
    from woosh_pure.mcp import require, server

    require()
    limits = limits_of(args)
    if args.http is None:
        out = Output(stream=sys.stderr, language=out.language)  # stdout carries the protocol alone
    else:
        AdmissionPolicy(token_of(args, TOKEN_VARIABLE)).require_token_at(args.bind)
    with ExitStack() as stack:
        watchdog = stack.enter_context(watchdog_of(args))
        robots, marks = connect_all(args, out, stack, watchdog), marks_here(args).values()
        given: Any = {"allow_motion": args.mcp_allow_motion, "confirm": args.mcp_confirm}
        if args.http is None:
            made = server(robots, limits=limits, marks=marks, recordings=args.recordings, **given)
            _serve(partial(made.run, "stdio"))
            return
        from woosh_pure import mcp
        from woosh_pure.mcp.door import alone, mount
        from woosh_pure.web.access import AccessRules
        from woosh_pure.web.context import WebContext
        from woosh_pure.web.server import WebServer

        rules, named = AccessRules(token_of(args, TOKEN_VARIABLE), (), [args.bind]), mcp.robots(robots, marks)
        mount(app := alone(WebContext(named, rules, allow_driving=False, max_viewers=1)), limits, **given)
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
