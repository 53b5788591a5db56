"""A person at a Windows console drives the simulator on Linux: keys, a typed Ctrl-C, the closed window.

Wine shows its console on the pseudo-terminal that it was started on, or in a window where there is a display.
"""

from __future__ import annotations

import sys
import time

import pytest

if sys.platform == "win32":
    pytest.skip("this is the Linux side", allow_module_level=True)

from tests.support.terminal import Terminal
from tests.windows.test_interop import RUN, windows_python
from woosh_pure import SimulatedChassis

__all__ = ["windows_python"]

pytestmark = [pytest.mark.interop, pytest.mark.slow, pytest.mark.timeout(300)]

# Keys as they come; Ctrl-C is a signal, which Wine makes the console's event of.
ON_TERMINAL = """
import fcntl, os, sys, termios, tty
tty.setraw(0)
mode = termios.tcgetattr(0)
mode[3] |= termios.ISIG
termios.tcsetattr(0, termios.TCSANOW, mode)
fcntl.ioctl(0, termios.TIOCSCTTY, 0)
os.execv(sys.argv[1], sys.argv[1:])
"""
LAUNCH = (sys.executable, "-c", ON_TERMINAL, RUN, "python", "-m")


def standing(sim: SimulatedChassis) -> bool:
    with sim.lock:
        return sim.world.body.velocity.is_standing()


def hold(terminal: Terminal, key: str, sim: SimulatedChassis, timeout: float = 30.0) -> None:
    """Repeat a key as a held one does, until the robot moves."""
    end = time.monotonic() + timeout
    while standing(sim):
        assert time.monotonic() < end, f"it does not move; the screen:\n{terminal.text}"
        terminal.send(key)
        time.sleep(0.04)


def test_ctrl_c_typed_while_a_key_is_held_stops_the_robot() -> None:
    with (
        SimulatedChassis(full_graph=False) as sim,
        Terminal(
            "drive", "--master", sim.master_uri, "--feedback-timeout", "5",
            columns=120, launch=LAUNCH,
        ) as terminal,
    ):  # fmt: skip
        terminal.wait_for("Type yes to drive:", timeout=90)
        terminal.send("yes\r")
        terminal.wait_for("sent +0.00", timeout=30)
        hold(terminal, "w", sim)
        terminal.send("\x03")
        end = time.monotonic() + 10.0
        while not standing(sim):
            assert time.monotonic() < end, terminal.text
            time.sleep(0.01)
        terminal.wait_for("interrupted", timeout=30)
        assert terminal.exit_code(60) == 130
