"""Each command and program that drives the robot with a watchdog, in a separate process that can be killed.

with driving("woosh web", sim, folder) as pid:      # the robot moves now
    os.kill(pid, signal.SIGKILL)
"""

from __future__ import annotations

import re
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from rosproto.codec import encode, message_class
from tests.support.waiting import until
from woosh_pure import SimulatedChassis

__all__ = ["COMMANDS", "children", "driving", "is_alive", "moving"]

ROOT = Path(__file__).resolve().parents[2]
SPEED = 0.2
TWIST = message_class("geometry_msgs/Twist")
PROGRAM = """
import sys, time
from woosh_pure import Chassis
what, more = sys.argv[2], {"watchdog": sys.argv[3] == "True"}
chassis = Chassis(sys.argv[1], **more)
if what == "task":
    chassis.go_to_mark("B1")
elif what == "goal":
    chassis.go_to(3.0, 0.0)
elif what == "steps":
    chassis.move(4.0)
else:
    drive = chassis.velocity(bypasses_protection=True)
    drive.__enter__().hold(0.2, seconds=60.0)
time.sleep(60.0)
"""


def moving(sim: SimulatedChassis) -> bool:
    """Whether the simulated robot moves."""
    with sim.lock:
        return not sim.world.body.velocity.is_standing()


def _until(condition: Callable[[], object], seconds: float = 60.0, what: str = "it moves") -> None:
    until(condition, seconds, what)


def _process(stack: ExitStack, *words: str, say: bool = True) -> subprocess.Popen[str]:
    process = subprocess.Popen(
        [sys.executable, "-u", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT if say else subprocess.DEVNULL,
        text=True,
        cwd=ROOT,
    )

    def end() -> None:
        process.kill()
        process.wait()
        assert process.stdout is not None
        process.stdout.close()

    stack.callback(end)
    return process


def _line(process: subprocess.Popen[str], pattern: str) -> str:
    """The first line that has the pattern; its first group."""
    assert process.stdout is not None
    said = ""
    for line in process.stdout:
        said += line
        if found := re.search(pattern, line):
            return found[1]
    raise AssertionError(f"it ended and said: {said}")


def _again(stack: ExitStack, work: Callable[[], object]) -> None:
    """Repeat a call ten times a second in a thread, until the end or an exception."""
    over = threading.Event()

    def run() -> None:
        while not over.wait(0.1):
            try:
                work()
            except Exception:  # its server has been killed
                return

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    stack.callback(thread.join, 5.0)
    stack.callback(over.set)


def _program(what: str) -> Callable[..., int]:
    def start(stack: ExitStack, sim: SimulatedChassis, folder: Path, *options: str) -> int:
        watched = str("--no-watchdog" not in options)
        return _process(stack, "-c", PROGRAM, sim.master_uri, what, watched).pid

    return start


def _web(stack: ExitStack, sim: SimulatedChassis, folder: Path, *options: str) -> int:
    from tests.support.web import PageClient

    words = ("web", "--master", sim.master_uri, "--port", "0", "--no-browser", "--allow-driving", *options)
    process = _process(stack, "-m", "woosh_pure", *words)
    port = int(_line(process, r"the page: http://127\.0\.0\.1:(\d+)"))
    page = stack.enter_context(PageClient(port))
    page.of("hello")
    page.ready()
    page.drive(SPEED)
    return process.pid


def _drive(stack: ExitStack, sim: SimulatedChassis, folder: Path, *options: str) -> int:
    from tests.support.terminal import Terminal

    words = ("--acknowledged", "--feedback-timeout", "2", *options)
    terminal = stack.enter_context(Terminal("drive", "--master", sim.master_uri, *words, columns=120))
    _again(stack, lambda: terminal.send("\x1b[A"))
    return terminal.process.pid


def _bridge(stack: ExitStack, sim: SimulatedChassis, folder: Path, *options: str) -> int:
    from tests.support.rosbridge_client import RosbridgeClient

    words = ("bridge", "--master", sim.master_uri, "--port", "0", "--allow-write", "*", *options)
    process = _process(stack, "-m", "rosproto", *words)
    client = RosbridgeClient(_line(process, r"(ws://\S+)"))
    client.send(op="advertise", topic="/smooth_cmd_vel", type="geometry_msgs/Twist")
    velocity = {"linear": {"x": SPEED}}
    _again(stack, lambda: client.send(op="publish", topic="/smooth_cmd_vel", msg=velocity))
    return process.pid


def _viewer(*command: str) -> Callable[..., int]:
    def start(stack: ExitStack, sim: SimulatedChassis, folder: Path, *options: str) -> int:
        from tests.support.viewer import Viewer

        process = _process(stack, "-m", *command, "--master", sim.master_uri, "--port", "0", *options)
        viewer = Viewer(_line(process, r"(ws://\S+)"))
        channel = viewer.advertise("/smooth_cmd_vel", "geometry_msgs/Twist")
        velocity: Any = TWIST()
        velocity.linear.x = SPEED
        _again(stack, lambda: viewer.publish(channel, encode(velocity)))
        return process.pid

    return start


def _robot_api(stack: ExitStack, sim: SimulatedChassis, folder: Path, *options: str) -> int:
    from tests.support.robot_api import ApiClient

    words = ("robot-api", "--master", sim.master_uri, "--port", "0", "--allow-write", "api:Twist", *options)
    process = _process(stack, "-m", "woosh_pure", *words)
    client = stack.enter_context(ApiClient(_line(process, r"(ws://\S+)")))
    _again(stack, lambda: client.answer({"type": "woosh.robot.Twist", "body": {"linear": SPEED}}))
    return process.pid


def _vda5050(stack: ExitStack, sim: SimulatedChassis, folder: Path, *options: str) -> int:
    from tests.support.fleet_master import Master, order_over
    from tests.support.mosquitto import mosquitto

    broker = stack.enter_context(mosquitto(folder))
    words = ("--broker", broker.url, "--serial", "A-17", "--map-id", "hall", "--state", str(folder))
    process = _process(stack, "-m", "woosh_pure", "vda5050", "--master", sim.master_uri, *words, *options)
    _line(process, r"(Ctrl-C ends it)")
    manager = stack.enter_context(Master(broker.port))
    manager.until(lambda state: state["agvPosition"]["positionInitialized"], 30.0)
    manager.send("order", order_over("o1", "n1 n2 n3"))
    return process.pid


COMMANDS: dict[str, Callable[..., int]] = {
    "woosh web": _web,
    "woosh drive": _drive,
    "rosproto bridge": _bridge,
    "rosproto foxglove": _viewer("rosproto", "foxglove", "--allow-write", "*"),
    "woosh foxglove": _viewer("woosh_pure", "foxglove", "--allow-driving"),
    "woosh robot-api": _robot_api,
    "woosh vda5050": _vda5050,
    "Chassis, velocity": _program("velocity"),
    "Chassis, goal": _program("goal"),
    "Chassis, steps": _program("steps"),
    "Chassis, task": _program("task"),
}


@contextmanager
def driving(command: str, sim: SimulatedChassis, folder: Path, *options: str) -> Iterator[int]:
    """Start the command and let it drive; yields its process id once the robot moves."""
    with ExitStack() as stack:
        pid = COMMANDS[command](stack, sim, folder, *options)
        _until(lambda: moving(sim), what=f"{command} drives")
        yield pid


def children(pid: int) -> list[int]:
    """Processes that it has started."""
    found = subprocess.run(
        ["ps", "-o", "pid=", "--ppid", str(pid)], capture_output=True, text=True, check=False
    )
    return [int(each) for each in found.stdout.split()]


def is_alive(pid: int) -> bool:
    """Whether a process is there and no zombie."""
    found = subprocess.run(["ps", "-o", "stat=", "-p", str(pid)], capture_output=True, text=True, check=False)
    return bool(found.stdout.strip()) and not found.stdout.startswith("Z")
