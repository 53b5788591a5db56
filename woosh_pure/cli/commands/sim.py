"""`woosh sim`: a simulated chassis for other programs, until interrupted."""

from __future__ import annotations

import time
from argparse import ArgumentParser, Namespace
from pathlib import Path

from ..output import Output

HELP = "run a simulated chassis until interrupted"


def add_arguments(parser: ArgumentParser) -> None:
    """See `registry`."""
    parser.add_argument("--port", type=int, default=11311, help="port of its own master (11311; 0: any)")
    parser.add_argument("--bind", default="127.0.0.1", metavar="ADDRESS", help="address to be reached at")
    parser.add_argument("--speed", type=float, default=1.0, help="simulated seconds per second")
    parser.add_argument("--seed", type=int, default=0, help="of everything random")
    parser.add_argument(
        "--map", type=Path, metavar="YAML", help="a map_server map instead of the built-in hall"
    )
    parser.add_argument("--omni", action="store_true", help="an omnidirectional base")
    parser.add_argument("--lost", action="store_true", help="switched on without knowing its position")
    parser.add_argument("--latch-status", action="store_true", help="latch /robot_status")
    parser.add_argument("--stops-on-silence", action="store_true", help="stop when velocity messages end")
    parser.add_argument("--for", dest="seconds", type=float, metavar="S", help="end after so many seconds")


def run(args: Namespace, out: Output) -> int:
    """See `registry`."""
    from woosh_pure.geometry import Pose2D
    from woosh_pure.gridmap import GridMap
    from woosh_pure.sim import Settings, SimulatedChassis, Site
    from woosh_pure.sim.body import BodyLimits

    settings = Settings(
        seed=args.seed,
        located=not args.lost,
        limits=BodyLimits(omnidirectional=args.omni),
        on_silence="stop" if args.stops_on_silence else "keep",
    )
    site = Site(GridMap.load(args.map), {}, Pose2D(0.0, 0.0)) if args.map else None
    sim = SimulatedChassis(
        master_uri=args.master,
        host=args.bind,
        port=args.port,
        speed=args.speed,
        site=site,
        settings=settings,
        latch_status=args.latch_status,
    )
    with sim:
        out.line(f"simulated chassis at {sim.master_uri}, {args.speed:g} times real time; Ctrl-C ends it")
        out.line(f"marks: {', '.join(sim.world.site.marks) or 'none'}")
        out.line(f"try:   woosh --master {sim.master_uri} status")
        out.result({"master_uri": sim.master_uri, "marks": sorted(sim.world.site.marks)})
        end = None if args.seconds is None else time.monotonic() + args.seconds
        while end is None or time.monotonic() < end:
            time.sleep(0.1)
    return 0
