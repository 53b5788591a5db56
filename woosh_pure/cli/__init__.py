"""The `woosh` command. Only `main` prints, handles signals and decides the exit code."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run `woosh` with these arguments (by default the process's own); the exit code."""
    try:
        from woosh_pure.cli.entry import main as command  # late: Ctrl-C while it loads is no traceback either
    except KeyboardInterrupt:
        return 130
    return command(argv)
