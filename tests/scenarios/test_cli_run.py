"""`woosh run --watch`: a program, its robot on a page, and what happens when the program ends or changes."""

from __future__ import annotations

import json
import os
import queue
import signal
import subprocess
import threading
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")

from tests.support.woosh_command import woosh_process
from woosh_pure import Chassis, SimulatedChassis

pytestmark = [
    pytest.mark.slow,
    pytest.mark.usefixtures("private_config"),
    pytest.mark.skipif(os.name == "nt", reason="Ctrl-C by a signal"),
]
LEAVES_A_GOAL = """
import os
from woosh_pure import Chassis
chassis = Chassis()
chassis.go_to_mark("B1")
chassis.measured_velocity.wait_for(lambda velocity: velocity.vx > 0.05, 20)
print("leaving", flush=True)
os._exit(3)  # as a crash: nothing of the program can stop the robot
"""
LEAVES_A_VELOCITY = """
import os, rospy
from geometry_msgs.msg import Twist
rospy.init_node("driver")
publisher = rospy.Publisher("/smooth_cmd_vel", Twist, queue_size=1)
while not publisher.get_num_connections():
    rospy.sleep(0.05)
twist = Twist()
twist.linear.x = 0.2
for _ in range(20):
    publisher.publish(twist)
    rospy.sleep(0.05)
print("leaving", flush=True)
os._exit(0)
"""


class Lines:
    """What a process prints, line by line."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self.seen: list[str] = []
        self._queue: queue.Queue[str] = queue.Queue()
        for stream in (process.stdout, process.stderr):
            threading.Thread(target=self._read, args=(stream,), daemon=True).start()

    def _read(self, stream: Iterator[str]) -> None:
        for line in stream:
            self._queue.put(line)

    def until(self, text: str, timeout: float = 40.0) -> str:
        """The next line with that text."""
        while True:
            line = self._queue.get(timeout=timeout)
            self.seen.append(line)
            if text in line:
                return line


@contextmanager
def running(*words: str) -> Iterator[Lines]:
    process = woosh_process(*words)
    try:
        yield Lines(process)
        process.send_signal(signal.SIGINT)
        assert process.wait(20) == 130
    finally:
        process.kill()
        process.wait(10)


@pytest.mark.parametrize(
    ("code", "exit_code"), [(LEAVES_A_GOAL, 3), (LEAVES_A_VELOCITY, 0)], ids=["goal", "velocity"]
)
def test_what_a_program_has_begun_ends_with_it(
    code: str, exit_code: int, tmp_path: Path, until: Callable[..., None]
) -> None:
    """Also where the robot is not this command's own, and the program ends without a word."""
    program = tmp_path / "program.py"
    program.write_text(code)
    words = ("run", "--watch", "--page-port", "0", str(program))
    with SimulatedChassis() as sim, running("--master", sim.master_uri, *words) as lines:
        lines.until("leaving")
        said = lines.until("the program has ended")
        assert f"exit code {exit_code}; " in said
        assert sim.world.motion is None
        until(lambda: sim.world.body.velocity.is_standing())


def test_sigterm_ends_the_program_too_and_stops_the_robot(tmp_path: Path, until: Callable[..., None]) -> None:
    program = tmp_path / "program.py"
    program.write_text(LEAVES_A_GOAL.replace("os._exit(3)", "import time; time.sleep(60)"))
    words = ("run", "--watch", "--page-port", "0", str(program))
    with SimulatedChassis() as sim:
        process = woosh_process("--master", sim.master_uri, *words)
        Lines(process).until("leaving")
        process.terminate()
        assert process.wait(20) == 143
        assert sim.world.motion is None
        until(lambda: sim.world.body.velocity.is_standing())


def test_the_page_shows_the_robot_and_a_changed_program_runs_again(tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    text = "import sys\nfrom woosh_pure import Chassis\nwith Chassis() as c:\n    print({!r}, sys.argv[1], c.pose.wait().x)\n"
    program.write_text(text.format("first"))
    with running("--sim", "run", "--watch", "--page-port", "0", str(program), "word") as lines:
        lines.until("a new simulated robot")
        page = lines.until("the page: ").split()[-1]
        assert lines.until("first") == "first word 0.0\n"
        lines.until("the program has ended with exit code 0")
        with urllib.request.urlopen(f"{page}api/v1/marks", timeout=20) as answer:
            assert "A1" in {mark["name"] for mark in json.load(answer)}
        program.write_text(text.format("second"))
        lines.until("second")
        lines.until("the program has ended")
        body, kind = json.dumps({"do": "reset"}).encode(), {"content-type": "application/json"}
        urllib.request.urlopen(urllib.request.Request(f"{page}api/v1/simulator", body, kind), timeout=20)
        lines.until("program.py starts again")
        lines.until("second")  # the reset of the page runs it again


def test_a_robot_that_somebody_moves_is_left_alone(tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text("")
    with SimulatedChassis() as sim, Chassis(sim.master_uri) as chassis:
        chassis.go_to_mark("B1")
        chassis.measured_velocity.wait_for(lambda velocity: velocity.vx > 0.05, 20)
        process = woosh_process(
            "--master", sim.master_uri, "run", "--watch", "--page-port", "0", str(program)
        )
        assert "the robot moves already" in process.communicate(timeout=30)[1]
        assert process.returncode == 3
        assert sim.world.motion is not None


def test_a_program_ends_when_the_command_that_watches_it_is_killed(
    tmp_path: Path, until: Callable[..., None]
) -> None:
    """By a pipe whose other end the system closes; the program is interrupted, and its `with` block stops the robot."""
    program = tmp_path / "program.py"
    program.write_text(
        "from woosh_pure import Chassis\nwith Chassis() as chassis:\n    handle = chassis.go_to_mark('B1')\n"
        "    chassis.measured_velocity.wait_for(lambda v: v.vx > 0.05, 20)\n"
        "    print('driving', flush=True)\n    handle.wait()\n"
    )
    words = ("run", "--watch", "--page-port", "0", str(program))
    with SimulatedChassis() as sim:
        process = woosh_process("--master", sim.master_uri, *words)
        Lines(process).until("driving")
        process.kill()
        process.wait(10)
        until(lambda: sim.world.motion is None, 10.0)
        until(lambda: sim.world.body.velocity.is_standing())
