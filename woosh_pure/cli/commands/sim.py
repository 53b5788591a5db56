"""`woosh sim`: a simulated chassis for other programs, until interrupted."""

from __future__ import annotations

import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from rosproto.cli import (
    NotANumber,
    add_token,
    cannot_listen,
    host,
    never_wait_for_stdout,
    port,
    positive,
    seconds,
    to_float,
    to_int,
    whole_from,
)
from rosproto.errors import ConnectionLost
from rosproto.sentence import led, say
from rosproto.transport import allow_open_files
from woosh_pure.cli.arguments import add_mark_options
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
    parser.add_argument(
        "--robots",
        type=whole_from(1, 100),
        default=1,
        metavar="N",
        help="so many, on ports in a row, and a page with all",
    )
    parser.add_argument("--page-port", type=port, default=8080, metavar="PORT", help="of that page (8080)")
    parser.add_argument(
        "--robot-api",
        type=port,
        nargs="?",
        const=5480,
        metavar="PORT",
        help="also answer the Robot API, commands too, on this computer only (5480; 0: any)",
    )
    add_token(parser, "WOOSH_WEB_TOKEN", "what everybody has to know for the page; needed off this computer")
    parser.add_argument("--speed", type=positive, default=1.0, help="simulated seconds per second")
    parser.add_argument("--seed", type=to_int, default=0, help="seed of all random values")
    parser.add_argument(
        "--map",
        type=Path,
        metavar="YAML",
        help="a map_server map instead of the built-in hall; the hall's marks that lie in it stay",
    )
    add_mark_options(parser)
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
    if args.master and args.robots > 1:
        raise ValueError("--robots: each has a master of its own; leave --master out")
    if args.robots > 1:
        from woosh_pure.web.optional_libraries import require

        require()
    sims = {
        f"robot{number}": SimulatedChassis(
            master_uri=args.master,
            host=args.bind,
            port=args.port and args.port + number - 1,
            speed=args.speed,
            site=site_of(args.map, args.mark, args.marks),
            settings=settings,
            latch_status=not args.status_on_change,
            repeat_status_code=not args.status_code_once,
            full_graph=args.robots == 1,
            firmware=args.firmware,
        )
        for number in range(1, args.robots + 1)
    }
    sim = sims["robot1"]
    with ExitStack() as stack:
        for one in sims.values():
            _start(one, stack)
        apis = {} if args.robot_api is None else _serve_api(sims, args, stack)
        if args.robots > 1:
            _show(sims, args, out, stack)
        where = "simulated chassis at {uri}, {speed:g} times real time; Ctrl-C ends it"
        for name, one in sims.items():
            texts = [say(where, uri=one.master_uri, speed=args.speed)]
            if name in apis:
                texts.append(say("Robot API: {url}", url=apis[name]))
            for text in texts:
                out.line(text if args.robots == 1 else led(name, text))
        if args.firmware != "1.1.4":
            out.line("its messages are those of firmware {firmware}", firmware=args.firmware)
        out.line("marks: {names}", names=list(sim.world.site.marks) or say("none"))
        out.line("try:   woosh --master {uri} status", uri=sim.master_uri)
        door = {"robot_api": apis["robot1"]} if apis else {}
        out.result({"master_uri": sim.master_uri, "marks": sorted(sim.world.site.marks), **door})
        deadline, began = Deadline(args.seconds), time.monotonic()
        while not deadline.expired:
            while schedule and time.monotonic() - began >= schedule[0][0]:
                _inject_all(schedule.pop(0)[1], sims, out)
            time.sleep(0.05)
        for at, fault in schedule:  # on a busy computer, run late faults that were due before the end
            if args.seconds is not None and at <= args.seconds:
                _inject_all(fault, sims, out)


def _inject_all(fault: str, sims: Mapping[str, SimulatedChassis], out: Output) -> None:
    out.line("now: {fault}", fault=fault)
    for sim in sims.values():
        inject(sim, fault)


def _require_known(version: str) -> None:
    """Refuse firmware with newer definitions than the bundled ones."""
    from woosh_pure.firmware.versions import CURRENT

    try:
        newer = [int(part) for part in version.split(".")] > [int(part) for part in CURRENT.split(".")]
    except ValueError:
        return  # "page", or what `firmware` will name
    if newer:
        wrong = "--firmware {version}: nothing newer than {current} is known here"
        raise ValueError(say(wrong, version=version, current=CURRENT))


def _start(sim: SimulatedChassis, stack: ExitStack) -> None:
    try:
        stack.enter_context(sim)
    except ConnectionLost as error:
        # A local error: the address cannot be bound.
        raise ChassisError(cannot_listen(error, "--bind")) from error


def _serve_api(sims: Mapping[str, SimulatedChassis], args: Namespace, stack: ExitStack) -> dict[str, str]:
    """Serve the Robot API of each robot, on ports in a row; return the addresses."""
    from rosproto import Node
    from rosproto.gateway import Access
    from woosh_pure.api_server import RobotApiServer, simulated_site

    urls = {}
    for number, (name, sim) in enumerate(sims.items(), 1):
        node = stack.enter_context(
            Node("woosh_robot_api", master_uri=sim.master_uri, host=args.bind, anonymous=True, rosout=False)
        )
        port, site = args.robot_api and args.robot_api + number - 1, simulated_site(sim, number)
        try:
            server = RobotApiServer(
                node, port=port, access=Access(write=["api:*"]), robot_id=number, site=site
            )
            stack.enter_context(server)
        except ConnectionLost as error:
            raise ChassisError(cannot_listen(error, "--bind", "--robot-api")) from error
        urls[name] = server.url
    return urls


def _show(sims: Mapping[str, SimulatedChassis], args: Namespace, out: Output, stack: ExitStack) -> None:
    """Serve one page with all robots."""
    from woosh_pure.chassis import Chassis
    from woosh_pure.cli.commands.web import page_arguments, page_of

    allow_open_files(4096)
    page = page_arguments(args, "--bind", args.bind, "--no-browser")
    page.token, page.token_file = args.token, args.token_file
    robots = {name: stack.enter_context(Chassis(sim.master_uri)) for name, sim in sims.items()}
    marks = next(iter(sims.values())).world.site.user_marks().values()
    stack.enter_context(page_of(robots, page, out, marks, sims))


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
