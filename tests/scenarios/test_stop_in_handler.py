"""stop() and close() in a signal handler: the interrupted frame may hold any lock, and goes on only afterwards.

A trace function stands for the handler here: it, too, is called on top of a frame that waits for it, at every line of
Python instead of at a random one.
"""

from __future__ import annotations

import io
import logging
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from types import FrameType
from typing import Any

import pytest

from rosproto.errors import ConnectionLost
from tests.support.load import crowd
from woosh_pure import Chassis, MotionRefused, SimulatedChassis

pytestmark = pytest.mark.skipif(
    sys.gettrace() is not None, reason="a debugger or coverage has the trace function"
)
STANDS = 0.5  # seconds from the handler's first line, on a quiet computer
RETURNS = (
    8.0  # seconds; with a lock that is held what cannot be seen meanwhile is not known, and is not waited for
)


class Handler:
    """Calls `act` once, at one of the lines that the traced call runs; with 0 only counts them."""

    def __init__(self, line: int, act: Callable[[], object]) -> None:
        self.lines = 0
        self.took: float | None = None
        self._line = line
        self._act = act

    def __call__(self, frame: FrameType, event: str, argument: object) -> Any:
        if event == "line":
            self.lines += 1
            if self.lines == self._line:
                began = time.monotonic()
                self._act()
                self.took = time.monotonic() - began
        return None if self.took is not None else self

    def over(self, call: Callable[[], object]) -> None:
        """Run a call with this handler."""
        before = sys.gettrace()
        sys.settrace(self)
        try:
            call()
        except (MotionRefused, RuntimeError, ConnectionError):
            assert self.took is not None  # the drive, or the Chassis, is over
        finally:
            sys.settrace(before)


class Standing:
    """Notes when the simulated robot stood first, since it was made."""

    def __init__(self, sim: SimulatedChassis) -> None:
        self._sim = sim
        self._over = threading.Event()
        self._began = time.monotonic()
        self.after: float | None = None
        self._thread = threading.Thread(target=self._look, daemon=True)
        self._thread.start()

    def _look(self) -> None:
        while not self._over.wait(0.005):
            if self._sim.world.body.velocity.is_standing(0.0, 0.0):
                self.after = time.monotonic() - self._began
                return

    def end(self) -> float | None:
        self._thread.join(2.0)
        self._over.set()
        return self.after


def lines_of(call: Callable[[], object], count: int) -> list[int]:
    """So many of the lines that a call runs, over all of it."""
    counter = Handler(0, lambda: None)
    counter.over(call)
    lines = counter.lines
    return sorted({1 + round(each * (lines - 1) / max(1, count - 1)) for each in range(count)})


def drive_calls(chassis: Chassis, drive: Any) -> dict[str, Callable[[], object]]:
    return {
        "set": lambda: drive.set(0.05, valid_for=5.0),
        "hold": lambda: drive.hold(0.05, seconds=0.05),
        "sending": lambda: (drive.sending, drive.active, repr(drive)),
        "feed": lambda: (chassis.measured_velocity.wait(1.0), chassis.measured_velocity.history),
        "readiness": chassis.readiness,
        "logging": lambda: logging.getLogger("woosh_pure.velocity").warning("a line"),
    }


@pytest.fixture
def logs() -> Iterator[None]:
    """Log lines go somewhere, so that a handler's lock is taken for them."""
    handler = logging.StreamHandler(io.StringIO())
    logger = logging.getLogger("woosh_pure")
    logger.addHandler(handler)
    yield
    logger.removeHandler(handler)


@pytest.mark.promise("`stop()` or `close()` in a signal handler")
@pytest.mark.parametrize(
    "name",
    [
        *(pytest.param(name, marks=pytest.mark.slow) for name in ("set", "hold", "sending", "feed")),
        "readiness",
        "logging",
    ],
)
def test_stop_over_any_line_of_a_drive(sim, chassis, until, logs, name):
    with chassis.velocity(bypasses_protection=True) as drive:
        drive.set(0.05, valid_for=5.0)
        lines = lines_of(drive_calls(chassis, drive)[name], 10)
    for line in lines:
        with suppress(MotionRefused), chassis.velocity(bypasses_protection=True) as drive:
            drive.set(0.05, valid_for=5.0)
            until(lambda: not sim.world.body.velocity.is_standing())
            seen: list[Standing] = []
            handler = Handler(line, lambda seen=seen: (seen.append(Standing(sim)), chassis.stop(timeout=2.0)))
            handler.over(drive_calls(chassis, drive)[name])
            if handler.took is None:
                continue  # this time it took fewer lines
            after = seen[0].end()
            assert after is not None, f"line {line}: the robot drives on"
            assert after < STANDS * crowd(), f"line {line}"
            assert handler.took < RETURNS, f"line {line}"
            assert not drive.active


@pytest.mark.promise("`stop()` or `close()` in a signal handler")
@pytest.mark.parametrize("verb", ["go_to", "go_to_mark", "move"])
@pytest.mark.parametrize("name", ["done", "wait", "progress", "readiness", "cancel"])
def test_stop_over_any_line_of_a_goal(sim, chassis, until, name, verb):
    def begin() -> Any:
        handle = {
            "go_to": lambda: chassis.go_to(2.5, 0.0),
            "go_to_mark": lambda: chassis.go_to_mark("B1"),
            "move": lambda: chassis.move(2.0),
        }[verb]()
        until(lambda: not sim.world.body.velocity.is_standing())
        return handle

    def call(handle: Any) -> Callable[[], object]:
        return {
            "done": lambda: (handle.done, handle.latest_report, repr(handle), str(handle.progress)),
            "wait": lambda: handle.wait(0.0, raises=False),
            "progress": lambda: next(handle.reports(), None),
            "readiness": chassis.readiness,
            "cancel": handle.cancel,
        }[name]

    sim.speed = 1.0
    try:
        handle = begin()
        lines = lines_of(call(handle), 5)
        handle.cancel()
        for line in lines:
            until(lambda: sim.world.motion is None and not sim.world.tasks.busy)
            handle = begin()
            seen: list[Standing] = []
            act = lambda seen=seen: (seen.append(Standing(sim)), chassis.stop(timeout=2.0))  # noqa: E731
            handler = Handler(line, act)
            handler.over(call(handle))
            if handler.took is None:
                handle.cancel()
                continue
            after = seen[0].end()
            assert after is not None, f"line {line}: the robot drives on"
            assert after < (STANDS + 0.5) * crowd(), f"line {line}"  # a goal is braked for
            assert handler.took < RETURNS, f"line {line}"
            assert handle.done
    finally:
        sim.speed = 8.0


@pytest.mark.promise("`stop()` or `close()` in a signal handler")
@pytest.mark.parametrize("name", ["set", "feed", "readiness"])
def test_close_over_any_line(sim, until, name):
    for share in (0.1, 0.35, 0.6, 0.85):
        chassis = Chassis(sim.master_uri)
        drive = chassis.velocity(bypasses_protection=True).__enter__()
        call = drive_calls(chassis, drive)[name]
        drive.set(0.05, valid_for=5.0)
        line = max(1, round(lines_of(call, 2)[-1] * share))
        drive.set(0.05, valid_for=5.0)
        until(lambda: not sim.world.body.velocity.is_standing())
        seen: list[Standing] = []
        handler = Handler(
            line, lambda seen=seen, chassis=chassis: (seen.append(Standing(sim)), chassis.close())
        )
        handler.over(call)
        if handler.took is not None:
            after = seen[0].end()
            assert after is not None, f"line {line}: the robot drives on"
            assert after < STANDS * crowd(), f"line {line}"
            assert handler.took < 2 * RETURNS, f"line {line}"
        chassis.close()


@pytest.mark.slow
@pytest.mark.promise("`stop()` or `close()` in a signal handler")
@pytest.mark.skipif(os.name == "nt", reason="has POSIX timers")
def test_a_real_signal_at_a_random_moment_of_a_loop_that_drives(sim, chassis, until):
    stopped = 0
    for _ in range(30):
        # A computer that did not run this for a second has ended the drive by itself: then once more.
        with suppress(MotionRefused, ConnectionLost), chassis.velocity(bypasses_protection=True) as drive:
            until(
                lambda drive=drive: (
                    drive.set(0.05, valid_for=5.0) or not sim.world.body.velocity.is_standing()
                )
            )
            seen: list[Standing] = []
            took: list[float] = []

            def handle(number: int, frame: object, seen: Any = seen, took: Any = took) -> None:
                began = time.monotonic()
                seen.append(Standing(sim))
                chassis.stop(timeout=2.0)
                took.append(time.monotonic() - began)

            before = signal.signal(signal.SIGALRM, handle)
            signal.setitimer(signal.ITIMER_REAL, 0.02)
            try:
                while not took:
                    drive.set(0.05, valid_for=5.0)
            except MotionRefused:
                pass
            finally:
                signal.setitimer(signal.ITIMER_REAL, 0.0)
                signal.signal(signal.SIGALRM, before)
            after = seen[0].end()
            assert after is not None, "the robot drives on"
            assert after < STANDS * crowd()
            assert took[0] < RETURNS
            stopped += 1
        if stopped == 10:
            break
    assert stopped == 10
