"""How a program ends, and what the robot does then: Ctrl-C in every wait, SIGTERM, SIGKILL, an error in a thread."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(os.name == "nt", reason="sends POSIX signals to a process")

ROOT = Path(__file__).resolve().parents[2]
BEGIN = """
import signal, sys, threading, time
from woosh_pure import Chassis, MotionRefused
from woosh_pure.enums import RobotState
signal.signal(signal.SIGINT, signal.default_int_handler)
"""
MOVING = "handle = chassis.go_to(2.5, 0.0); chassis.measured_velocity.wait_for(lambda v: v.vx > 0.05, 20)"
# Each of these would wait for ever.
WAITS = {
    "handle.wait": f"{MOVING}; print('waiting', flush=True); handle.wait(None)",
    "handle.progress": f"{MOVING}; print('waiting', flush=True)\\n    for _ in handle.reports(): pass",
    "feed.wait": f"{MOVING}; print('waiting', flush=True); chassis.feed('/lift').wait(None)",
    "feed.wait_for": f"{MOVING}; print('waiting', flush=True); chassis.odometer.wait_for(lambda v: False, None)",
    "for in feed": f"{MOVING}; print('waiting', flush=True)\\n    for _ in chassis.feed('/lift'): pass",
    "wait_until": f"{MOVING}; print('waiting', flush=True); chassis.wait_until(lambda s: False, None)",
    "drive.hold": (
        "with chassis.velocity(bypasses_protection=True) as drive:\\n        drive.set(0.2)\\n"
        "        print('waiting', flush=True)\\n        drive.hold(0.2, seconds=999)"
    ),
}


def program(body):
    return BEGIN + "with Chassis(sys.argv[1]) as chassis:\n    " + body.replace("\\n", "\n") + "\n"


def start(code, uri):
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.Popen(
        [sys.executable, "-c", code, uri],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
    )


def end(process, number, timeout=30.0):
    """Send a signal when the program waits; (exit code, standard error)."""
    assert process.stdout is not None
    try:
        assert process.stdout.readline() == "waiting\n"
        process.send_signal(number)
        _, errors = process.communicate(timeout=timeout)
    finally:
        if process.poll() is None:
            process.kill()
            process.communicate()
    return process.returncode, errors


@pytest.mark.promise("Ctrl-C in a program that uses `with`")
@pytest.mark.parametrize("wait", WAITS, ids=str)
def test_ctrl_c_ends_every_wait_and_stops_the_robot(sim, real_time, until, wait):
    code, errors = end(start(program(WAITS[wait]), sim.master_uri), signal.SIGINT)
    assert code != 0
    assert errors.rstrip().endswith("KeyboardInterrupt")
    until(lambda: sim.world.motion is None and sim.world.body.velocity.is_standing(0.0, 0.0))
    assert sim.pose.x < 2.0


@pytest.mark.promise("SIGTERM to a program of yours")
def test_a_program_that_turns_sigterm_into_an_exit_stops_the_robot(sim, until):
    """As the documentation says that a program must: the library sets no signal handler."""
    body = (
        "signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))\n    with chassis.velocity(bypasses_protection=True) as "
        "drive:\n        drive.set(0.1)\n        print('waiting', flush=True)\n        drive.hold(0.1, seconds=999)"
    )
    code, _ = end(start(program(body), sim.master_uri), signal.SIGTERM)
    assert code == 1
    until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0))


@pytest.mark.promise("SIGTERM to a program of yours")
@pytest.mark.parametrize("number", [signal.SIGTERM, getattr(signal, "SIGKILL", 9)])
def test_a_goal_of_a_killed_program_goes_on_and_another_program_can_stop_it(
    sim, real_time, chassis, until, number
):
    """Nothing of ours runs any more; what was begun is the chassis's own business, and is documented so."""
    body = "chassis.go_to_mark('B1')\n    print('waiting', flush=True)\n    time.sleep(99)"
    end(start(program(body), sim.master_uri), number)
    until(lambda: not sim.world.body.velocity.is_standing())
    report = chassis.stop(everything=True)
    assert report.standing is True
    assert not sim.world.tasks.busy


def test_an_error_in_the_main_thread_stops_what_another_thread_drives(sim, until):
    body = (
        "def work():\n        with chassis.velocity(bypasses_protection=True) as drive:\n"
        "            drive.hold(0.1, seconds=999)\n    threading.Thread(target=work, daemon=True).start()\n"
        "    chassis.measured_velocity.wait_for(lambda v: v.vx > 0.02, 20)\n    print('waiting', flush=True)\n"
        "    raise RuntimeError('oops')"
    )
    code, errors = end(start(program(body), sim.master_uri), 0)
    assert code == 1
    assert "RuntimeError: oops" in errors
    until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0))
