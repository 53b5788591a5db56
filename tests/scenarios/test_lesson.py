"""The lesson of docs/lesson: each solution does what its page asks for, and the teacher's page quotes real messages."""

from __future__ import annotations

import math
import re
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.support.robot_pool import Robot, RobotPool
from tests.support.warm import WarmPython
from woosh_pure import Chassis, SimulatedChassis

ROOT = Path(__file__).resolve().parents[2]
PAGES = ROOT / "docs" / "lesson"
SOLUTIONS = ROOT / "examples" / "lesson"
pytestmark = [pytest.mark.slow, pytest.mark.example]


@pytest.fixture(scope="module")
def python() -> Iterator[WarmPython]:
    with WarmPython() as warm:
        yield warm


@pytest.fixture(scope="module")
def pool() -> Iterator[RobotPool]:
    with RobotPool() as robots:
        yield robots


@pytest.fixture
def robot(pool: RobotPool) -> Iterator[Robot]:
    """A robot of the hall, in its initial state."""
    taken = pool.take(speed=8.0)
    yield taken
    pool.give_back(taken)


@pytest.fixture
def run(python: WarmPython, robot: Robot, tmp_path: Path) -> Callable[[str], list[str]]:
    """Run a solution as `woosh run` does, with the robot in $ROS_MASTER_URI; its lines."""

    def run(name: str) -> list[str]:
        before = f"import os; os.environ['ROS_MASTER_URI'] = {robot.sim.master_uri!r}"
        done = python.run(SOLUTIONS / f"{name}.py", tmp_path, before=before)
        assert done.returncode == 0, done.stdout + done.stderr
        assert done.stderr == ""
        return done.stdout.splitlines()

    return run


def stands_at(robot: Robot, x: float, y: float, *, within: float = 0.15) -> bool:
    pose = robot.sim.pose
    return math.hypot(pose.x - x, pose.y - y) < within


def test_every_task_has_a_page_and_a_solution() -> None:
    """Six of each, of the same names, and the teacher's page names all."""
    pages = sorted(
        page.stem.replace("-", "_") for page in PAGES.glob("task*.md") if ".zh-CN" not in page.name
    )
    assert pages == sorted(solution.stem for solution in SOLUTIONS.glob("*.py"))
    assert len(pages) == 6
    teacher = (PAGES / "teacher.md").read_text("utf-8")
    assert re.findall(r"`examples/lesson/(\w+)\.py` \|", teacher) == pages


def test_task_1_two_metres_forward_and_back(run: Callable[[str], list[str]], robot: Robot) -> None:
    seen: list[float] = []
    before = robot.sim.world.body.distance
    with Chassis(robot.sim.master_uri) as chassis:
        chassis.pose.on(lambda pose: seen.append(pose.x))
        lines = run("task1_first_move")
    assert max(seen) > 1.5  # a busy computer misses the turning point
    assert robot.sim.world.body.distance - before == pytest.approx(4.0, abs=0.2)
    assert stands_at(robot, 0.0, 0.0)
    assert lines[0] == "battery: 87 %"
    assert lines[1].startswith("back again")


def test_task_2_closed_paths(run: Callable[[str], list[str]], robot: Robot) -> None:
    """A square of one metre: as far to the left as forward; at the end it stands and looks as in the beginning."""
    seen: list[tuple[float, float]] = []
    with Chassis(robot.sim.master_uri) as chassis:
        chassis.pose.on(lambda pose: seen.append((pose.x, pose.y)))
        assert len(run("task2_square")) == 2
    assert [max(axis) for axis in zip(*seen, strict=True)] == pytest.approx([1.0, 1.0], abs=0.1)
    assert stands_at(robot, 0.0, 0.0)
    assert abs(robot.sim.pose.yaw) < 0.05


def test_task_3_the_nearest_mark_first(run: Callable[[str], list[str]], robot: Robot) -> None:
    lines = run("task3_nearest_mark")
    assert [line.split()[0] for line in lines] == ["P1", "A1", "A2", "B1", "all"]
    assert stands_at(robot, 8.5, -2.0)


def test_task_4_it_says_why_and_tries_again(run: Callable[[str], list[str]], robot: Robot) -> None:
    """The emergency stop is pressed under way and released later; a mark that does not exist is given up."""
    sim = robot.sim

    def press_and_release() -> None:
        with sim.lock:
            sim.lock.wait_for(lambda: sim.world.body.pose.x > 0.5, 60.0)
        sim.press_emergency_stop()
        threading.Timer(1.0, sim.release_emergency_stop).start()

    helper = threading.Thread(target=press_and_release, daemon=True)
    helper.start()
    lines = run("task4_say_why")
    helper.join(10.0)
    assert lines[0].startswith("B1: it did not arrive: ")
    assert "emergency stop" in lines[0]
    assert lines[1] == "B1: arrived at attempt 2"
    assert "not known" in lines[2]
    assert lines[-1] == "kitchen: given up"
    assert stands_at(robot, 8.5, -2.0)


def test_task_5_it_keeps_away_from_what_it_sees(run: Callable[[str], list[str]], robot: Robot) -> None:
    """An obstacle that is on no map makes it turn; it never touches anything."""
    robot.sim.add_obstacle(2.0, 0.0)
    lines = run("task5_look_ahead")
    assert len(lines) == 12
    assert sum(line.endswith("forward") for line in lines) >= 4
    assert any(line.endswith("left") for line in lines[:4]), lines
    assert not robot.sim.world.bumper


def test_task_6_a_patrol_with_obstacles(run: Callable[[str], list[str]], robot: Robot) -> None:
    """It drives around one on its way, and leaves out a mark on which another one stands."""
    robot.sim.add_obstacle(1.5, 0.6)
    robot.sim.add_obstacle(8.5, -2.0, 0.3)
    *rounds, summary = run("task6_patrol")
    results = [re.fullmatch(r"round (\d), (\w\d): (reached|left out).* \(\d+ s\)", line) for line in rounds]
    expected = [(mark, "left out" if mark == "B1" else "reached") for mark in ("A1", "B1", "B2", "P1")] * 2
    assert [(found[2], found[3]) for found in results if found] == expected
    assert summary == "6 of 8 marks were reached"
    assert stands_at(robot, -0.5, 2.5)


MISTAKES: dict[str, Callable[[Chassis], object]] = {
    "... refused, nothing was sent: ... is under way and would be lost": lambda robot: (
        robot.forward(1),
        robot.left(90),
    ),
    "... is more than the 10.0 m one step may have": lambda robot: robot.forward(50),
    "too many positional arguments; use forward(metres)": lambda robot: robot.forward(0, 5),  # type: ignore[call-arg]
    "90.00 rad is more than one turn": lambda robot: robot.rotate(90),
    "obstacle wait timed out": lambda robot: robot.forward(9).wait(timeout=60),
    "this Chassis is closed": lambda robot: (robot.close(), robot.forward(1)),
    "this mark is not known": lambda robot: robot.go_to_mark("a1").wait(timeout=60),
}


def test_the_mistakes_of_the_teachers_page_are_what_a_program_says(
    tmp_path: Path, python: WarmPython
) -> None:
    """In both languages, each quoted text is part of what the library says."""
    quoted = [
        re.findall(r"^\| `([^`]+)` \|", (PAGES / name).read_text("utf-8"), re.MULTILINE)
        for name in ("teacher.md", "teacher.zh-CN.md")
    ]
    assert quoted[0] == quoted[1]
    (tmp_path / "woosh_pure.py").write_text("from woosh_pure import Chassis\n", "utf-8")
    shadowed = python.run(
        tmp_path / "woosh_pure.py", tmp_path, before="import sys; sys.modules.pop('woosh_pure')"
    )
    said = {"cannot import name 'Chassis'": shadowed.stderr}
    for text, mistake in MISTAKES.items():
        with SimulatedChassis(speed=20, full_graph=False) as sim, Chassis(sim.master_uri) as robot:
            with pytest.raises(Exception) as raised:
                mistake(robot)
            said[text] = str(raised.value)
    assert sorted(said) == sorted(quoted[0])
    for text, message in said.items():
        pattern = ".*".join(map(re.escape, text.split("...")))
        assert re.search(pattern, message, re.DOTALL), f"{text!r} is not in {message!r}"
