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

sys.path.append(str(Path(__file__).resolve().parents[2]))
from tests.support import process_state

FRAMEWORKS = ("QT_", "PYSIDE", "FLASK")
# What loading a framework changes by itself (Qt the locale, Flask the warnings); that we do not when imported has a
# test of its own. Threads and files are looked at in the end.
NOT_OURS = "locale builtins warnings collector codec_errors random_numbers import threads open_files at_exit"


def state() -> dict[str, object]:
    """What belongs to the application, but for what its frameworks change."""
    found = {
        name: value
        for name, value in process_state.state().items()
        if name.replace(" ", "_") not in NOT_OURS.split()
    }
    found["environment"] = {k: v for k, v in os.environ.items() if not k.startswith(FRAMEWORKS)}
    found["loggers"] = {
        k: v for k, v in found["loggers"].items() if k.startswith(("rosproto", "woosh_pure", "ros."))
    }
    found["path"] = (list(sys.meta_path), list(sys.path))
    return found


def main() -> None:
    del sys.argv[0]  # as by `python EXAMPLE`
    logging.basicConfig(level=logging.WARNING)  # the application's own
    asyncio.get_event_loop_policy()  # made when it is first asked for
    before = state()
    runpy.run_path(sys.argv[0], run_name="__main__")
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
        print("host unharmed", Path(sys.argv[0]).name)
    else:
        raise AssertionError("Ctrl-C did nothing")


if __name__ == "__main__":
    try:
        main()
    except SystemExit as end:
        raise AssertionError("the example ended the process") from end
