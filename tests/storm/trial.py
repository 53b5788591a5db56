"""One trial: a program begins to move the robot, is interrupted again and again, and ends. Then the robot stands."""

from __future__ import annotations

import os
import pty
import random
import signal
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path

from tests.storm.nursery import Child, Nursery
from tests.storm.programs import Program
from tests.support.robot_pool import Robot
from woosh_pure import SimulatedChassis

__all__ = ["Outcome", "Trial", "run"]

SLOW = 0.2  # s each way
PATIENCE = 40.0  # s for a program to end: what it may take by its own bounds, on a loaded computer
STANDS_WITHIN = 2.0  # s after the end of the program, and after that it must go on standing
STANDS_FOR = 0.7


@dataclass(frozen=True)
class Trial:
    """What to do.

    Attributes:
        program: The program.
        slow: On a slow network.
        moving: The storm begins when the robot moves (or soon after), else at any moment.
        pauses: Seconds before each SIGINT.
    """

    program: Program
    slow: bool
    moving: bool
    pauses: tuple[float, ...]

    @classmethod
    def draw(cls, luck: random.Random, program: Program) -> Trial:
        """At random: two to forty interrupts, half a millisecond to some tenths of a second apart."""
        first = luck.uniform(0.0, 0.8)
        mean = luck.choice((0.0005, 0.002, 0.003, 0.01, 0.1))
        rest = [luck.uniform(0.0, 2.0 * mean) for _ in range(luck.randint(1, 39 if mean < 0.05 else 9))]
        return cls(program, luck.random() < 0.25, luck.random() < 0.6, (first, *rest))

    def __str__(self) -> str:
        mean = sum(self.pauses[1:]) / max(1, len(self.pauses) - 1)
        when = "moving" if self.moving else "begun"
        slow = ", slow network" if self.slow else ""
        return (
            f"{self.program.name}{slow}; {len(self.pauses)} SIGINTs, {mean * 1000:.1f} ms apart, from "
            f"{self.pauses[0]:.3f} s after it has {when}"
        )


@dataclass(frozen=True)
class Outcome:
    """What came of it.

    Attributes:
        problem: "" when the robot stands.
        moved: It was moving when the first interrupt was sent.
        seconds: From the first interrupt to the end of the program.
        said: What the program wrote.
    """

    problem: str
    moved: bool
    seconds: float
    said: str


def run(trial: Trial, robot: Robot, nursery: Nursery) -> Outcome:
    """Do it, with a robot that is as good as new."""
    sim = robot.sim
    robot.renew(1.0)
    sim.slow_network(SLOW if trial.slow else 0.0)
    master, slave = pty.openpty() if trial.program.terminal else (-1, -1)
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "said"
        terminal = os.ttyname(slave) if slave >= 0 else ""
        child = nursery.start(trial.program.code, sim.master_uri, str(output), terminal)
        over = threading.Event()
        keys = None
        if master >= 0:
            keys = threading.Thread(target=_press, args=(master, output, over))
            keys.start()
        try:
            moved, seconds, problem = _interrupt(trial, sim, child, output)
        finally:
            over.set()
            if not child.ended():
                child.interrupt(signal.SIGKILL)
            status = child.reap()
            if keys is not None:
                keys.join()
                os.close(master)
                os.close(slave)
        said = output.read_text("utf-8", "replace") if output.exists() else ""
    problem = problem or _still_moves(sim)
    sim.slow_network(0.0)
    if problem:
        problem += f" (exit status {status})"
    return Outcome(problem, moved, seconds, said)


def _interrupt(trial: Trial, sim: SimulatedChassis, child: Child, output: Path) -> tuple[bool, float, str]:
    if trial.program.terminal:
        _until(lambda: _moves(sim) or child.ended(), 20.0)
    else:
        _until(lambda: child.ended() or (output.exists() and "begin" in output.read_text()), 20.0)
    if trial.moving:
        _until(lambda: _moves(sim) or child.ended(), 10.0)
    first, *rest = trial.pauses
    time.sleep(first * (0.3 if trial.moving else 1.0))
    moved, began = _moves(sim), time.monotonic()
    child.interrupt()
    for pause in rest:
        time.sleep(pause)
        if child.ended():
            break
        child.interrupt()
    ended = _until(child.ended, PATIENCE)
    seconds = time.monotonic() - began
    return moved, seconds, "" if ended else f"the program has not ended within {PATIENCE:g} s"


def _press(master: int, output: Path, over: threading.Event) -> None:
    """Hold a key on the terminal, and read what is written there."""
    os.set_blocking(master, False)
    while not over.wait(0.05):
        try:
            os.write(master, b"w")
            os.read(master, 65536)
        except OSError:
            continue


def _moves(sim: SimulatedChassis) -> bool:
    with sim.lock:
        return not sim.world.body.velocity.is_standing(0.0, 0.0)


def _is_free(sim: SimulatedChassis) -> bool:
    """It stands, and nothing is left that would move it."""
    with sim.lock:
        return sim.world.motion is None and not sim.world.tasks.busy and not _moves(sim)


def _still_moves(sim: SimulatedChassis) -> str:
    """Whether it does not come to stand. What was sent last may still be on its way, on a slow network."""
    end = time.monotonic() + STANDS_WITHIN
    stands_since = None
    while time.monotonic() < end + STANDS_FOR:
        if not _is_free(sim):
            stands_since = None
        elif stands_since is None:
            stands_since = time.monotonic()
        elif time.monotonic() - stands_since > STANDS_FOR:
            return ""
        time.sleep(0.005)
    return f"THE ROBOT GOES ON: {sim.world.body.velocity}, {sim.world.motion}"


def _until(condition: object, timeout: float) -> bool:
    assert callable(condition)
    end = time.monotonic() + timeout
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.003)
    return True
