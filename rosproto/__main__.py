"""The process of the `rosproto` command, which `python -m rosproto` is, too."""

from __future__ import annotations

import sys

from rosproto.startup import exit_on_interrupt


def main() -> int:
    """Run the command with the arguments of this process; return the exit code."""
    exit_on_interrupt()
    from rosproto.cli import main as command  # late: Ctrl-C during this import is handled

    return command()


if __name__ == "__main__":
    sys.exit(main())
