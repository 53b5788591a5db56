"""`woosh status`: what the chassis says now."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING, Any

from woosh_pure.cli.arguments import seconds
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output
from woosh_pure.cli.readiness import as_json, readiness_of, verdict

if TYPE_CHECKING:
    from woosh_pure.feed.feed import Reading

HELP = "show battery, pose, state, faults and whether it would move"


def add_arguments(parser: ArgumentParser) -> None:
    """See `registry`."""
    parser.add_argument(
        "--wait", type=seconds, default=2.0, metavar="S", help="seconds to listen (default 2)"
    )


def run(args: Namespace, out: Output) -> int:
    """See `registry`."""
    with connect(args, out) as chassis:
        faults = chassis.faults
        chassis.readiness()  # begins to listen to what only it needs
        with out.working("listening"):
            readings = chassis.snapshot(args.wait)
        faults, readiness = chassis.faults, readiness_of(chassis)
        heard = {name: r for name, r in readings.items() if r is not None}
        for name in ("status", "battery", "pose", "velocity", "odometer", "information"):
            out.line(f"{name:12s} {_line(name, heard.get(name))}")
        out.line(f"{'faults':12s} {faults.sentence()}")
        out.line(f"{'ready':12s} {verdict(readiness, out, short=True)}: {readiness.sentence()}")
        silent = sorted(set(readings) - set(heard))
        out.line(f"{'silent':12s} {', '.join(silent) or 'none'}")
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
        return "not heard yet" + (" (sent on change only)" if name == "status" else "")
    v = reading.value
    text = {
        "status": lambda: (
            f"{v.robot_state}, {v.robot_mode}, {v.work_mode} mode; task {v.task_id} {v.task_state}"
        ),
        "battery": lambda: f"{v.percent} %, {v.voltage:.1f} V, {v.current:.1f} A, {v.charge_status}",
        "velocity": lambda: f"{v.vx:.3f} m/s, {v.wz:.3f} rad/s",
        "odometer": lambda: f"{v:.1f} m",
        "information": lambda: f"{v.base_type}, hardware {v.hardware_version}, software {v.software_version}",
    }.get(name, lambda: str(v))()
    return f"{text}  [{reading.age:.1f} s ago]"
