"""`woosh watch`: a live full-screen display."""

from __future__ import annotations

import os
import sys
import time
from argparse import ArgumentParser, Namespace
from contextlib import ExitStack
from typing import TYPE_CHECKING

from rosproto.cli import (
    Keys,
    enable_escapes,
    is_terminal,
    number_from,
    open_keys,
    own,
    seconds,
    shows_unicode,
    terminal_size,
)
from rosproto.sentence import say
from woosh_pure.cli.commands.state import as_json
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output, full_screen, task_words

if TYPE_CHECKING:
    from rosproto.transport import Deadline
    from woosh_pure.cli.screen import Observer, Scene


def add_watch(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--for", dest="seconds", type=seconds, metavar="S", help="end after this many seconds"
    )
    parser.add_argument(
        "--rate", type=number_from(0.05, 30.0), metavar="HZ", help="pictures per second (5), lines (1)"
    )
    parser.add_argument("--ascii", action="store_true", help="only ASCII characters, for old terminals")
    parser.add_argument("--lines", action="store_true", help="a line each time instead of the whole screen")
    parser.add_argument("--no-map", action="store_true", help="do not fetch the map")


def run_watch(args: Namespace, out: Output) -> None:
    whole = not (args.lines or args.json) and enable_escapes(sys.stdout)
    rate = (5.0 if whole else 1.0) if args.rate is None else args.rate
    from rosproto.transport import Deadline
    from woosh_pure.cli.screen import Observer  # late: it needs numpy

    with connect(args, out) as chassis:
        observer = Observer(chassis)
        if not args.no_map:
            with out.working("fetching the map"):
                observer.fetch_map()
        deadline = Deadline(args.seconds)
        if whole:
            _on_screen(observer, args, 1.0 / rate, deadline)
        else:
            _by_line(observer, out, 1.0 / rate, deadline)


def _on_screen(observer: Observer, args: Namespace, period: float, deadline: Deadline) -> None:
    from woosh_pure.cli.screen import Screen

    plain = args.ascii or not shows_unicode(sys.stdout)
    screen = Screen(ascii_only=plain, coloured=not os.environ.get("NO_COLOR"))
    with ExitStack() as stack:
        keys = stack.enter_context(open_keys()) if is_terminal(sys.stdin) else None
        stack.enter_context(full_screen(sys.stdout))
        while not deadline.expired:
            columns, lines = terminal_size()
            picture = screen.render(observer.look(), columns, lines)
            own(sys.stdout).write("\x1b[H" + "\x1b[K\r\n".join(picture) + "\x1b[K\x1b[J")
            sys.stdout.flush()
            if _quit_within(keys, period):
                return


def _quit_within(keys: Keys | None, period: float) -> bool:
    """Wait for the next picture; return True to quit."""
    if keys is None:
        time.sleep(period)
        return False
    from rosproto.transport import Deadline

    deadline = Deadline(period)
    while rest := deadline.remaining():
        if any(key in ("q", "escape") for key in keys.read(rest)):
            return True
    return False


def _by_line(observer: Observer, out: Output, period: float, deadline: Deadline) -> None:
    while not deadline.expired:
        time.sleep(period)
        scene = observer.look()
        out.line("  ".join(map(out.say, one_line(scene))))
        out.record(_document(scene))


def one_line(scene: Scene) -> list[str]:
    """What a line of `--lines` tells: the time, then each fact."""
    v, b, s = scene.velocity, scene.battery, scene.status
    parts = [
        time.strftime("%H:%M:%S"),
        str(scene.pose or "pose not heard"),
        "velocity not heard" if v is None else f"{v.vx:+.2f} m/s {v.wz:+.2f} rad/s",
        "battery not heard" if b is None else f"{b.percent} %",
        "state not heard" if s is None else say("{state}, {task}", state=s.robot_state, task=task_words(s)),
    ]
    if scene.nearest is not None:
        parts.append(say("nearest {metres:.2f} m", metres=scene.nearest))
    if scene.silence is not None:
        parts.insert(1, say("SILENT for {seconds:.0f} s, before that:", seconds=scene.silence))
    return [*parts, *(str(fault) for fault in scene.faults)]


def _document(scene: Scene) -> dict[str, object]:
    return {
        "time": round(time.time(), 3),
        "pose": scene.pose,
        "velocity": scene.velocity,
        "battery": None if scene.battery is None else scene.battery.percent,
        "status": scene.status,
        "ready": None if scene.readiness is None else as_json(scene.readiness),
        "faults": scene.faults,
        "faults_known": getattr(scene.faults, "known", False),
        "nearest": scene.nearest,
        "rates": {name: round(rate, 2) for name, rate in scene.rates.items()},
        "ages": {name: round(age, 3) for name, age in scene.ages.items()},
    }
