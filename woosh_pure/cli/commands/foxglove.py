"""`woosh foxglove`: the chassis, live, in Foxglove and Lichtblick."""

from __future__ import annotations

import time
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from rosproto.cli import (
    add_server_options,
    announced,
    gateway_watchdog,
    interrupt_on_signals,
    server_options,
    serving,
    until_interrupted,
)
from rosproto.sentence import say
from woosh_pure.cli import config
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output
from woosh_pure.interface.table import driving_patterns
from woosh_pure.maps.marks import MarkFile, UserMark

HELP = "show the chassis live in Foxglove and Lichtblick; read only unless you open something"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument(
        "--layout",
        type=Path,
        metavar="FILE",
        help="write a layout for the chassis there (import it in the viewer), and serve",
    )
    parser.add_argument("--layout-only", action="store_true", help="write the layout and end")
    parser.add_argument("--marks", type=Path, metavar="FILE", help="the list of marks that is drawn")
    add_server_options(parser)
    parser.add_argument(
        "--allow-driving",
        action="store_true",
        help="let viewers publish velocities and the goals that move the robot; keep the red button in reach",
    )


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    from rosproto.gateway import Foxglove
    from woosh_pure.foxglove import ChassisTopics, write_layout

    if args.layout_only and args.layout is None:
        raise ValueError("--layout-only needs --layout FILE")
    if args.layout is not None:
        out.line(
            say(
                "layout: {path} (in the viewer: Layouts, Import from file)",
                path=write_layout(args.layout),
            )
        )
    if args.layout_only:
        out.result({"layout": str(args.layout)})
        return 0
    options = server_options(args, write=driving_patterns() if args.allow_driving else ())
    marks = _Marks(args.marks or config.mark_file())
    with ExitStack() as stack:
        stack.enter_context(interrupt_on_signals())
        watchdog = stack.enter_context(gateway_watchdog(args, options["access"]))
        chassis = stack.enter_context(connect(args, out))
        topics = stack.enter_context(ChassisTopics(chassis, marks, out.language))
        server = stack.enter_context(
            serving(
                Foxglove, chassis.node, options, topics=topics.all, name="Woosh chassis", watchdog=watchdog
            )
        )
        for line in announced(server, options):
            out.line(line)
        out.result({"url": server.url, "token": options["token"], "write": list(options["access"].write)})
        try:
            until_interrupted(chassis.node, args.seconds)
        except KeyboardInterrupt:
            pass  # the normal end of this command
    return 0


class _Marks:
    """The list of marks; reread when its file changes."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._read: tuple[float, tuple[UserMark, ...]] = (-1.0, ())
        self._looked = 0.0

    def __call__(self) -> Sequence[UserMark]:

        now = time.monotonic()
        if now - self._looked >= 1.0:
            self._looked = now
            try:
                changed = self._path.stat().st_mtime
            except OSError:
                changed = -1.0
            if changed != self._read[0]:
                self._read = changed, tuple(MarkFile(self._path))
        return self._read[1]
