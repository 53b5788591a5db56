"""`woosh run`: a program written for rospy, at a chassis or at a simulated one."""

from __future__ import annotations

import atexit
from argparse import ArgumentParser, Namespace

from woosh_pure.cli.connection import chosen
from woosh_pure.cli.output import Output


def add_run(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--mark",
        metavar="NAME=X,Y,YAW",
        action="append",
        default=[],
        help="with --sim: a mark of yours, in m, m and degrees (repeat for more)",
    )
    parser.add_argument(
        "--marks",
        metavar="FILE",
        action="append",
        default=[],
        help="with --sim: marks from a list as `woosh marks` keeps it",
    )
    parser.add_argument("program", help="a Python file written for rospy")
    parser.add_argument("arguments", nargs="...", help="the program's arguments").required = False


def run_run(args: Namespace, out: Output) -> int:
    if (args.mark or args.marks) and not args.sim:
        raise ValueError("--mark and --marks are for --sim: a real chassis has its own marks")
    from rosproto.rospy import run_at

    address, own = (None, args.host) if args.sim else chosen(args)
    return run_at(
        lambda: _simulated(args) if args.sim else address,
        args.program,
        args.arguments,
        own_address=own,
        msg_path=args.msg_path or (),
        resolve=args.resolve or (),
    )


def _simulated(args: Namespace) -> str:
    """Start a simulated chassis that runs until the program ends; return the URI of its master."""
    from woosh_pure.sim import SimulatedChassis
    from woosh_pure.sim.site import site_of

    if args.master or args.chassis:
        raise ValueError("--sim and an address contradict each other; give one of them")
    simulated = SimulatedChassis(site=site_of(None, args.mark, args.marks), speed=args.sim_speed or 1.0)
    simulated.__enter__()
    atexit.register(simulated.close)
    return simulated.master_uri
