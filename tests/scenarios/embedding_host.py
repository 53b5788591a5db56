"""Runs an example in a process that looks after itself: what it had before is there afterwards.

`python embedding_host.py EXAMPLE`; the last line is "host unharmed", or an AssertionError says what was taken.
"""

import asyncio
import logging
import os
import runpy
import signal
import sys
import threading
import time
from pathlib import Path


def state() -> dict[str, object]:
    """What belongs to the application: signals, logging, hooks, working directory, time-outs."""
    numbers = [n for n in (signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", None)) if n is not None]
    levels = {name: getattr(logging.getLogger(name), "level", 0) for name in ("", "rosproto", "woosh_pure")}
    return {
        "signals": [signal.getsignal(n) for n in numbers],
        "wakeup": signal_wakeup(),
        "log handlers": list(logging.root.handlers),
        "log levels": levels,
        "log disabled": logging.root.manager.disable,
        "hooks": (sys.excepthook, threading.excepthook, sys.displayhook, sys.unraisablehook),
        "directory": os.getcwd(),
        "environment": {k: v for k, v in os.environ.items() if not k.startswith(("QT_", "PYSIDE", "FLASK"))},
        "socket timeout": __import__("socket").getdefaulttimeout(),
        "recursion": sys.getrecursionlimit(),
        "switch interval": sys.getswitchinterval(),
    }


def signal_wakeup() -> int:
    number = signal.set_wakeup_fd(-1)
    signal.set_wakeup_fd(number)
    return number


def main() -> None:
    logging.basicConfig(level=logging.WARNING)  # the application's own
    before = state()
    asyncio.get_event_loop_policy()
    runpy.run_path(sys.argv[1], run_name="__main__")
    after = state()
    assert after == before, {k: (before[k], after[k]) for k in before if before[k] != after[k]}
    end = time.monotonic() + 5
    while left := [t.name for t in threading.enumerate() if t.name.startswith("rosproto:")]:
        assert time.monotonic() < end, left
        time.sleep(0.05)
    assert not [t for t in threading.enumerate() if t is not threading.main_thread() and not t.daemon]
    # Ctrl-C is still the application's.
    try:
        signal.raise_signal(signal.SIGINT)
        time.sleep(5)
    except KeyboardInterrupt:
        print("host unharmed", Path(sys.argv[1]).name)
    else:
        raise AssertionError("Ctrl-C did nothing")


if __name__ == "__main__":
    try:
        main()
    except SystemExit as end:
        raise AssertionError("the example ended the process") from end
