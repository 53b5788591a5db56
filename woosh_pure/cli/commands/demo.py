"""`woosh demo`: a tour with the simulated chassis, over real TCP sockets."""

from __future__ import annotations

import math
import time
from argparse import ArgumentParser, Namespace

from rosproto.sentence import say
from woosh_pure.cli.connection import connect
from woosh_pure.cli.drive_line import DriveLine
from woosh_pure.cli.follow_goal import follow
from woosh_pure.cli.output import Output

HELP = "start a simulated chassis and drive it: the first thing to try"
_SPEED = 2.0


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument("--mark", default="A1", help="mark to drive to (default A1)")


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    if args.master or args.chassis:
        raise ValueError("the demo drives only its own simulated chassis; leave --master and --chassis out")
    args.sim = True
    began = time.monotonic()
    from woosh_pure.sim.site import built_in_site

    marks = built_in_site().marks
    if args.mark not in marks:
        raise ValueError(
            say(
                "mark {mark!r} is not in the demo's hall; it has {names}",
                mark=args.mark,
                names=", ".join(marks),
            )
        )
    out.line("woosh demo: a simulated robot; nothing outside this computer moves")
    with connect(args, out, sim_speed=_SPEED) as chassis:
        start = chassis.pose.wait()
        battery = say("the battery has {percent} %", percent=chassis.battery.wait().percent)
        out.line(say("it is at {pose}; {battery}", pose=start, battery=battery))

        line = DriveLine(chassis)
        follow(chassis.move(0.5, speed=0.3), out, "it moves 0.5 m forward", 20.0, line)
        chassis.measured_velocity.wait_for(lambda v: v.is_standing())
        moved = chassis.pose.wait()
        way = start.distance_to(moved)
        out.line(" ", say("asked for 0.500 m, measured {way:.3f} m", way=way))

        line = DriveLine(chassis)
        follow(chassis.rotate(90, degrees=True, speed=0.8), out, "it turns 90° to the left", 20.0, line)
        chassis.measured_velocity.wait_for(lambda v: v.is_standing())
        turned = chassis.pose.wait()
        angle = math.degrees(moved.angle_to(turned))
        out.line(" ", say("asked for 90.0°, measured {angle:.1f}°", angle=angle))

        target = marks[args.mark].pose
        line = DriveLine(chassis, target)
        handle = chassis.go_to_mark(args.mark)
        follow(handle, out, say("it drives to mark {mark}", mark=args.mark), 60.0, line)
        end = chassis.pose.wait()
        off, off_angle = end.distance_to(target), math.degrees(end.angle_to(target))
        out.line(
            " ",
            say(
                "arrived, {millimetres:.0f} mm and {degrees:.1f}° from the mark; driven {metres:.1f} m",
                millimetres=off * 1000,
                degrees=off_angle,
                metres=chassis.odometer.wait(),
            ),
        )
    good = abs(way - 0.5) < 0.05 and abs(angle - 90.0) < 5.0 and off < 0.1 and abs(off_angle) < 5.0
    seconds = time.monotonic() - began
    if good:
        out.line(say("done in {seconds:.0f} s: the software works on this computer", seconds=seconds))
        out.line(say("next, a simulated robot in your browser: {command}", command="woosh --sim web"))
    else:
        out.line(say("FAILED: measured is too far from asked in {seconds:.1f} s", seconds=seconds))
    out.result(
        {
            "ok": good,
            "seconds": round(seconds, 2),
            "moved": {"asked_m": 0.5, "measured_m": round(way, 4)},
            "rotated": {"asked_degrees": 90.0, "measured_degrees": round(angle, 2)},
            "mark": {"name": args.mark, "off_m": round(off, 4), "off_degrees": round(off_angle, 2)},
        }
    )
    return 0 if good else 1
