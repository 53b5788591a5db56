"""`woosh footprint`: the robot's outline in the navigation."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from rosproto.sentence import say
from woosh_pure.cli.arguments import corners, number
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output
from woosh_pure.geometry import Footprint

HELP = "tell the navigation the robot's outline, for example with a load on it"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    shape = parser.add_mutually_exclusive_group(required=True)
    shape.add_argument("--rectangle", nargs=2, type=number, metavar=("LENGTH", "WIDTH"), help="m")
    shape.add_argument("--circle", type=number, metavar="RADIUS", help="m")
    shape.add_argument(
        "--points",
        metavar="CORNERS",
        help='corners in order, m, in base_link, as one argument: "0.4,0.3 -0.4,0.3 -0.4,-0.3 0.4,-0.3"',
    )
    parser.add_argument("--padding", type=number, default=0.0, metavar="M", help="added outwards (0)")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--local", action="store_true", help="only for avoiding obstacles nearby")
    which.add_argument("--global", dest="global_", action="store_true", help="only for planning")


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    shape = _shape(args)
    with connect(args, out) as chassis, out.working("looking for the navigation"):
        outline = chassis.set_footprint(
            shape, padding=args.padding, local=not args.global_, global_=not args.local
        )
    out.line(
        say(
            "outline of {count} corners: inner radius {inscribed_radius:.3f} m, outer "
            "{circumscribed_radius:.3f} m",
            count=len(outline.points),
            inscribed_radius=outline.inscribed_radius,
            circumscribed_radius=outline.circumscribed_radius,
        )
    )
    out.result({"points": outline.points, "local": not args.global_, "global": not args.local})
    return 0


def _shape(args: Namespace) -> Footprint:

    if args.rectangle:
        return Footprint.rectangle(*args.rectangle)
    if args.circle is not None:
        return Footprint.circle(args.circle)
    return Footprint.from_points(corners(args.points))
