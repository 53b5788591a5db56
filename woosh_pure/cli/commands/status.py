"""`woosh status`: the present state of the chassis."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rosproto.sentence import say
from woosh_pure.cli.arguments import seconds
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output
from woosh_pure.cli.readiness import as_json, readiness_of, verdict

if TYPE_CHECKING:
    from woosh_pure.feed.feed import Reading

HELP = "show battery, pose, state, faults and whether it would move"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument(
        "--wait", type=seconds, default=2.0, metavar="S", help="seconds to listen (default 2)"
    )


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    with connect(args, out) as chassis:
        faults = chassis.faults
        chassis.readiness()  # subscribes to further topics
        with out.working("listening"):
            readings = chassis.snapshot(args.wait)
        faults, readiness = chassis.faults, readiness_of(chassis)
        heard = {name: r for name, r in readings.items() if r is not None}
        for name in ("status", "battery", "pose", "velocity", "odometer", "information"):
            out.line(out.cell(name, 12), _line(name, heard.get(name)))
        out.line(out.cell("faults", 12), faults.sentence())
        answer = verdict(readiness, out, short=True)
        out.line(out.cell("ready", 12), say("{head}: {tail}", head=answer, tail=readiness.sentence()))
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
                "feeds": {n: _document(r) for n, r in heard.items() if n not in ("scan",)},
                "silent": silent,
            }
        )
        if not heard:
            out.line("nothing was heard; is this a chassis? try `woosh doctor`")
        return 0 if heard else 1


def _document(reading: Reading[Any]) -> dict[str, Any]:
    from dataclasses import asdict, is_dataclass

    value = asdict(reading.value) if is_dataclass(reading.value) else reading.value  # type: ignore[arg-type]
    return {"value": value, "age": round(reading.age, 3), "stamp": reading.stamp}


def _line(name: str, reading: Reading[Any] | None) -> str:
    if reading is None:
        return "not heard yet (sent on change only)" if name == "status" else "not heard yet"
    v = reading.value
    lines: dict[str, Callable[[], str]] = {
        "status": lambda: say(
            "{state}, {mode}, {work} mode; task {id} {task}",
            state=v.robot_state,
            mode=v.robot_mode,
            work=v.work_mode,
            id=v.task_id,
            task=v.task_state,
        ),
        "battery": lambda: say(
            "{percent} %, {volts:.1f} V, {amperes:.1f} A, {charge}",
            percent=v.percent,
            volts=v.voltage,
            amperes=v.current,
            charge=v.charge_status,
        ),
        "velocity": lambda: f"{v.vx:.3f} m/s, {v.wz:.3f} rad/s",
        "odometer": lambda: f"{v:.1f} m",
        "information": lambda: say(
            "{type}, hardware {hardware}, software {software}",
            type=v.base_type,
            hardware=v.hardware_version,
            software=v.software_version,
        ),
    }
    text = lines.get(name, lambda: str(v))()
    return say("{text}  [{seconds:.1f} s ago]", text=say(text), seconds=reading.age)
