"""`woosh ready`: whether the chassis can move now (yes, no, not known), with reasons."""

from __future__ import annotations

import time
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from rosproto.errors import RosTimeout
from rosproto.sentence import say
from woosh_pure.cli.arguments import seconds
from woosh_pure.cli.connection import connect
from woosh_pure.cli.exit_codes import READY
from woosh_pure.cli.output import Output
from woosh_pure.cli.readiness import as_json, is_there, readiness_of, verdict

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis

HELP = "say whether it would move now, and why not (exit code 3: not ready; 5: not known)"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument(
        "--listen", type=seconds, default=1.0, metavar="S", help="seconds to listen before judging (1)"
    )
    parser.add_argument("--wait", type=seconds, metavar="S", help="wait so long until the answer is yes")


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    from rosproto.transport import Deadline

    with connect(args, out) as chassis:
        chassis.readiness()  # subscribes
        deadline = Deadline(args.listen)
        with out.working("listening"):
            while not (deadline.expired or (chassis.status.heard and chassis.battery.heard)):
                time.sleep(0.02)
            if args.wait is not None:
                _wait(chassis, args.wait)
        readiness = readiness_of(chassis)
    answer = readiness.answer.value
    out.line(say("{head}: {tail}", head=verdict(readiness, out), tail=readiness.sentence()))
    out.result({"ready": as_json(readiness), "answer": answer, "reasons": list(readiness.reasons)})
    return READY[answer]


def _wait(chassis: Chassis, longest: float) -> None:
    from rosproto.transport import Deadline

    deadline = Deadline(longest)
    while not (is_there(chassis) or deadline.expired):
        time.sleep(0.1)
    try:
        chassis.wait_until_ready(deadline.remaining(), known=True)
    except RosTimeout:
        pass  # the caller reports blocked or unknown
