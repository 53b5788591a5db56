"""The `woosh` command. `main` owns its process: it alone prints, minds signals and decides the exit code."""

from __future__ import annotations

import sys

TYPE_CHECKING = False  # as in typing, which `--help` does not wait for
if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run `woosh` with these arguments (by default the process's own); the exit code."""
    try:
        if argv is None:
            from rosproto.cli import show_bare_help

            code = show_bare_help(__file__, sys.argv[1:])
            if code is not None:
                return code
        from woosh_pure.cli.entry import main as command  # late: Ctrl-C while it loads is no traceback either
    except KeyboardInterrupt:
        return 130
    return command(argv)
