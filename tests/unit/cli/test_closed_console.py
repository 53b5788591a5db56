"""The moment a Windows console is closed: the command ends as after Ctrl-Break, and is given the time for it."""

from __future__ import annotations

import signal
import threading
import time

import pytest

from rosproto.cli import signals
from rosproto.cli.signals import Terminated, close_handler, signals_unwind

NUMBER = getattr(signal, "SIGBREAK", signal.SIGTERM)


def test_a_closed_console_terminates_the_command_and_waits_for_its_end(monkeypatch) -> None:
    """With the handlers that the commands have. Windows ends the process as soon as this one has returned."""
    monkeypatch.setattr(signals, "_WINDOWS_PATIENCE", 60.0)
    done, answers, busy = threading.Event(), [], threading.Lock()
    handle = close_handler(done)

    def close() -> None:
        with busy:
            answers.append(handle(2))

    thread = threading.Thread(target=close)
    busy.acquire()
    thread.start()
    with signals_unwind(), pytest.raises(Terminated):
        go_on_for_a_minute(busy)
    assert answers == []
    done.set()
    thread.join(20)
    assert answers == [True]


def go_on_for_a_minute(busy: threading.Lock) -> None:
    """In calls of C only: raised inside `threading`, the exception would leave a lock of it taken or released twice.

    In slices: Windows' Python handles what it noted of a signal between two of them.
    """
    busy.release()
    for _ in range(6000):
        time.sleep(0.01)


@pytest.mark.parametrize("handler", [signal.SIG_IGN, signal.SIG_DFL])
def test_while_the_signal_is_ignored_a_closed_console_only_waits(monkeypatch, handler) -> None:
    """A motion is being stopped already: that must not be interrupted."""
    monkeypatch.setattr(signal, "raise_signal", lambda number: pytest.fail(f"raised {number}"))
    before = signal.signal(NUMBER, handler)
    try:
        done = threading.Event()
        done.set()
        assert close_handler(done)(2) is True
    finally:
        signal.signal(NUMBER, before)


@pytest.mark.parametrize("event", [0, 1])
def test_ctrl_c_and_ctrl_break_are_left_to_python(event) -> None:
    assert close_handler(threading.Event())(event) is False
