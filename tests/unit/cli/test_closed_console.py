"""The moment a Windows console is closed: the command ends as after Ctrl-Break, and is given the time for it."""

from __future__ import annotations

import signal
import threading

import pytest

from rosproto.cli.closed_console import close_handler
from rosproto.cli.failure import Terminated, signals_unwind

NUMBER = getattr(signal, "SIGBREAK", signal.SIGTERM)


def test_a_closed_console_terminates_the_command_and_waits_for_its_end() -> None:
    """With the handlers that the commands have. Windows ends the process as soon as this one has returned."""
    done, never, answers = threading.Event(), threading.Event(), []
    handle = close_handler(done)
    thread = threading.Thread(target=lambda: answers.append(handle(2)))

    def close_and_go_on() -> None:
        thread.start()
        wait_in_slices(never, 5.0)

    with signals_unwind(), pytest.raises(Terminated):
        close_and_go_on()
    assert answers == []
    done.set()
    thread.join(5.0)
    assert answers == [True]


def wait_in_slices(event: threading.Event, seconds: float) -> None:
    """Windows' Python handles what it noted of a signal between two waits."""
    for _ in range(int(seconds / 0.01)):
        event.wait(0.01)


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
