"""`woosh localization show|start|stop|pose`."""

from __future__ import annotations

import math
from argparse import ArgumentParser, Namespace

from rosproto.sentence import say
from woosh_pure.cli.arguments import add_pose, add_wait, number, pose, wait_for
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output

HELP = "show, start or stop the localisation, or tell it where the robot is"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    show = verbs.add_parser("show", help="where it believes to be, and how sure it is")
    add_wait(show)
    verbs.add_parser("start", help="start the localisation module")
    verbs.add_parser("stop", help="stop it")
    tell = verbs.add_parser("pose", help="tell it where the robot stands, after power-up for example")
    add_pose(tell)
    tell.add_argument("--deviation", type=number, default=0.25, metavar="M", help="1 sigma (0.25)")
    tell.add_argument("--yaw-deviation", type=number, default=15.0, metavar="DEGREES", help="1 sigma (15)")


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    with connect(args, out) as chassis:
        if args.verb == "show":
            estimate = wait_for(chassis.localization, args, out)
            sigma = [math.sqrt(max(0.0, estimate.covariance[i, i])) for i in (0, 1, 5)]
            out.line(str(estimate.pose))
            deviation = "1 sigma: {x:.3f} m, {y:.3f} m, {yaw:.1f}°"
            out.line(say(deviation, x=sigma[0], y=sigma[1], yaw=math.degrees(sigma[2])))
            out.result({"pose": estimate.pose, "deviation": sigma})
        elif args.verb == "pose":
            if not (args.deviation > 0.0 and args.yaw_deviation > 0.0):
                raise ValueError("a deviation says how sure you are: more than 0")
            where = pose((args.x, args.y, args.degrees))
            with out.working("telling the localisation"):
                chassis.set_pose(
                    where,
                    position_deviation=args.deviation,
                    yaw_deviation=math.radians(args.yaw_deviation),
                )
            out.line(say("told: {where}", where=where))
            out.result({"told": where})
        else:
            with out.working("asking the localisation"):
                chassis.start_localization(args.verb == "start")
            out.line(say("localisation: {verb}", verb=args.verb))
            out.result({"done": args.verb})
    return 0
