"""The process state that libraries must not change, as one comparable value; and a change of each part of it.

`python -m tests.support.process_state` makes every change and lists those that `state()` did not detect.
"""

from __future__ import annotations

import asyncio
import atexit
import builtins
import codecs
import decimal
import faulthandler
import gc
import locale
import logging
import os
import random
import signal
import socket
import sys
import threading
import time
import warnings
from typing import Any

__all__ = ["PLANTS", "changes", "state"]


def state() -> dict[str, Any]:
    """Everything by name; equal before and after what only imports or cleans up behind itself."""
    umask = os.umask(0)
    os.umask(umask)
    wakeup = signal.set_wakeup_fd(-1)
    signal.set_wakeup_fd(wakeup)
    return {
        "signals": {number: signal.getsignal(number) for number in signal.valid_signals()},
        "signal wakeup": wakeup,
        "threads": [thread.name for thread in threading.enumerate()],
        "open files": sorted(os.listdir("/proc/self/fd")) if sys.platform.startswith("linux") else [],
        "environment": dict(os.environ),
        "directory": os.getcwd(),
        "umask": umask,
        "locale": locale.setlocale(locale.LC_ALL),
        "time zone": time.tzname,
        **logs(),
        "hooks": (sys.excepthook, threading.excepthook, sys.unraisablehook, sys.displayhook, sys.breakpointhook),
        "tracing": (sys.gettrace(), sys.getprofile(), threading._trace_hook, threading._profile_hook),  # type: ignore[attr-defined]
        "streams": (sys.stdin, sys.stdout, sys.stderr, sys.stdout.encoding, sys.stdout.errors),
        "import": (list(sys.path), list(sys.meta_path), list(sys.path_hooks), sys.dont_write_bytecode, list(sys.argv)),
        "builtins": sorted(vars(builtins)),
        "warnings": list(warnings.filters),
        "at exit": atexit._ncallbacks(),
        "collector": (gc.isenabled(), gc.get_threshold(), list(gc.callbacks), gc.get_freeze_count(), gc.get_debug()),
        "random numbers": random.getstate(),
        "decimal": str(decimal.getcontext()),
        "socket timeout": socket.getdefaulttimeout(),
        "switch interval": sys.getswitchinterval(),
        "recursion": sys.getrecursionlimit(),
        "integer digits": getattr(sys, "get_int_max_str_digits", int)(),
        "stack size": threading.stack_size(),
        "fault handler": faulthandler.is_enabled(),
        "event loop policy": getattr(asyncio.events, "_event_loop_policy", None),
        "codec errors": codecs.lookup_error("strict"),
    }  # fmt: skip


def logs() -> dict[str, Any]:
    """Handlers and levels of every logger; ours may exist, without either."""
    loggers = {
        name: (logger.level, logger.propagate, logger.disabled, list(logger.handlers))
        for name, logger in logging.root.manager.loggerDict.items()
        if isinstance(logger, logging.Logger)
    }
    untouched = (0, True, False, [])
    return {
        "log root": (logging.root.level, list(logging.root.handlers), logging.root.manager.disable),
        "loggers": {name: value for name, value in loggers.items() if value != untouched},
        "log classes": (logging.getLoggerClass(), logging.getLogRecordFactory(), logging.raiseExceptions),
        "log levels": [logging.getLevelName(level) for level in range(60)],
    }


PLANTS = {
    "signals": "signal.signal(signal.SIGTERM, lambda *_: None)",
    "threads": "threading.Thread(target=threading.Event().wait, daemon=True).start()",
    "open files": "kept = socket.socket()",
    "environment": "os.environ['PLANTED'] = '1'",
    "directory": "os.chdir('/')",
    "umask": "os.umask(0o55)",
    "locale": "locale.setlocale(locale.LC_ALL, 'C.UTF-8' if locale.setlocale(locale.LC_ALL) == 'C' else 'C')",
    "log root": "logging.basicConfig()",
    "loggers": "logging.getLogger('rosproto').setLevel(10)",
    "log classes": "logging.raiseExceptions = False",
    "log levels": "logging.addLevelName(5, 'TRACE')",
    "hooks": "sys.excepthook = lambda *_: None",
    "tracing": "threading.settrace(lambda *_: None)",
    "streams": "sys.stdout.reconfigure(errors='replace')",
    "import": "sys.path.append('/planted')",
    "builtins": "builtins.planted = 1",
    "warnings": "warnings.simplefilter('ignore')",
    "at exit": "atexit.register(print, end='')",
    "collector": "gc.set_threshold(701)",
    "random numbers": "random.random()",
    "decimal": "decimal.getcontext().prec = 5",
    "socket timeout": "socket.setdefaulttimeout(77)",
    "switch interval": "sys.setswitchinterval(0.001)",
    "recursion": "sys.setrecursionlimit(4321)",
    "stack size": "threading.stack_size(1 << 20)",
    "fault handler": "faulthandler.enable()",
    "event loop policy": "asyncio.set_event_loop_policy(asyncio.DefaultEventLoopPolicy())",
}
"""A statement that changes each part."""


def changes(before: dict[str, Any], after: dict[str, Any]) -> dict[str, tuple[Any, Any]]:
    """The parts that differ, as (before, after)."""
    return {name: (value, after[name]) for name, value in before.items() if after[name] != value}


def main() -> None:
    """Plant one change after the other."""
    planted = dict(globals())
    warnings.simplefilter("ignore", DeprecationWarning)
    for name, statement in PLANTS.items():
        if name == "open files" and not sys.platform.startswith("linux"):
            continue  # nobody tells them there
        before = state()
        exec(statement, planted)
        assert name in changes(before, state()), f"{name}: {statement} was not seen"
    print("all seen")


if __name__ == "__main__":
    main()
