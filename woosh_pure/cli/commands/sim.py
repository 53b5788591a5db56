"""`woosh sim`: a simulated chassis for other programs, until interrupted."""

from __future__ import annotations

import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rosproto.cli import (
    NotANumber,
    cannot_listen,
    host,
    never_wait_for_stdout,
    port,
    positive,
    seconds,
    to_float,
    to_int,
)
from rosproto.errors import ConnectionLost
from rosproto.sentence import led, say
from woosh_pure.cli.output import Output
from woosh_pure.enums import RobotMode
from woosh_pure.errors import ChassisError

if TYPE_CHECKING:
    from woosh_pure.sim import SimulatedChassis


FAULTS: dict[str, Callable[..., object]] = {
    "reset": lambda sim: sim.reset(),
    "teleport:X:Y": lambda sim, x, y: sim.teleport(to_float(x), to_float(y)),
    "battery:N": lambda sim, percent: sim.set_battery(to_float(percent)),
    "estop": lambda sim: sim.press_emergency_stop(),
    "release": lambda sim: sim.release_emergency_stop(),
    "free": lambda sim: sim.release_bumper(),
    "lost": lambda sim: sim.lose_localization(),
    "manual": lambda sim: sim.set_mode(RobotMode.MANUAL),
    "automatic": lambda sim: sim.set_mode(RobotMode.AUTOMATIC),
    "cable": lambda sim: sim.plug_cable(),
    "uncable": lambda sim: sim.plug_cable(False),
    "obstacle:X:Y": lambda sim, x, y: sim.add_obstacle(to_float(x), to_float(y)),
    "clear": lambda sim: sim.remove_obstacles(),
    "failtask": lambda sim: sim.fail_task(),
    "slow:SECONDS": lambda sim, s: sim.slow_network(to_float(s)),
    "silent:SECONDS": lambda sim, s: sim.fall_silent(to_float(s)),
    "drop:SECONDS": lambda sim, s: sim.drop_link(to_float(s)),
    "clock:SECONDS": lambda sim, s: sim.set_clock(to_float(s)),
    "restart-master": lambda sim: sim.restart_master(),
    "crash:NODE": lambda sim, node: sim.crash_node(node),
    "compete:X:Y": lambda sim, x, y: sim.compete(to_float(x), to_float(y)),
    "code:NUMBER": lambda sim, number: sim.report(to_int(number)),
}
"""What --at may cause, by its form: called with the simulated chassis and the values as texts."""


def add_sim(parser: ArgumentParser) -> None:
    parser.add_argument("--port", type=port, default=11311, help="port of its own master (11311; 0: any)")
    parser.add_argument(
        "--bind", type=host, default="127.0.0.1", metavar="ADDRESS", help="address at which others reach it"
    )
    parser.add_argument("--speed", type=positive, default=1.0, help="simulated seconds per second")
    parser.add_argument("--seed", type=to_int, default=0, help="seed of all random values")
    parser.add_argument(
        "--map",
        type=Path,
        metavar="YAML",
        help="a map_server map instead of the built-in hall; the hall's marks that lie in it stay",
    )
    parser.add_argument(
        "--mark",
        action="append",
        default=[],
        metavar="NAME=X,Y,YAW",
        help="a mark of yours: m, m, degrees (repeat for more); one of that name is moved there",
    )
    parser.add_argument(
        "--marks",
        action="append",
        type=Path,
        default=[],
        metavar="FILE",
        help="marks from a list as `woosh marks` keeps it",
    )
    parser.add_argument("--omni", action="store_true", help="an omnidirectional base")
    parser.add_argument("--lost", action="store_true", help="switched on without knowing its position")
    parser.add_argument(
        "--firmware",
        default="1.1.4",
        metavar="VERSION",
        help="whose message definitions it uses: a version of the vendor's package such as 1.1.4, 1.1.0, "
        "1.0.8, or 'page' for the vendor's web page",
    )
    parser.add_argument(
        "--status-on-change",
        action="store_true",
        help="send /robot_status on change only: later subscribers do not receive it",
    )
    parser.add_argument(
        "--status-code-once",
        action="store_true",
        help="send each status code once, without repeating the last one",
    )
    parser.add_argument("--stops-on-silence", action="store_true", help="stop when velocity messages end")
    parser.add_argument(
        "--at",
        action="append",
        default=[],
        metavar="S=FAULT",
        help=f"cause something after S seconds (10=estop), repeat for more; one of {', '.join(FAULTS)}",
    )
    parser.add_argument(
        "--for", dest="seconds", type=seconds, metavar="S", help="end after this many seconds"
    )


def run_sim(args: Namespace, out: Output) -> None:
    never_wait_for_stdout()
    from rosproto.transport import Deadline
    from woosh_pure.sim import Settings, SimulatedChassis
    from woosh_pure.sim.body import BodyLimits
    from woosh_pure.sim.site import site_of

    schedule = sorted(_parse_at(text) for text in args.at)
    _require_known(args.firmware)
    settings = Settings(
        seed=args.seed,
        located=not args.lost,
        limits=BodyLimits(omnidirectional=args.omni),
        on_silence="stop" if args.stops_on_silence else "keep",
    )
    sim = SimulatedChassis(
        master_uri=args.master,
        host=args.bind,
        port=args.port,
        speed=args.speed,
        site=site_of(args.map, args.mark, args.marks),
        settings=settings,
        latch_status=not args.status_on_change,
        repeat_status_code=not args.status_code_once,
        firmware=args.firmware,
    )
    with _listening(sim):
        out.line(
            "simulated chassis at {uri}, {speed:g} times real time; Ctrl-C ends it",
            uri=sim.master_uri,
            speed=args.speed,
        )
        if args.firmware != "1.1.4":
            out.line("its messages are those of firmware {firmware}", firmware=args.firmware)
        out.line("marks: {names}", names=list(sim.world.site.marks) or say("none"))
        out.line("try:   woosh --master {uri} status", uri=sim.master_uri)
        out.result({"master_uri": sim.master_uri, "marks": sorted(sim.world.site.marks)})
        deadline, began = Deadline(args.seconds), time.monotonic()
        while not deadline.expired:
            while schedule and time.monotonic() - began >= schedule[0][0]:
                _, text = schedule.pop(0)
                out.line("now: {fault}", fault=text)
                inject(sim, text)
            time.sleep(0.05)
        for at, text in schedule:  # on a busy computer, run late faults that were due before the end
            if args.seconds is not None and at <= args.seconds:
                out.line("now: {fault}", fault=text)
                inject(sim, text)


def _require_known(version: str) -> None:
    """Refuse firmware with newer definitions than the bundled ones."""
    from woosh_pure.firmware.versions import CURRENT

    try:
        newer = [int(part) for part in version.split(".")] > [int(part) for part in CURRENT.split(".")]
    except ValueError:
        return  # "page", or what `firmware` will name
    if newer:
        raise ValueError(
            say(
                "--firmware {version}: nothing newer than {current} is known here",
                version=version,
                current=CURRENT,
            )
        )


@contextmanager
def _listening(sim: SimulatedChassis) -> Iterator[None]:
    with ExitStack() as stack:
        try:
            stack.enter_context(sim)
        except ConnectionLost as error:
            # A local error: the address cannot be bound.
            raise ChassisError(cannot_listen(error, "--bind")) from error
        yield


def _parse_at(text: str) -> tuple[float, str]:
    seconds, equals, fault = text.partition("=")
    names = [name.partition(":")[0] for name in FAULTS]
    try:
        after = to_float(seconds)
    except ValueError:
        after = -1.0
    if not equals or after < 0.0 or fault.partition(":")[0] not in names:
        raise ValueError(
            say("--at {text}: expected S=FAULT with one of {names}", text=text, names=", ".join(FAULTS))
        )
    return after, fault


def inject(sim: SimulatedChassis, fault: str) -> None:
    """Cause a fault of `FAULTS`."""
    name, *values = fault.split(":")
    form = next(form for form in FAULTS if form.partition(":")[0] == name)
    wanted = form.count(":")
    wrong = say("--at {fault}: expected {form}", fault=fault, form=form)
    if len(values) < wanted:
        raise ValueError(wrong)
    try:
        FAULTS[form](sim, *values[:wanted])
    except ValueError as error:
        detailed = values and not isinstance(error, NotANumber)
        raise ValueError(led(wrong, str(error)) if detailed else wrong) from error
