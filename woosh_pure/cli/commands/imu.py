"""`woosh imu`."""

from __future__ import annotations

import math
from argparse import ArgumentParser, Namespace

from rosproto.sentence import say
from woosh_pure.cli.arguments import add_wait, count, wait_for
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output
from woosh_pure.geometry import yaw_from_quaternion
from woosh_pure.values.state import Imu

HELP = "show turning rates, accelerations and orientation"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    add_wait(parser)
    parser.add_argument("-n", "--count", type=count, default=1, metavar="N", help="number of readings (1)")


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    with connect(args, out) as chassis:
        for index in range(args.count):
            imu = wait_for(chassis.imu, args, out) if index == 0 else chassis.imu.wait(args.wait)
            _show(imu, out)
            (out.result if args.count == 1 else out.record)(imu)
    return 0


def _show(imu: Imu, out: Output) -> None:

    w, a = imu.angular_velocity, imu.linear_acceleration
    turned = imu.orientation
    yaw = say("none") if turned is None else f"{math.degrees(yaw_from_quaternion(*turned)):.1f}°"
    out.line(
        say(
            "rates {rates} rad/s   acceleration {acceleration} m/s²   yaw {yaw}",
            rates=f"{w[0]:+.3f} {w[1]:+.3f} {w[2]:+.3f}",
            acceleration=f"{a[0]:+.3f} {a[1]:+.3f} {a[2]:+.3f}",
            yaw=yaw,
        )
    )
