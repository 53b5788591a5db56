"""Commands that move the robot with a goal, and `woosh stop`."""

from __future__ import annotations

import math
import re
from argparse import SUPPRESS, ArgumentParser, Namespace
from typing import TYPE_CHECKING

from rosproto.cli import degrees, metres, natural, positive, whole_from
from rosproto.errors import RosTimeout
from rosproto.sentence import say
from woosh_pure.cli.arguments import (
    POSE,
    add_timeout,
    mark_missing,
    marks_here,
    pose_of,
    word_of,
)
from woosh_pure.cli.connection import connect
from woosh_pure.cli.follow_goal import follow, report
from woosh_pure.cli.output import Output
from woosh_pure.enums import Direction, TaskCommand, TaskType
from woosh_pure.errors import ChassisError
from woosh_pure.geometry import Pose2D
from woosh_pure.values.state import Battery

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis


def add_goto(parser: ArgumentParser) -> None:
    parser.add_argument("mark", nargs="?", help="a mark of the chassis's map, or a place of your list")
    parser.add_argument("more", nargs="*", help=SUPPRESS)  # for a helpful error
    parser.add_argument("--pose", nargs=3, metavar=POSE, help="m, m and degrees")
    add_timeout(parser)


def run_goto(args: Namespace, out: Output) -> int:
    if args.mark and re.fullmatch(r"-?[\d.]+(,-?[\d.]+)+", args.mark):
        args.more = [*args.mark.split(",")[1:], *args.more]
        args.mark = args.mark.partition(",")[0]
    if args.more:
        raise ValueError(_several([args.mark, *args.more]))
    if args.mark is None and args.pose is None:
        raise ValueError(mark_missing(args, "give a mark or --pose X Y DEGREES"))
    if args.mark is not None and args.pose is not None:
        raise ValueError("give a mark or --pose X Y DEGREES, and not both")
    target = pose_of(args.pose) if args.pose else _place(args, out)
    with connect(args, out) as chassis:
        where = target if args.mark is None else say("mark {name}", name=args.mark)
        if target is None:
            handle = chassis.go_to_mark(args.mark)
        else:
            handle = chassis.go_to(target.x, target.y, target.yaw)  # type: ignore[assignment]
        outcome = follow(handle, out, say("going to {where}", where=where), args.timeout)
        here = chassis.pose.latest
        out.line("now at {where}", where=here or say("a pose that was not heard"))
        return report(outcome, out, pose=here)


def _place(args: Namespace, out: Output) -> Pose2D | None:
    """Return the pose of a place in the user's list; None for marks of the chassis, as those of --sim are."""
    try:
        mark = marks_here(args).get(args.mark)
    except (OSError, ValueError) as error:
        out.line("no marks: {error}", error=error)
        return None
    return None if mark is None or mark.on_chassis else mark.pose


def _several(words: list[str]) -> str:
    """Return the hint for several words: numbers are a pose, others a name without quotes."""
    try:
        numbers = [read(word) for read, word in zip((metres, metres, degrees), words, strict=False)]
    except ValueError:
        return say("a mark is one word; quote it: woosh goto '{words}'", words=" ".join(words))
    missing = ["DEGREES"] if len(numbers) == 2 else []
    return say("for a pose write: woosh goto --pose {words}", words=" ".join([*words[:3], *missing]))


_TASK_KINDS = {
    "pick": "drive to a mark or along poses",
    "park": "drive to a parking mark",
    "charge": "drive to a charger and charge",
    "carry": "drive to a mark and load or unload there",
}
_TASK_COMMANDS = {
    "pause": "hold the running task, whoever started it",
    "resume": "go on with it",
    "cancel": "end it",
    "interrupt-wait": "end the wait it is in",
}


def add_task(parser: ArgumentParser) -> None:
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    for kind, text in _TASK_KINDS.items():
        _add_task_kind(verbs.add_parser(kind, help=text, description=text), carry=kind == "carry")
    for command, text in _TASK_COMMANDS.items():
        sub = verbs.add_parser(command, help=text, description=text)
        sub.add_argument(
            "--id", type=whole_from(0, 2**63 - 1), metavar="N", help="number of the task (the running one)"
        )


def _add_task_kind(parser: ArgumentParser, *, carry: bool) -> None:
    parser.add_argument("mark", nargs="?", default="", help="name of the mark, as on the chassis's map")
    parser.add_argument(
        "--pose",
        nargs=3,
        action="append",
        default=[],
        metavar=POSE,
        help="m, m and degrees; repeat it for a path, with or without a mark at its end",
    )
    if carry:
        direction = parser.add_mutually_exclusive_group(required=True)
        direction.add_argument("--load", action="store_true", help="take something")
        direction.add_argument("--unload", action="store_true", help="put something down")
    parser.add_argument(
        "--type-number", type=natural, default=0, metavar="N", help="the project's number (0)"
    )
    parser.add_argument(
        "--custom", type=whole_from(-128, 127), default=0, metavar="N", help="the project's byte (0)"
    )
    add_timeout(parser)


def run_task(args: Namespace, out: Output) -> int:
    if args.verb in _TASK_COMMANDS:
        with connect(args, out) as chassis:
            return _task_command(chassis, args, out)

    if not args.mark and not args.pose:
        raise ValueError(mark_missing(args, "give a mark or --pose X Y DEGREES"))
    direction = Direction.UNDEFINED
    if args.verb == "carry":
        direction = Direction.LOAD if args.load else Direction.UNLOAD
    with connect(args, out) as chassis:
        handle = chassis.task(
            TaskType[word_of(args.verb)],
            args.mark,
            poses=[pose_of(values) for values in args.pose],
            direction=direction,
            type_number=args.type_number,
            custom=args.custom,
            timeout=args.timeout,
        )
        where = args.mark or pose_of(args.pose[-1])
        text = say("{verb} {where} (task {id})", verb=say(args.verb), where=where, id=handle.task_id)
        outcome = follow(handle, out, text, args.timeout)
        return report(outcome, out, task_id=handle.task_id)


def _task_command(chassis: Chassis, args: Namespace, out: Output) -> int:
    from woosh_pure.chassis import components_of

    task_id = args.id
    if task_id is None:
        try:
            status = chassis.status.wait(2.0, new=False)
        except RosTimeout as error:
            raise ChassisError(
                "the running task is not known (/robot_status is sent on change only); give --id"
            ) from error
        task_id = status.task_id
    command = TaskCommand[word_of(args.verb)]
    with out.working(say("asking to {verb}", verb=say(args.verb))):
        reply = components_of(chassis).clients.exec_task(command, task_id, timeout=10.0)
    text = say(reply.message or ("done" if reply.success else "no reason given"))
    template = "{verb} task {id}: {answer}" if reply.success else "{verb} task {id}: REFUSED: {answer}"
    out.line(template, verb=say(args.verb), id=task_id, answer=text)
    out.result({"ok": bool(reply.success), "task_id": task_id, "message": reply.message})
    return 0 if reply.success else 3


def add_charge(parser: ArgumentParser) -> None:
    parser.add_argument("mark", nargs="?", help="name of the charger's mark, as on the chassis's map")
    add_timeout(parser)


def run_charge(args: Namespace, out: Output) -> int:
    if args.mark is None:
        raise ValueError(mark_missing(args, "give the mark of a charger"))
    with connect(args, out) as chassis:
        handle = chassis.charge(args.mark, timeout=args.timeout)
        outcome = follow(handle, out, say("going to charge at {mark}", mark=args.mark), args.timeout)
        battery = _charging_battery(chassis)
        if battery is not None:
            out.line("battery {percent} %, {charge}", percent=battery.percent, charge=battery.charge_status)
        return report(outcome, out, battery=battery)


def _charging_battery(chassis: Chassis) -> Battery | None:
    """Wait for the battery to report charging; it reports later than the task."""
    try:
        return chassis.battery.wait_for(lambda battery: battery.charging, 3.0)
    except RosTimeout:
        return chassis.battery.latest


def add_move(parser: ArgumentParser) -> None:
    parser.add_argument("metres", type=metres, help="at most 10")
    parser.add_argument(
        "--speed", type=positive, default=0.0, metavar="M/S", help="default: the chassis's 0.2"
    )
    parser.add_argument("--left", action="store_true", help="sideways to the left (omnidirectional bases)")
    parser.add_argument("--no-avoid", action="store_true", help="switch obstacle avoidance off for this move")


def run_move(args: Namespace, out: Output) -> int:
    from woosh_pure.motion.steps import Step, check_steps

    check_steps([Step.straight(args.metres)])  # before a master is asked
    with connect(args, out) as chassis:
        verb = chassis.strafe if args.left else chassis.move
        handle = verb(args.metres, speed=args.speed, avoid=not args.no_avoid)
        text = say("moving {metres:g} m", metres=args.metres)
        return report(follow(handle, out, text, handle.default_timeout), out)


def add_rotate(parser: ArgumentParser) -> None:
    parser.add_argument("degrees", type=degrees, help="at most 3600")
    parser.add_argument(
        "--speed", type=positive, default=0.0, metavar="DEG/S", help="default: the chassis's 5.7"
    )
    parser.add_argument("--no-avoid", action="store_true", help="switch obstacle avoidance off for this move")


def run_rotate(args: Namespace, out: Output) -> int:
    from woosh_pure.motion.steps import Step, check_steps, radians_of

    check_steps([Step.turn(radians_of(args.degrees))])  # before a master is asked
    with connect(args, out) as chassis:
        handle = chassis.rotate(
            args.degrees,
            degrees=True,
            speed=math.radians(args.speed),
            avoid=not args.no_avoid,
        )
        text = say("turning {degrees:g}°", degrees=args.degrees)
        return report(follow(handle, out, text, handle.default_timeout), out)


def add_stop(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--end-drivers",
        action="store_true",
        help="also ask other programs that can send velocities to end (not the robot's own)",
    )
    parser.add_argument("--timeout", type=positive, default=5.0, metavar="S", help="to confirm the stop (5)")


def run_stop(args: Namespace, out: Output) -> int:
    from dataclasses import asdict

    with connect(args, out) as chassis:
        # Other processes started the motion.
        with out.working("stopping"):
            report = chassis.stop(everything=True, end_drivers=args.end_drivers, timeout=args.timeout)
        out.line(str(report))
        out.result(asdict(report))
        return 0 if report.standing else 1
