"""Commands that show the state of the chassis: status, readiness, battery, faults."""

from __future__ import annotations

import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from rosproto.cli import DONE, FAILED, number_from, seconds, to_int
from rosproto.errors import RosTimeout
from rosproto.sentence import say
from woosh_pure.cli.arguments import add_wait, wait_for
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import NOT_KNOWN, READY, Output, task_words
from woosh_pure.enums import RobotState, TaskState
from woosh_pure.errors import ChassisError
from woosh_pure.faults import StatusCode, all_codes, decode_status_code
from woosh_pure.reasons import Readiness, Reason, ReasonKey

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis
    from woosh_pure.feed.feed import Reading


def add_status(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--wait", type=seconds, default=2.0, metavar="S", help="seconds to listen (default 2)"
    )


def run_status(args: Namespace, out: Output) -> int:
    with connect(args, out) as chassis:
        faults = chassis.faults
        chassis.readiness()  # subscribes to further topics
        with out.working("listening"):
            readings = chassis.snapshot(args.wait)
        faults, readiness = chassis.faults, readiness_of(chassis)
        heard = {name: r for name, r in readings.items() if r is not None}
        for name in ("status", "battery", "pose", "velocity", "odometer", "information"):
            out.line(out.cell(name, 12), _status_line(name, heard.get(name)))
        out.line(out.cell("faults", 12), str(faults))
        answer = verdict(readiness, out, short=True)
        out.line(out.cell("ready", 12), say("{head}: {tail}", head=answer, tail=str(readiness)))
        silent = sorted(set(readings) - set(heard))
        out.line(out.cell("silent", 12), ", ".join(silent) or "none")
        out.result(
            {
                "master_uri": chassis.master_uri,
                "ready": as_json(readiness),
                "answer": readiness.answer.value,
                "reasons": [r.text for r in readiness.reasons],
                "faults": [str(f) for f in faults],
                "faults_known": faults.known,
                "feeds": {n: _status_document(r) for n, r in heard.items() if n not in ("scan",)},
                "silent": silent,
            }
        )
        if not heard:
            out.line("nothing was heard; is this a chassis? try `woosh doctor`")
        return 0 if heard else 1


def _status_document(reading: Reading[object]) -> dict[str, object]:
    from dataclasses import asdict, is_dataclass

    value = asdict(reading.value) if is_dataclass(reading.value) else reading.value  # type: ignore[arg-type]
    return {"value": value, "age": round(reading.age, 3), "stamp": reading.stamp}


def _status_line(name: str, reading: Reading[Any] | None) -> str:
    if reading is None:
        return "not heard yet (sent on change only)" if name == "status" else "not heard yet"
    v = reading.value
    lines: dict[str, Callable[[], str]] = {
        "status": lambda: say(
            "{state}, {mode}, {work} mode; {task}",
            state=v.robot_state,
            mode=v.robot_mode,
            work=v.work_mode,
            task=task_words(v),
        ),
        "battery": lambda: say(
            "{percent} %, {volts:.1f} V, {amperes:.1f} A, {charge}"
            if v.measured
            else "{percent} %, {charge}",
            percent=v.percent,
            volts=v.voltage,
            amperes=v.current,
            charge=v.charge_status,
        ),
        "velocity": lambda: f"{v.vx:.3f} m/s, {v.wz:.3f} rad/s",
        "odometer": lambda: f"{v:.1f} m",
        "information": lambda: say(
            "{type}, hardware {hardware}, software {software}",
            type=say(v.base_type),
            hardware=v.hardware_version,
            software=v.software_version,
        ),
    }
    text = lines.get(name, lambda: str(v))()
    return say("{text}  [{seconds:.1f} s ago]", text=say(text), seconds=reading.age)


def add_ready(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--listen", type=seconds, default=1.0, metavar="S", help="seconds to listen before judging (1)"
    )
    parser.add_argument("--wait", type=seconds, metavar="S", help="wait up to S seconds for the answer yes")


def run_ready(args: Namespace, out: Output) -> int:
    from rosproto.transport import Deadline

    with connect(args, out) as chassis:
        chassis.readiness()  # subscribes
        deadline = Deadline(args.listen)
        with out.working("listening"):
            while not (deadline.expired or (chassis.status.heard and chassis.battery.heard)):
                time.sleep(0.02)
            if args.wait is not None:
                _wait_until_ready(chassis, args.wait)
        readiness = readiness_of(chassis)
    answer = readiness.answer.value
    out.line("{head}: {tail}", head=verdict(readiness, out), tail=str(readiness))
    out.result({"ready": as_json(readiness), "answer": answer, "reasons": list(readiness.reasons)})
    return READY[answer]


def _wait_until_ready(chassis: Chassis, timeout: float) -> None:
    from rosproto.transport import Deadline

    deadline = Deadline(timeout)
    while not (is_there(chassis) or deadline.expired):
        time.sleep(0.1)
    try:
        chassis.wait_until_ready(deadline.remaining(), known=True)
    except RosTimeout:
        pass  # the caller reports blocked or unknown


def add_battery(parser: ArgumentParser) -> None:
    add_wait(parser)
    parser.add_argument(
        "--below",
        type=number_from(0.0, 100.0),
        metavar="PERCENT",
        help="exit code 1 when it holds less than this",
    )


def run_battery(args: Namespace, out: Output) -> int:
    with connect(args, out) as chassis:
        b = wait_for(chassis.battery, args, out)
    colour = "red" if b.percent < 20 else "yellow" if b.percent < 40 else "green"
    charge = out.colour(f"{b.percent} %", colour)
    rows = {
        "battery": say(
            "{charge}, {status} ({mode})", charge=charge, status=b.charge_status, mode=b.charge_mode
        ),
        "voltage": say(
            "{volts:.2f} V, cells {lowest:.2f} to {highest:.2f} V",
            volts=b.voltage,
            lowest=b.cell_voltage_min,
            highest=b.cell_voltage_max,
        ),
        "current": f"{b.current:.2f} A",
        "temperature": say("{lowest} to {highest} °C", lowest=b.temperature_min, highest=b.temperature_max),
        "capacity": say(
            "{left:.1f} of {full:.1f} Ah (designed {designed:.1f} Ah)",
            left=b.capacity_remaining,
            full=b.capacity_full,
            designed=b.capacity_design,
        ),
        "cycles": say(
            "{charged} charged, {own} of the battery", charged=b.charge_cycles, own=b.battery_cycles
        ),
    }
    for name, text in rows.items():
        if b.measured or name not in ("voltage", "current", "capacity"):
            out.line(out.cell(name, 12), text)
    out.result(b)
    return 1 if args.below is not None and b.percent < args.below else 0


def add_faults(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--listen",
        type=seconds,
        default=3.0,
        metavar="S",
        help="seconds to listen: codes come on change only (3)",
    )
    parser.add_argument(
        "what", nargs="?", metavar="CODE|TEXT", help="as --code or --find; none: what is wrong now"
    )
    parser.add_argument("--code", type=to_int, metavar="NUMBER", help="explain this code; asks no chassis")
    parser.add_argument("--find", metavar="TEXT", help="codes whose name or words have it; asks no chassis")
    parser.add_argument("--chinese", action="store_true", help="words in Chinese")


def run_faults(args: Namespace, out: Output) -> int:
    if args.what is not None:
        if args.code is not None or args.find is not None:
            raise ValueError("give one of: a code, a text, --code, --find")
        try:
            args.code = to_int(args.what)
        except ValueError:
            args.find = args.what
    if args.code is not None:
        if not 0 <= args.code < 1 << 64:
            raise ValueError(
                say("--code {code}: a status code is a number from 0 to 2^64 - 1", code=args.code)
            )
        code, task, robot = decode_status_code(args.code), TaskState(args.code), RobotState(args.code)
        if task.known or robot.known:
            out.line(
                "{number} is not a status code (12 digits); "
                "in /robot_status it is task_state {task}, robot_state {robot}",
                number=args.code,
                task=task,
                robot=robot,
            )
        else:
            _print_codes([code], args, out)
        out.result([code])
        return 0
    if args.find is not None:
        wanted = args.find.lower()
        found = [c for c in all_codes() if wanted in f"{c.identifier} {c.english} {c.chinese}".lower()]
        if not found:
            out.line("no code has {text!r} in its name or words", text=args.find)
        _print_codes(found, args, out)
        out.result(found)
        return 0 if found else 1
    with connect(args, out) as chassis:
        faults = chassis.faults  # subscribes
        with out.working("listening"):
            time.sleep(args.listen)
        faults = chassis.faults
        if not faults and not is_there(chassis):
            raise ChassisError(nobody_there(chassis))
    if not faults:
        out.line(str(faults))
    _print_codes(faults, args, out)
    out.result({"known": faults.known, "present": faults.present, "faults": list(faults)})
    return {True: FAILED, False: DONE, None: NOT_KNOWN}[faults.present]


def _print_codes(codes: Iterable[StatusCode], args: Namespace, out: Output) -> None:
    colours = {0: "green", 1: "blue", 2: "yellow", 3: "red"}
    for c in codes:
        level = out.colour(c.level.name.lower(), colours[int(c.level)], 8)
        words = c.chinese if args.chinese or out.language == "zh" else c.english
        if c.derived:
            words = say("{words} (made from its name or number)", words=words)
        out.line(level, f"{c.code:012d}", words, "", c.identifier or "not in the table")


_STEADY = 1.0  # s; maximum wait for the measured velocity, also over a slow network


def is_there(chassis: Chassis) -> bool:
    """Whether the chassis's status is published; a master without a chassis answers, too."""
    return chassis.status.heard or chassis.status.publishers > 0


def nobody_there(chassis: Chassis) -> str:
    """Return the sentence for a missing or unreachable chassis."""
    if why := chassis.status.unreachable:
        return say(
            "{topic} is published at {uri}, but its publisher is not connected: {why}; try `woosh doctor`",
            topic=chassis.status.topic,
            uri=chassis.master_uri,
            why=why,
        )
    return say(
        "nobody publishes {topic} at {uri}: no chassis runs there, or not all of it; try `woosh doctor`",
        topic=chassis.status.topic,
        uri=chassis.master_uri,
    )


_WORDS = {
    "yes": ("ready", "yes", "green"),
    "no": ("NOT READY", "NO", "red"),
    "not known": ("NOT KNOWN whether it is ready", "NOT KNOWN", "yellow"),
}


def verdict(readiness: Readiness, out: Output, *, short: bool = False) -> str:
    """Return the answer in one or a few words, coloured."""
    long_word, short_word, colour = _WORDS[readiness.answer.value]
    return out.colour(short_word if short else long_word, colour)


def as_json(readiness: Readiness) -> bool | None:
    """Return True, False, or None (null) if unknown."""
    return {"yes": True, "no": False}.get(readiness.answer.value)


def readiness_of(chassis: Chassis) -> Readiness:
    """Return `Chassis.readiness()`, but no without a chassis: scripts would read "unknown" as yes."""
    found = chassis.readiness()
    if not is_there(chassis):
        key = ReasonKey.UNREACHABLE if chassis.status.unreachable else ReasonKey.NO_CHASSIS
        missing = Reason(key, nobody_there(chassis))
    elif _is_silent(chassis):
        missing = Reason(
            ReasonKey.SILENT, "nothing is received from the chassis: is it running? try `woosh doctor`"
        )
    else:
        return found
    known = [reason for reason in found.reasons if reason.key != ReasonKey.UNKNOWN]
    return Readiness((missing, *known))


def _is_silent(chassis: Chassis) -> bool:
    """Whether periodic topics are silent, too: then its nodes are registered, but do not run."""
    if chassis.status.heard or chassis.battery.heard:
        return False
    try:
        chassis.measured_velocity.wait(_STEADY, new=False)
    except RosTimeout:
        return True
    return False
