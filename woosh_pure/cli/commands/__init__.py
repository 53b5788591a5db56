"""The commands: one file each, named here. To add one, write the file and add its name.

Such a file has `HELP` (one line), `add_arguments(parser)` and `run(args, out) -> int`, with slow imports
inside `run`. A new one also needs a place in `GROUPS` of tools/manual.py. After a change run
`python -m tools.manual`, which writes docs/commands.md and docs/commands/.
"""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from importlib import import_module
from typing import Protocol, cast

from woosh_pure.cli.output import Output

__all__ = ["COMMANDS", "Command", "load"]

COMMANDS = (
    *("demo", "sim", "connect", "doctor", "selftest", "learn"),
    *("status", "ready", "watch", "battery", "faults", "imu", "scan", "camera", "cloud"),
    *("goto", "task", "charge", "move", "rotate", "drive", "stop"),
    *("localization", "map", "plan", "costmap", "footprint", "mode", "marks"),
    *("led", "say"),
    *("record", "web", "foxglove", "vda5050"),
    *("shell", "completion"),
)


class Command(Protocol):
    """The interface of a command file."""

    HELP: str

    def add_arguments(self, parser: ArgumentParser) -> None:
        """Add the command's arguments."""

    def run(self, args: Namespace, out: Output) -> int:
        """Run the command and return the exit code."""


def load(name: str) -> Command:
    """Import the command file of that name."""
    return cast(Command, import_module(f"{__package__}.{name}"))
