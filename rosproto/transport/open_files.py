"""How many files a process may have open, sockets included.

Terminals of macOS start programs with 256, Linux usually with 1024; Windows has no such number for sockets.
"""

from __future__ import annotations

import sys


def open_file_limit() -> int | None:
    """How many files this process may have open; None where there is no such number, or nobody tells."""
    if sys.platform == "win32":
        return None
    try:
        import resource
    except (ImportError, OSError):
        return None  # no file is left to read the module from
    soft = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    return None if soft == resource.RLIM_INFINITY else soft


def allow_open_files(count: int) -> None:
    """Have the system allow this process `count` open files, when it allows fewer and lets itself be asked.

    This is for commands, which own their process, and for simulated robots, which are many nodes in one.
    """
    if sys.platform == "win32":
        return
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    unlimited = resource.RLIM_INFINITY
    if soft == unlimited or soft >= count:
        return
    wanted = count if hard == unlimited else min(count, hard)
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
    except (OSError, ValueError):
        pass  # the limit stays; opening one too many raises an error that says so
