"""The `woosh` command. Only `main` prints, handles signals and decides the exit code."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run `woosh` with these arguments (default: `sys.argv`) and return the exit code."""
    from woosh_pure.cli.entry import main as command  # late: other packages import this one without it

    return command(argv)
