"""Missions with task lists that are stored in the robot (by its Robot API, over real sockets), and answers by inputs."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from rosproto import Node
from rosproto.gateway import Access
from tests.support import mission_kills
from tests.support.extras import needs
from tests.support.missions import GO, HEAD, mission, reach, run_of, running, stop_by
from tests.support.waiting import until
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.enums import TaskState
from woosh_pure.errors import MotionRefused
from woosh_pure.missions import MissionError, Missions, Phase

ROUND = 'do = "task_list"; list = "Round"'
Robot = tuple[SimulatedChassis, Chassis, str]


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Robot]:
    """A simulated robot, its chassis, and the address of its Robot API, which may move it."""
    needs("api")
    from woosh_pure.api_server import RobotApiServer, simulated_site

    with ExitStack() as stack:
        sim = stack.enter_context(SimulatedChassis(speed=12, full_graph=False))
        node = stack.enter_context(Node("robot_api", master_uri=sim.master_uri, rosout=False))
        access = Access(write=["api:*"])
        api = stack.enter_context(RobotApiServer(node, port=0, site=simulated_site(sim), access=access))
        at = f"127.0.0.1:{api.port}"
        yield sim, stack.enter_context(Chassis(sim.master_uri, missions_state=tmp_path, robot_api=at)), at


def test_a_task_list_is_followed_to_its_end_each_time(robot: Robot) -> None:
    """Its last task of an earlier run, which the robot still shows, is not its end."""
    sim, chassis, _ = robot
    lists = [(each.id, each.name, each.tasks) for each in chassis.robot_api.task_lists()]
    assert lists == [(1, "Round", (101, 102)), (2, "Home", (201, 202))]
    for text in (ROUND, ROUND, 'do = "task_list"; list = "2"'):
        run = chassis.missions.run(mission(text)).wait(60.0)
        assert (run.phase, run.ended) == (Phase.DONE, ((0, True),))
        place = "B1" if text == ROUND else "P1"
        assert sim.pose.distance_to(sim.marks[place]) < 0.1
    ended = [task.task_id for task in chassis.robot_api.task_history()]
    assert ended == [101, 102, 101, 102, 201, 202]


@pytest.mark.promise("a STOP while a mission is carried out")
@pytest.mark.parametrize("who", ["this program", "another program", "the mission's own stop"])
def test_a_stop_ends_a_task_list(robot: Robot, who: str) -> None:
    """Not its current task alone: the next one of the list does not begin."""
    sim, chassis, _ = robot
    start = sim.pose
    chassis.missions.run(mission(ROUND))
    until(lambda: sim.pose.distance_to(start) > 0.1)
    stop_by(who, sim, chassis, chassis.missions)
    assert reach(chassis.missions, lambda run: run.phase.over).phase is Phase.STOPPED
    before, end = sim.pose, sim.now + 8.0
    until(lambda: sim.now > end, 60.0)
    assert sim.pose.distance_to(before) < 0.02
    assert not sim.world.tasks.busy


def test_what_a_robot_begins_after_a_cancel_is_cancelled_too(robot: Robot) -> None:
    """A cancel between two tasks hits none of them, and a robot may go on with the next one after a cancel."""
    sim, chassis, _ = robot
    handle = chassis.task_list("Round")
    until(lambda: sim.world.tasks.busy)
    following = list(sim.world.tasks._following)
    assert following
    handle.cancel()
    with sim.lock:
        assert sim.world.tasks.start_list(following) == ""
    until(lambda: not sim.world.tasks.busy, 10.0)
    assert sim.world.tasks.state is TaskState.CANCELLED


@pytest.mark.slow
@pytest.mark.parametrize("alone", [False, True], ids=["beside ROS 1", "the Robot API alone"])
def test_the_watchdog_of_a_killed_program_ends_a_task_list_that_goes_on(robot: Robot, alone: bool) -> None:
    """Its first cancel may fall between two tasks."""
    sim, _, address = robot
    program = (
        "import sys, time; from woosh_pure import Chassis\n"
        "chassis = Chassis(sys.argv[1], robot_api=sys.argv[2] or None, watchdog=True)\n"
        "chassis.task_list('Round'); time.sleep(60)"
    )
    where = (f"ws://{address}", "") if alone else (sim.master_uri, address)
    with subprocess.Popen([sys.executable, "-c", program, *where], cwd=mission_kills.ROOT) as process:
        try:
            until(lambda: sim.world.tasks.busy, 60.0)
            following = list(sim.world.tasks._following)
        finally:
            process.kill()
    until(lambda: sim.world.tasks.state is TaskState.CANCELLED, 10.0)
    time.sleep(0.5)  # longer than the rounds of every watch
    with sim.lock:
        assert sim.world.tasks.start_list(following) == ""
    until(lambda: not sim.world.tasks.busy, 10.0)
    assert sim.world.tasks.state is TaskState.CANCELLED


def test_a_pause_holds_a_task_list(robot: Robot) -> None:
    """It goes on from there when it is resumed."""
    sim, chassis, _ = robot
    handle = chassis.missions.run(mission(ROUND))
    reach(chassis.missions, running)
    until(lambda: sim.world.tasks.busy)
    chassis.missions.pause()
    until(lambda: sim.world.tasks.state is TaskState.PAUSED)
    chassis.missions.resume()
    assert handle.wait(60.0).phase is Phase.DONE


def test_a_mission_with_a_list_that_cannot_be_carried_out_is_refused_before_anything_moves(
    robot: Robot, tmp_path: Path
) -> None:
    """There is none of that name, or the robot has no Robot API; and no other door starts one."""
    sim, chassis, _ = robot
    move = 'do = "move"; metres = 1'
    with pytest.raises(MissionError, match="Rund is not known; expected one of: Round, Home"):
        chassis.missions.run(mission(move, 'do = "task_list"; list = "Rund"'))
    with pytest.raises(MotionRefused, match="use the verbs of Chassis"):
        chassis.robot_api.request("ExecPreTask", {"taskSetId": 1}, change=True)
    with Chassis(sim.master_uri, missions_state=tmp_path / "other", robot_api=False) as other:
        with pytest.raises(MissionError, match="task_list: the Robot API of this Chassis is switched off"):
            other.missions.run(mission(move, ROUND))
        assert other.missions.state.run is None
    assert chassis.missions.state.run is None
    assert not sim.world.tasks.busy


@pytest.mark.slow
def test_the_history_settles_a_list_of_a_killed_program(robot: Robot, tmp_path: Path) -> None:
    """The robot went on by itself; that the same list was done before does not settle it."""
    sim, chassis, address = robot
    chassis.task_list("Round").wait(60.0)
    steps = "\n".join(("[[step]]", *ROUND.split("; "), "[[step]]", 'do = "wait"', "seconds = 0"))
    file = tmp_path / "list.mission.toml"
    file.write_text(f"{HEAD}{GO}\n{steps}\n".replace("; ", "\n"))
    program = mission_kills.PROGRAM.replace("(sys.argv[1])", "(sys.argv[1], robot_api=sys.argv[4])")
    words = [sys.executable, "-c", program, sim.master_uri, str(tmp_path), str(file), address]
    env = {**os.environ}
    with subprocess.Popen(words, cwd=mission_kills.ROOT, env=env, stdout=subprocess.DEVNULL) as process:
        try:
            until(lambda: chassis.missions.state.run and run_of(chassis.missions).task, 60.0, "the list")
            until(lambda: sim.world.tasks.task_id == 101 and sim.world.tasks.busy, 60.0, "its first task")
        finally:
            process.kill()
    history = chassis.robot_api.task_history
    until(lambda: [each.task_id for each in history()] == [101, 102, 101, 102], 60.0)
    chassis.missions.resume()
    run = reach(chassis.missions, lambda run: run.phase.over)
    assert (run.phase, run.ended) == (Phase.DONE, ((0, True), (1, True)))
    assert "question" not in [notice.kind for notice in chassis.missions.state.notices]


# -- answers from an input


def test_an_input_answers_a_question_when_it_comes_on(
    sim: SimulatedChassis, chassis: Chassis, tmp_path: Path
) -> None:
    """One that is on already does not, nor in the question that follows; a page's answer counts as before."""
    ask = 'do = "ask"; text = "?"; answers = { yes = "next", no = "stop" }; inputs = { yes = 1 }'
    with closing(Missions(chassis, tmp_path)) as missions:
        with sim.lock:
            sim.world.bumper = True  # line 1 of the keys
        handle = missions.run(mission(ask, 'name = "again"; ' + ask, ask))
        seen = chassis.feed("inputs")
        for place, by in enumerate(("input 1", "input 1", "Anna")):
            run = reach(missions, lambda run, place=place: run.question and run.at == place)  # type: ignore[misc]
            assert run.entry.id == handle.id
            for _ in range(3):  # it stays on
                seen.wait(10.0)
            assert run_of(missions).at == place
            if by == "Anna":
                missions.answer("yes", by=by)
                break
            for on in (False, True):
                with sim.lock:
                    sim.world.bumper = on
                seen.wait_for(lambda now, on=on: now.IOs[1].status == on, timeout=10.0)  # type: ignore[misc]
        assert handle.wait(10.0).phase is Phase.DONE
        answered = [notice.values["by"] for notice in missions.state.notices if notice.kind == "answer"]
        assert answered == ["input 1", "input 1", "Anna"]
