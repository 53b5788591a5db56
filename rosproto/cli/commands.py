"""The sub-commands of `rosproto`, one module each.

A command module has

    def add_arguments(parser: argparse.ArgumentParser) -> None: ...
    def run(arguments: argparse.Namespace) -> int: ...        # exit code

and a line here. Only the module of the command that is run gets imported, so `rosproto master` starts without
what `rosproto topic` needs.
"""

from __future__ import annotations

import argparse
import importlib
from collections.abc import Callable
from typing import NamedTuple

__all__ = ["COMMANDS", "Command"]


class Command(NamedTuple):
    """One sub-command.

    Attributes:
        module: Where its functions are.
        help: One line for `rosproto --help`.
    """

    module: str
    help: str

    def load(
        self,
    ) -> tuple[Callable[[argparse.ArgumentParser], None], Callable[[argparse.Namespace], int]]:
        """Import it; its `add_arguments` and `run`."""
        module = importlib.import_module(self.module)
        return module.add_arguments, module.run


COMMANDS: dict[str, Command] = {
    "master": Command("rosproto.cli.master", "run a ROS master (what roscore does) until interrupted"),
}
