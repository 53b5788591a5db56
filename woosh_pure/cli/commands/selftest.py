"""`woosh selftest`: check this computer, without a robot or a test tool."""

from __future__ import annotations

import time
from argparse import ArgumentParser, Namespace

from rosproto.sentence import say
from woosh_pure.cli.output import Output

HELP = "check that everything works on this machine; needs no robot, moves nothing, takes seconds"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument(
        "--no-ros", action="store_true", help="do not look for a real ROS on this machine, and start nothing"
    )


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    if args.master or args.chassis:
        raise ValueError("the self-test is about this machine alone; for a chassis: woosh doctor")
    from rosproto.selftest import State, run
    from woosh_pure.selftest import CHECKS

    began = time.monotonic()
    outcomes = []
    for outcome in run(check for check in CHECKS if not (args.no_ros and check.name == "ros")):
        outcomes.append(outcome)
        mark = {State.FINE: "green", State.FAILED: "red", State.NOT_HERE: "dim"}[outcome.state]
        word, name = out.colour(outcome.state.value, mark, 9), out.cell(outcome.name, 13)
        out.line(word, name, f"{outcome.seconds:5.2f} s ", outcome.text)
    failed = [outcome.name for outcome in outcomes if outcome.state is State.FAILED]
    seconds = time.monotonic() - began
    if failed:
        out.line(
            say(
                "this machine is not fine: {names} failed ({seconds:.1f} s)",
                names=", ".join(failed),
                seconds=seconds,
            )
        )
    else:
        out.line(say("this machine is fine ({seconds:.1f} s)", seconds=seconds))
    out.result(
        {
            "ok": not failed,
            "seconds": round(seconds, 2),
            "checks": [
                {
                    "name": o.name,
                    "state": o.state.value.lower(),
                    "seconds": round(o.seconds, 3),
                    "text": o.text,
                }
                for o in outcomes
            ],
        }
    )
    return 1 if failed else 0
