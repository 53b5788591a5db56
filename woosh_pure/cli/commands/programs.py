"""`woosh run`: a program of the user, for rospy or with `Chassis()`, at a chassis or at a simulated one."""

from __future__ import annotations

import atexit
import subprocess
import sys
import time
from argparse import ArgumentParser, Namespace
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from rosproto.cli import is_terminal, port, signals_ignored
from rosproto.errors import RosTimeout
from woosh_pure.cli.arguments import add_mark_options, simulated_marks
from woosh_pure.cli.connection import chosen, connect, simulated
from woosh_pure.cli.output import Output
from woosh_pure.errors import MotionRefused

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis
    from woosh_pure.sim import SimulatedChassis
    from woosh_pure.web.server import WebServer


def add_run(parser: ArgumentParser) -> None:
    add_mark_options(parser)
    parser.add_argument(
        "--watch",
        action="store_true",
        help="show its robot in a browser; run it again when its file changes, or after the page's reset",
    )
    parser.add_argument("--page-port", type=port, default=8080, metavar="PORT", help="of that page (8080)")
    parser.add_argument("program", help="a Python file that uses woosh_pure or rospy")
    parser.add_argument("arguments", nargs="...", help="the program's arguments").required = False


def run_run(args: Namespace, out: Output) -> int:
    if (args.mark or args.marks) and not args.sim:
        raise ValueError("--mark and --marks are for --sim: a real chassis has its own marks")
    out = Output(stream=sys.stderr, language=out.language)  # stdout is the program's
    if args.watch:
        return _watch(args, out)
    from rosproto.rospy import run_at

    address, own = (None, args.host) if args.sim else chosen(args)
    return run_at(
        lambda: _simulated(args, out) if args.sim else address,
        args.program,
        args.arguments,
        own_address=own,
        msg_path=args.msg_path or (),
        resolve=args.resolve or (),
    )


def _simulated(args: Namespace, out: Output) -> str:
    """Start a simulated chassis that runs until the program ends; return the URI of its master."""
    from woosh_pure.sim.site import site_of

    stack = ExitStack()
    atexit.register(stack.close)
    return simulated(args, out, stack, site=site_of(None, args.mark, args.marks))


def _watch(args: Namespace, out: Output) -> int:
    """Show the robot on a page, and run the program in processes of its own meanwhile."""
    from woosh_pure.cli.commands.web import page_arguments, page_of

    uri = _simulated(args, out) if args.sim else None
    simulator: SimulatedChassis | None = args.simulator if args.sim else None
    page = page_arguments(args, *([] if is_terminal(sys.stderr) else ["--no-browser"]))
    with connect(args, out, to=uri) as chassis:
        # Whatever moves at the end of the program is stopped, so nobody else may have begun it.
        with suppress(RosTimeout):
            if not chassis.measured_velocity.wait(2.0, new=False).is_standing():
                raise MotionRefused("the robot moves already; stop it first: `woosh stop`")
        simulators = {"robot": simulator} if simulator else {}
        marks = simulated_marks(args).values()
        with page_of({"robot": chassis}, page, out, marks, simulators) as (server, _):
            while server.running:
                _run_once(args, chassis, out, server, simulator)
    return 1


def _run_once(
    args: Namespace, chassis: Chassis, out: Output, server: WebServer, simulator: SimulatedChassis | None
) -> None:
    """Run the program until its file changes or the simulation is reset; whenever it ends, stop the robot."""

    def now() -> tuple[object, ...]:
        file = Path(args.program)
        return file.stat().st_mtime_ns if file.exists() else None, simulator and simulator.resets

    options = [f"--msg-path={one}" for one in args.msg_path or ()]
    options += [f"--resolve={one}" for one in args.resolve or ()]
    words = ["rosproto.rospy", "--chassis", chassis.master_uri, *options, args.program, *args.arguments]
    before, ended = now(), False
    process = subprocess.Popen([sys.executable, "-m", *words])
    try:
        while server.running and now() == before:
            time.sleep(0.1)
            if not ended and process.poll() is not None:
                ended = True
                report = chassis.stop(everything=True)
                out.line(
                    "the program has ended with exit code {code}; {report}; it runs again when {file} "
                    "changes, or after a reset on the page; Ctrl-C ends",
                    code=process.returncode,
                    report=report,
                    file=args.program,
                )
    finally:
        with signals_ignored():
            process.terminate()
            try:
                process.wait(3.0)
            except subprocess.TimeoutExpired:
                process.kill()
            if not ended:
                chassis.stop(everything=True)
    if simulator:
        simulator.reset()  # each run begins where the robot was switched on
