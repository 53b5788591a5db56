"""stop() of a program that can start no thread, open no file, or write to nobody: the robot stands all the same."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.load import crowd
from woosh_pure import SimulatedChassis

pytestmark = pytest.mark.skipif(os.name == "nt", reason="limits and pipes as POSIX has them")
ROOT = Path(__file__).resolve().parents[2]
PROGRAM = """
import logging, os, resource, sys, threading
from woosh_pure import Chassis
chassis = Chassis(sys.argv[1])
what, lacks = sys.argv[2:]
if what == "velocity":
    drive = chassis.velocity(bypasses_protection=True).__enter__()
    drive.set(0.05, valid_for=5.0)
    threading.Thread(target=lambda: drive.hold(0.05, seconds=99), daemon=True).start()
else:
    handle = {"goal": lambda: chassis.go_to(2.5, 0.0), "steps": lambda: chassis.move(2.0),
              "task": lambda: chassis.go_to_mark("B1")}[what]()
print("moving", flush=True)
sys.stdin.readline()

def no_threads():
    def refuse(self):
        raise RuntimeError("can't start new thread")
    threading.Thread.start = refuse

def no_files():
    resource.setrlimit(resource.RLIMIT_NOFILE, (256, 256))
    try:
        while True:
            os.dup(0)
    except OSError:
        pass

def full_output():
    logging.basicConfig(level=logging.DEBUG)  # to standard error, which nobody reads
    os.set_blocking(2, False)
    try:
        while True:
            os.write(2, b"x")
    except BlockingIOError:
        os.set_blocking(2, True)

for lack in lacks.split("+"):
    {"threads": no_threads, "files": no_files, "output": full_output}[lack]()
report = chassis.stop(timeout=2.0)
os.write(1, f"stopped: {report.standing} {report.problems}\\n".encode())
sys.stdin.readline()
os._exit(0)
"""


@pytest.fixture
def begun(sim: SimulatedChassis) -> Iterator[list[subprocess.Popen[str]]]:
    processes: list[subprocess.Popen[str]] = []
    yield processes
    for process in processes:
        process.kill()
        process.communicate()


@pytest.mark.promise("the system gives no more threads or files")
@pytest.mark.parametrize(
    "lacks",
    ["threads", "files", "output", pytest.param("threads+files+output", marks=pytest.mark.slow)],
)
@pytest.mark.parametrize(
    "what",
    ["velocity", "task", *(pytest.param(other, marks=pytest.mark.whole) for other in ("goal", "steps"))],
)
def test_the_robot_stands(sim, real_time, until, begun, what, lacks):
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, sim.master_uri, what, lacks],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    begun.append(process)
    assert process.stdin is not None
    assert process.stdout is not None
    assert process.stdout.readline() == "moving\n"
    until(lambda: not sim.world.body.velocity.is_standing())
    process.stdin.write("now\n")
    process.stdin.flush()
    until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0), 4.0 * crowd(), "standing")
    assert process.stdout.readline().startswith("stopped: ")  # it returned, and raised nothing
    assert sim.world.motion is None
    assert not sim.world.tasks.busy
    assert sim.world.body.velocity.is_standing(0.0, 0.0)
