"""`woosh task`: run a task, or control the running one."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from rosproto.cli import whole
from rosproto.sentence import say
from woosh_pure.cli.arguments import POSE, add_timeout, mark_missing, natural, number, pose, word_of
from woosh_pure.cli.connection import connect
from woosh_pure.cli.drive_line import DriveLine
from woosh_pure.cli.follow_goal import follow, report
from woosh_pure.cli.output import Output
from woosh_pure.enums import Direction, TaskCommand, TaskType
from woosh_pure.errors import ChassisError

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis

HELP = "run a task (pick, park, charge, carry), or pause, resume, cancel the running one"
_KINDS = {
    "pick": "drive to a mark or along poses",
    "park": "drive to a parking mark",
    "charge": "drive to a charger and charge",
    "carry": "drive to a mark and load or unload there",
}
_COMMANDS = {
    "pause": "hold the running task, whoever started it",
    "resume": "go on with it",
    "cancel": "end it",
    "interrupt-wait": "end the wait it is in",
}


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    for kind, text in _KINDS.items():
        _add_kind(verbs.add_parser(kind, help=text, description=text), carry=kind == "carry")
    for command, text in _COMMANDS.items():
        sub = verbs.add_parser(command, help=text, description=text)
        sub.add_argument("--id", type=whole, metavar="N", help="number of the task (the running one)")


def _add_kind(parser: ArgumentParser, *, carry: bool) -> None:
    parser.add_argument("mark", nargs="?", default="", help="name of the mark, as on the chassis's map")
    parser.add_argument(
        "--pose",
        nargs=3,
        type=number,
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
    parser.add_argument("--custom", type=whole, default=0, metavar="N", help="the project's byte (0)")
    add_timeout(parser)


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    if args.verb in _COMMANDS:
        with connect(args, out) as chassis:
            return _command(chassis, args, out)

    if not args.mark and not args.pose:
        raise ValueError(mark_missing(args, "give a mark or --pose X Y DEGREES"))
    direction = Direction.UNDEFINED
    if args.verb == "carry":
        direction = Direction.LOAD if args.load else Direction.UNLOAD
    with connect(args, out) as chassis:
        line = DriveLine(chassis, pose(args.pose[-1]) if args.pose else None)
        handle = chassis.task(
            TaskType[word_of(args.verb)],
            args.mark,
            poses=[pose(values) for values in args.pose],
            direction=direction,
            type_number=args.type_number,
            custom=args.custom,
            timeout=args.timeout,
        )
        where = args.mark or pose(args.pose[-1])
        told = say("{verb} {where} (task {id})", verb=say(args.verb), where=where, id=handle.task_id)
        outcome = follow(handle, out, told, args.timeout, line)
        return report(outcome, out, task_id=handle.task_id)


def _command(chassis: Chassis, args: Namespace, out: Output) -> int:
    from rosproto.errors import RosTimeout
    from woosh_pure.values.messages import service_type

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
    service = chassis.node.service_client("/exec_task", service_type("woosh_msgs/ExecTask"))
    with out.working(say("asking to {verb}", verb=args.verb)):
        reply = service.call(task_exect=int(command), task_id=task_id, timeout=10.0)
    text = say(reply.message or ("done" if reply.success else "no reason given"))
    told = "{verb} task {id}: {answer}" if reply.success else "{verb} task {id}: REFUSED: {answer}"
    out.line(say(told, verb=args.verb, id=task_id, answer=text))
    out.result({"ok": bool(reply.success), "task_id": task_id, "message": reply.message})
    return 0 if reply.success else 3
