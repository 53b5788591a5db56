"""Missions over the simulated chassis: what they do, what stops them, and what they survive."""

from __future__ import annotations

import asyncio
import errno
import hashlib
import hmac
import json
import random
import re
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from dataclasses import replace
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from typing import Any

import pytest

from rosproto import Master, Node
from rosproto.codec import service_class
from rosproto.errors import ConnectionLost
from rosproto.node.graph.master_client import MasterClient
from tests.support import mission_kills
from tests.support.doors import held
from tests.support.extras import needs
from tests.support.missions import GO, HEAD, mission, reach, run_of, running, stop_by
from tests.support.png import read_png
from tests.support.waiting import until
from woosh_pure import Chassis, SimulatedChassis, state_file
from woosh_pure.enums import RobotMode, TaskCommand, TaskState
from woosh_pure.missions import (
    KINDS,
    MissionError,
    MissionFailed,
    Missions,
    Notice,
    Phase,
    Run,
    parse,
)
from woosh_pure.motion.task import TaskMotion
from woosh_pure.stopping.other_clients import STOPPED


@pytest.fixture
def missions(chassis: Chassis, tmp_path: Path) -> Iterator[Missions]:
    """The missions of the chassis, in a folder of their own."""
    made = Missions(chassis, tmp_path)
    yield made
    made.close()


# -- what they do


def test_a_round_asks_and_goes_on_with_the_answer(
    sim: SimulatedChassis, chassis: Chassis, missions: Missions
) -> None:
    """The answer leads to its step, and the mission has the lease while it waits for it."""
    ask = 'do = "ask"; text = "Loaded?"; answers = { yes = "home", no = "stop" }'
    handle = missions.run(
        mission(
            'do = "go_to_mark"; mark = "A1"',
            ask,
            'do = "wait"; seconds = 60',
            'name = "home"; do = "park"; mark = "P1"',
        )
    )
    run = reach(missions, lambda run: run.question)
    assert run.question is not None
    assert run.question.text == "Loaded?"
    assert chassis.lease.holder == "mission test"
    with pytest.raises(MissionError, match="yes, no"):
        missions.answer("perhaps")
    missions.answer("yes", by="Anna")
    assert handle.wait(20.0).phase is Phase.DONE
    assert sim.pose.distance_to(sim.world.site.marks["P1"].pose) < 0.05
    until(lambda: chassis.lease.holder is None)
    kinds = [notice.kind for notice in missions.state.notices]
    assert kinds == ["start", "step", "question", "answer", "step", "end"]


EVERY_KIND = (
    'do = "go_to"; x = 1.0; y = 0.5; degrees = 90',
    'do = "rotate"; degrees = -90',
    'do = "move"; metres = -0.2; speed = 0.3',
    'do = "load"; mark = "A1"',
    'do = "unload"; mark = "B1"',
    'do = "lift"; to = "up"',
    'do = "dock"; tag = "7"',
    'do = "light"; state = "red"',
    'do = "say"; text = "hello"',
    'do = "picture"; file = "shelf"',
    'do = "call"; service = "/move_base/clear_costmaps"',
    'do = "wait_for_input"; input = 0; is = false',
    'do = "wait_for_battery"; percent = 1',
    'do = "if"; value = "battery"; above = 5; then = "again"; else = "stop"',
    'do = "go_on"; with = "stop"',
    'name = "again"; do = "wait"; seconds = 0',
    'do = "repeat"; from = "again"; times = 3',
    'do = "if"; value = "input"; input = 0; is = "off"; else = "stop"',
    'do = "if"; value = "mark"; is = "B1"; else = "stop"',
    'do = "charge"; mark = "C1"; until_percent = 10',
    'do = "move"; metres = -0.3',
    'do = "park"; mark = "P1"',
)


@pytest.mark.slow
def test_every_kind_of_step_is_carried_out(sim: SimulatedChassis, missions: Missions) -> None:
    """In one mission, with the loops and comparisons between them; `ask` and `go_to_mark` are in the round above, task lists in
    test_mission_lists.py."""
    assert {re.findall('do = "(.*?)"', step)[0] for step in EVERY_KIND} == {*KINDS} - {
        "ask",
        "go_to_mark",
        "task_list",
    }
    assert missions.run(mission(*EVERY_KIND)).wait(90.0).phase is Phase.DONE
    begun = [notice.text for notice in missions.state.notices if notice.kind == "step"]
    assert begun[13:17] == ["if", "wait", "wait", "wait"]
    assert sim.pose.distance_to(sim.marks["P1"]) < 0.05
    (picture,) = (missions.folder / "pictures").iterdir()
    assert read_png(picture.read_bytes()).size > 1000


def test_a_parameter_is_filled_in_and_a_wrong_one_refused(sim: SimulatedChassis, missions: Missions) -> None:
    """A parameter has the type of its default."""
    made = mission('do = "move"; metres = "$way"', head=GO + "; [parameters]; way = 0.2")
    with pytest.raises(MissionError, match="expected a number"):
        missions.run(made, {"way": "far"})
    with pytest.raises(MissionError, match="wya is not known; expected one of: way"):
        missions.run(made, {"wya": 1.0})
    before = sim.pose
    missions.run(made, {"way": 0.4}).wait(20.0)
    assert before.distance_to(sim.pose) == pytest.approx(0.4, abs=0.05)


def test_a_failed_step_is_tried_again_and_then_leads_where_the_file_says(
    sim: SimulatedChassis, missions: Missions
) -> None:
    """After its retries a step fails, on_failure leads on, and on_abort follows a failure of the mission."""
    handle = missions.run(mission('do = "go_to_mark"; mark = "A1"; retries = 1; retry_pause = 0.1'))
    until(lambda: sim.world.tasks.busy)
    fail_with_reason(sim, "no way")
    handle.wait(20.0)
    assert run_of(missions).ended == ((0, False), (0, True))
    made = parse(
        HEAD
        + '[guards]\nnot_known = "go"\n[[step]]\ndo = "go_to_mark"\nmark = "B1"\n[[on_abort]]\ndo = "light"\nstate = "red"\n'
    )
    handle = missions.run(made)
    until(lambda: sim.world.tasks.busy)
    fail_with_reason(sim, "wheel slips")
    with pytest.raises(MissionFailed, match="wheel slips"):
        handle.wait(20.0)
    assert [notice.text for notice in missions.state.notices if notice.kind == "step"][-1] == "light"


def test_a_queue_is_carried_out_in_its_order(missions: Missions) -> None:
    """Entries begin one after the other; removed ones do not."""
    first = missions.run(mission(ASK))
    names = ("one", "two", "three")  # each takes the lease by its name
    ids = [missions.append(replace(mission('do = "wait"; seconds = 0.2'), name=name)).id for name in names]
    missions.reorder(ids[2], 0)
    missions.unqueue(ids[1])
    assert [entry.id for entry in missions.state.queue] == [ids[2], ids[0]]
    with pytest.raises(MissionError, match="append yours to the queue"):
        missions.run(mission('do = "wait"; seconds = 0'))
    missions.answer("a")
    first.wait(20.0)
    missions.wait_for(lambda: not missions.state.queue and run_of(missions).phase.over, 60.0)
    started = [notice.run for notice in missions.state.notices if notice.kind == "start"]
    assert started == [first.id, ids[2], ids[0]]
    assert not missions.state.paused


def test_an_input_of_the_robot_is_waited_for_until_its_timeout(missions: Missions) -> None:
    """A wait that has a timeout fails when it passes."""
    with pytest.raises(MissionFailed, match="did not come within"):
        missions.run(mission('do = "wait_for_input"; input = 1; timeout = 0.5')).wait(15.0)


# -- what stops them


def stands(sim: SimulatedChassis, seconds: float = 1.0) -> bool:
    """Whether it does not move for a while of its time."""
    before, end = sim.pose, sim.now + seconds
    while sim.now < end:
        time.sleep(0.02)
    return sim.pose.distance_to(before) < 0.01


def blocked(chassis: Chassis) -> None:
    """Wait until it is known that it must not move."""
    until(lambda: chassis.readiness().blocked)


ASK = 'do = "ask"; text = "?"; answers = { a = "next", b = "next" }'
GO_A1, GO_B1 = 'do = "go_to_mark"; mark = "A1"', 'do = "go_to_mark"; mark = "B1"'
RETRY = GO_A1 + '; retries = 3; retry_pause = 1; on_failure = "next"'
ON_ABORT = "[[on_abort]]; " + GO_B1


def fail_with_reason(sim: SimulatedChassis, why: str) -> None:
    """The task fails, and the robot tells by a code of its navigation that it cannot get there."""
    sim.report(130104000042)
    sim.fail_task(why)


@pytest.mark.promise("a STOP while a mission is carried out")
@pytest.mark.parametrize("who", ["this program", "another program", "the mission's own stop"])
@pytest.mark.parametrize(
    "when", ["before the task is sent", "on its way", "between two steps", "at a question", "between retries"]
)
def test_a_stop_by_anybody_ends_the_run_and_pauses_the_queue(
    sim: SimulatedChassis,
    chassis: Chassis,
    missions: Missions,
    real_time: Callable[[], None],
    monkeypatch: pytest.MonkeyPatch,
    who: str,
    when: str,
) -> None:
    """Nothing moves after a stop: no retry, no step, no answer, nothing of the queue."""
    first = {"between two steps": 'do = "wait"; seconds = 600', "at a question": ASK}.get(when, RETRY)
    missions.run(mission(first, GO_B1, head=GO))
    missions.append(mission(GO_B1))
    with held(monkeypatch, TaskMotion, "begin") as (came, go_on):
        if when == "before the task is sent":
            assert came.wait(20.0)
            stop_by(who, sim, chassis, missions)
        go_on.set()
    start = sim.pose
    if when == "on its way":
        until(lambda: sim.pose.distance_to(start) > 0.05)
    elif when == "between retries":
        reach(missions, running)
        until(lambda: sim.world.tasks.busy)
        fail_with_reason(sim, "no way")
        reach(missions, lambda run: run.phase is Phase.RETRYING)
    elif when == "at a question":
        reach(missions, lambda run: run.question)
    elif when == "between two steps":
        reach(missions, running)
    until(lambda: STOPPED in chassis.node.master.get_system_state().subscribers)
    if when != "before the task is sent":
        stop_by(who, sim, chassis, missions)
    run = reach(missions, lambda run: run.phase.over)
    told = [(notice.kind, notice.run, notice.step, notice.text) for notice in missions.state.notices]
    assert (run.phase, run.entry.id) == (Phase.STOPPED, "1"), told
    assert missions.state.paused
    until(lambda: chassis.measured_velocity.wait(5.0).is_standing())
    real_time()
    assert stands(sim, 3.0)
    with pytest.raises(MissionError, match="no question"):
        missions.answer("a")
    assert [entry.id for entry in missions.state.queue] == ["2"]


@pytest.mark.promise("a STOP while a mission is carried out")
@pytest.mark.parametrize(
    "how", ["its task is cancelled", "its task is paused", "another goal", "the task fails without a reason"]
)
def test_a_motion_that_others_end_is_stopped_however_it_looks(
    sim: SimulatedChassis, missions: Missions, real_time: Callable[[], None], how: str
) -> None:
    """The robot calls some of these a failure; without a reason of its own no retry and no other step follows."""
    step = RETRY + ("; timeout = 2" if how == "its task is paused" else "")
    missions.run(mission(step, GO_B1, head=GO + "; " + ON_ABORT))
    start = sim.pose
    until(lambda: sim.pose.distance_to(start) > 0.05)
    with Chassis(sim.master_uri) as other:
        if how == "another goal":
            other.move(0.05, check=False).wait(10.0, raises=False)
        elif how.startswith("its task is"):
            command = TaskCommand.PAUSE if how.endswith("paused") else TaskCommand.CANCEL
            service = service_class("woosh_msgs/ExecTask")
            with other.node.service_client("/exec_task", service) as client:
                assert client.call(service.Request(task_exect=int(command))).success
        else:
            sim.fail_task("replaced by another command")
        run = reach(missions, lambda run: run.phase.over)
    assert run.phase is Phase.STOPPED
    assert missions.state.paused
    assert [notice.step for notice in missions.state.notices if notice.kind == "step"] == [0]
    real_time()
    assert stands(sim, 3.0)


def test_somebody_who_takes_the_lease_over_pauses_the_run(chassis: Chassis, missions: Missions) -> None:
    """Between two steps, too: the robot does not drive on when the lease is given back."""
    missions.run(mission(ASK, 'do = "move"; metres = 1'))
    until(lambda: chassis.lease.holder == "mission test")
    assert chassis.lease.request("Anna")
    assert chassis.lease.grant("mission test", "Anna")
    reach(missions, lambda run: run.paused)
    chassis.lease.release("Anna")
    missions.answer("a")
    assert reach(missions, lambda run: run.at == 1).paused


def test_an_emergency_stop_pauses_and_its_release_moves_nothing(
    sim: SimulatedChassis, chassis: Chassis, missions: Missions
) -> None:
    """Whoever releases the button is not surprised by a robot that drives on."""
    chassis.go_to_mark("P1").wait(20.0)  # so that its state is heard
    sim.press_emergency_stop()
    blocked(chassis)
    missions.run(mission('do = "go_to_mark"; mark = "A1"'))
    reach(missions, lambda run: run.paused)
    sim.release_emergency_stop()
    assert stands(sim, 3.0)
    assert run_of(missions).paused
    chassis.wait_until_ready(10.0)
    missions.resume()
    assert reach(missions, lambda run: run.phase.over).phase is Phase.DONE


def test_it_waits_while_readiness_is_not_yes_and_says_why(
    sim: SimulatedChassis, chassis: Chassis, missions: Missions
) -> None:
    """The reason is shown, and the run goes on when it is over."""
    chassis.go_to_mark("P1").wait(20.0)  # so that its state is heard
    sim.set_mode(RobotMode.MANUAL)
    blocked(chassis)
    missions.run(mission('do = "go_to_mark"; mark = "A1"'))
    assert "manual" in reach(missions, lambda run: run.reason).reason
    assert run_of(missions).phase is Phase.WAITING
    sim.set_mode(RobotMode.AUTOMATIC)
    assert reach(missions, lambda run: run.phase.over).phase is Phase.DONE


def test_it_waits_for_the_lease_of_another(chassis: Chassis, missions: Missions) -> None:
    """A person who drives by hand is not disturbed; that person's own mission takes the lease over."""
    chassis.lease.acquire("Anna")
    missions.run(mission('do = "move"; metres = 0.1'), by="Ben")
    assert "Anna commands" in reach(missions, lambda run: run.reason).reason
    chassis.lease.release("Anna")
    assert reach(missions, lambda run: run.phase.over).phase is Phase.DONE
    chassis.lease.acquire("Anna")
    missions.run(mission('do = "move"; metres = 0.1'), by="Anna").wait(20.0)


def test_a_pause_holds_the_robot_and_a_resume_goes_on(
    sim: SimulatedChassis, missions: Missions, real_time: Callable[[], None]
) -> None:
    """A step that was paused is not a step that has ended."""
    handle = missions.run(mission('do = "go_to_mark"; mark = "A1"'))
    reach(missions, running)
    missions.pause(by="Anna")
    time.sleep(0.5)  # it slows down
    assert stands(sim, 1.0)
    real_time()
    missions.resume(by="Anna")
    assert handle.wait(30.0).ended == ((0, True),)


def test_a_low_battery_is_charged_first(sim: SimulatedChassis, chassis: Chassis, missions: Missions) -> None:
    """The guard inserts charging before the step, and the mission goes on then."""
    sim.set_battery(10.0)
    head = GO + '; battery_below = 20; charger = "C1"; charge_until = 11'
    missions.run(mission('do = "go_to_mark"; mark = "A1"', head=head))
    assert reach(missions, running).charging
    chassis.wait_until_ready(20.0)
    sim.set_battery(60.0)
    assert reach(missions, lambda run: run.phase.over, 40.0).phase is Phase.DONE
    assert [notice.text for notice in missions.state.notices if notice.kind == "step"] == [
        "charge",
        "go_to_mark",
    ]


# -- what they survive


@pytest.mark.slow
@pytest.mark.parametrize("late", [False, True], ids=["at once", "on its way"])
def test_a_lost_link_leaves_the_step_not_known(tmp_path: Path, late: bool) -> None:
    """The robot may have gone on by itself, so a person is asked, and nothing is begun before."""
    with SimulatedChassis(full_graph=False) as sim:
        chassis = Chassis(sim.master_uri)
        missions = Missions(chassis, tmp_path)
        start = sim.pose
        missions.run(mission('do = "go_to_mark"; mark = "A1"; retries = 3', 'do = "go_to_mark"; mark = "B1"'))
        reach(missions, running)
        if late:
            until(lambda: sim.pose.distance_to(start) > 0.1)
        sim.drop_link(60.0)
        run = reach(missions, lambda run: run.question, 40.0)
        assert run.question is not None
        assert run.question.unknown
        assert run.at == 0
        assert run.reason
        with pytest.raises(ConnectionLost):
            chassis.close()


def test_a_robot_that_starts_again_is_not_moved_before_somebody_says_so(tmp_path: Path) -> None:
    """The run has ended, and the queue goes on with the new robot when it is resumed."""
    with Master(host="127.0.0.1", port=0) as master, ExitStack() as robots:
        options: dict[str, Any] = {"master_uri": master.uri, "speed": 8.0, "full_graph": False}
        first = robots.enter_context(SimulatedChassis(**options))
        with Chassis(master.uri) as chassis, closing(Missions(chassis, tmp_path)) as missions:
            start = first.pose
            missions.run(mission(RETRY, GO_B1))
            missions.append(mission(GO_B1))
            until(lambda: first.pose.distance_to(start) > 0.1)
            robots.close()
            with SimulatedChassis(**options) as second:
                run = reach(missions, lambda run: run.phase.over or run.question, 60.0)
                assert stands(second, 3.0)
                if (
                    run.question
                ):  # on a busy computer: it was silent for so long that nobody knows what became of it
                    missions.answer("stop")
                    run = reach(missions, lambda run: run.phase.over)
                assert (run.phase, run.at, missions.state.paused) == (Phase.STOPPED, 0, True), run
                missions.resume()
                assert reach(missions, lambda run: run.phase is Phase.DONE, 60.0).entry.id == "2"
                assert second.pose.distance_to(second.marks["B1"]) < 0.2


def test_a_full_disk_lets_nothing_begin(
    sim: SimulatedChassis, missions: Missions, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What cannot be written down does not happen; it goes on when there is room, and a stop works meanwhile."""
    missions.run(
        mission('do = "wait"; seconds = 0.5', 'do = "move"; metres = 0.3', 'do = "move"; metres = 0.3')
    )
    full = threading.Event()
    full.set()
    save = state_file.save_file

    def save_file(path: Any, data: bytes, **options: Any) -> None:
        if full.is_set():
            raise OSError(errno.ENOSPC, "No space left on device", str(path))
        save(path, data, **options)

    monkeypatch.setattr(state_file, "save_file", save_file)
    missions.wait_for(lambda: bool(missions.state.disk), 10.0)
    assert stands(sim, 3.0)
    with pytest.raises(MissionError, match="cannot be kept"):
        missions.append(mission('do = "wait"; seconds = 0'))
    full.clear()
    assert reach(missions, lambda run: run.phase.over).phase is Phase.DONE


def test_two_programs_with_one_folder_carry_a_mission_out_once(
    sim: SimulatedChassis, chassis: Chassis, missions: Missions, tmp_path: Path
) -> None:
    """The second one's requests reach the first."""
    ask = 'do = "ask"; text = "?"; answers = { a = "next", b = "next" }'
    missions.run(mission(ask))
    reach(missions, lambda run: run.question)
    with Chassis(sim.master_uri) as other_chassis:
        other = Missions(other_chassis, tmp_path)
        assert run_of(other).question is not None
        added = other.append(mission('do = "wait"; seconds = 0'), by="other")
        assert [entry.id for entry in missions.state.queue] == [added.id]
        with pytest.raises(MissionError, match="expected one of: a, b"):
            other.answer("c")
        other.answer("a", by="other")
        assert added.wait(10.0).phase is Phase.DONE
        other.close()


def test_a_file_that_changes_while_it_runs_changes_the_next_run_only(
    missions: Missions, tmp_path: Path
) -> None:
    """A run has a copy of the steps."""
    file = tmp_path / "a.mission.toml"
    file.write_text(HEAD + '[[step]]\ndo = "wait"\nseconds = 0.5\n[[step]]\ndo = "wait"\nseconds = 0\n')
    handle = missions.run(file)
    file.write_text("nonsense")
    assert handle.wait(10.0).ended == ((0, True), (1, True))
    with pytest.raises(MissionError, match=r"line 1, column \d+: not TOML"):
        missions.run(file)


def test_a_clock_that_is_set_back_changes_no_time_limit(
    missions: Missions, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Time limits are those of a clock that nobody sets."""
    now = time.time()
    ask = 'do = "ask"; text = "?"; answers = { a = "next", b = "stop" }; timeout = 1; default = "a"'
    handle = missions.run(mission(ask, 'do = "wait"; seconds = 0.2'))
    reach(missions, lambda run: run.question)
    monkeypatch.setattr(time, "time", lambda: now - 86400.0)
    assert handle.wait(10.0).answer == "a"


def test_a_program_that_ends_leaves_its_run_interrupted(
    sim: SimulatedChassis, chassis: Chassis, missions: Missions, tmp_path: Path
) -> None:
    """The next program moves nothing, asks what became of the step, and begins no finished step again."""
    sim.speed = 1.0
    missions.run(
        mission('do = "wait"; seconds = 0', 'do = "go_to_mark"; mark = "A1"', 'do = "wait"; seconds = 0')
    )
    missions.append(mission('do = "move"; metres = 1'))
    reach(missions, lambda run: running(run) and run.at == 1)
    missions.close()
    again = Missions(chassis, tmp_path)
    again.pause()
    run = run_of(again)
    assert run.phase is Phase.INTERRUPTED
    assert stands(sim)
    again.clear()
    again.resume()
    assert reach(again, lambda run: run.question).question.unknown  # type: ignore[union-attr]
    again.answer("done")
    assert reach(again, lambda run: run.phase.over).ended == ((0, True), (1, True), (2, True))
    again.close()


@pytest.mark.slow
def test_the_robots_history_settles_the_step_of_a_killed_program(tmp_path: Path) -> None:
    """Nobody watched it, so the robot went on to its mark. Its task id tells that the step is done: nobody is asked."""
    needs("api")
    from woosh_pure.api_server import RobotApiServer, simulated_site

    file = tmp_path / "one.mission.toml"
    file.write_text(
        HEAD + f"{GO}\n[[step]]\n{GO_A1}\n[[step]]\ndo = 'wait'\nseconds = 0\n".replace("; ", "\n")
    )
    with ExitStack() as stack:
        sim = stack.enter_context(SimulatedChassis(speed=4, full_graph=False))
        node = stack.enter_context(Node("robot_api", master_uri=sim.master_uri, rosout=False))
        api = stack.enter_context(RobotApiServer(node, port=0, site=simulated_site(sim)))
        words = [sys.executable, "-c", mission_kills.PROGRAM, sim.master_uri, str(tmp_path), str(file)]
        with subprocess.Popen(words, stdout=subprocess.PIPE, cwd=mission_kills.ROOT) as program:
            try:
                until(lambda: sim.pose.distance_to(sim.marks["A1"]) < 1.0, 60.0, "the drive")
            finally:
                program.kill()
        chassis = stack.enter_context(
            Chassis(sim.master_uri, missions_state=tmp_path, robot_api=f"127.0.0.1:{api.port}")
        )
        until(
            lambda: [task.state for task in chassis.robot_api.task_history()] == [TaskState.COMPLETED], 60.0
        )
        chassis.missions.resume()
        run = reach(chassis.missions, lambda run: run.phase.over)
        assert (run.phase, run.ended) == (Phase.DONE, ((0, True), (1, True)))
        assert "question" not in [notice.kind for notice in chassis.missions.state.notices]
        assert len(chassis.robot_api.task_history()) == 1


def test_a_chassis_that_is_closed_leaves_its_run_interrupted(sim: SimulatedChassis, tmp_path: Path) -> None:
    """Closing stops the motion, which is not a stop by somebody: the run can be resumed."""
    sim.speed = 1.0
    with Chassis(sim.master_uri, missions_state=tmp_path) as first:
        first.missions.run(mission(GO_A1))
        start = sim.pose
        until(lambda: sim.pose.distance_to(start) > 0.05)
    with Chassis(sim.master_uri, missions_state=tmp_path) as second:
        run = run_of(second.missions)
        assert (run.phase, run.begun) == (Phase.INTERRUPTED, True)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(3))
def test_no_step_twice_and_no_motion_by_itself_after_kill_9(tmp_path: Path, number: int) -> None:
    """Killed at a random moment, a mission goes on when a person says so, without doing anything twice."""
    with SimulatedChassis(speed=4, full_graph=False) as sim:
        mission_kills.kill_once(sim, tmp_path, random.uniform(0.0, mission_kills.MAX_SECONDS))


def test_a_stop_counts_whom_it_has_told_also_when_they_end_at_once(
    chassis: Chassis, caplog: pytest.LogCaptureFixture
) -> None:
    """A program that hears it may be gone before anybody looks; one that was killed is named as not told."""
    uri, ended = chassis.master_uri, threading.Event()
    with Node("gone", master_uri=uri) as gone, MasterClient(uri, "/killed") as killed:
        gone.subscriber(STOPPED, "std_msgs/Empty", callback=lambda _: ended.set())
        threading.Thread(target=lambda: ended.wait(20.0) and gone.close(), daemon=True).start()
        killed.register_subscriber(STOPPED, "std_msgs/Empty", "http://127.0.0.1:1/")
        chassis.stop(everything=True)
        assert gone.wait(10.0)
    assert "1 of 2 did not connect" in caplog.text


# -- webhooks


class _Receiver(HTTPServer):
    """Takes posts, after some that it refuses."""

    def __init__(self, refusals: int) -> None:
        super().__init__(("127.0.0.1", 0), _Handler)
        self.refusals = refusals
        self.taken: list[tuple[dict[str, str], bytes]] = []


class _Handler(BaseHTTPRequestHandler):
    server: _Receiver

    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers["Content-Length"]))
        self.server.refusals -= 1
        refused = self.server.refusals >= 0
        if not refused:
            self.server.taken.append((dict(self.headers), body))
        self.send_response(503 if refused else 204)
        self.end_headers()

    def log_message(self, *_: object) -> None:
        """Nothing is printed."""


def test_a_webhook_gets_signed_events_again_until_it_takes_them(
    missions: Missions, until: Callable[..., None]
) -> None:
    """In order, each with an id, signed with the secret; a refused one is sent again."""
    with _Receiver(refusals=1) as receiver:
        threading.Thread(target=receiver.serve_forever, daemon=True).start()
        missions.add_webhook(f"http://127.0.0.1:{receiver.server_port}/hook", "a secret of us")
        missions.run(mission('do = "wait"; seconds = 0')).wait(10.0)
        until(lambda: len(receiver.taken) == 3)
        until(lambda: missions.state.delivered == missions.state.notices[-1].number)
        receiver.shutdown()
    assert [json.loads(body)["kind"] for _, body in receiver.taken] == ["start", "step", "end"]
    assert len({headers["Webhook-Id"] for headers, _ in receiver.taken}) == 3
    for headers, body in receiver.taken:
        expected = hmac.new(b"a secret of us", body, hashlib.sha256).hexdigest()
        assert headers["Webhook-Signature"] == f"sha256={expected}"


def test_what_a_webhook_has_not_taken_is_sent_after_a_restart(
    sim: SimulatedChassis, tmp_path: Path, until: Callable[..., None]
) -> None:
    """From disk, once each: what the first program could not deliver, the second one does."""
    with _Receiver(refusals=0) as receiver:
        url = f"http://127.0.0.1:{receiver.server_port}/"
        with Chassis(sim.master_uri, missions_state=tmp_path) as first:
            first.missions.add_webhook("http://127.0.0.1:1/", "a secret of us")
            first.missions.run(mission('do = "wait"; seconds = 0')).wait(10.0)
        threading.Thread(target=receiver.serve_forever, daemon=True).start()
        for _ in range(2):
            with Chassis(sim.master_uri, missions_state=tmp_path) as later:
                later.missions.add_webhook(url, "a secret of us")
                until(lambda: later.missions.state.delivered == later.missions.state.notices[-1].number)
        receiver.shutdown()
    assert [json.loads(body)["kind"] for _, body in receiver.taken] == ["start", "step", "end"]


def test_a_webhook_needs_a_secret(missions: Missions) -> None:
    """An unsigned event could come from anybody."""
    with pytest.raises(ValueError, match="WOOSH_WEBHOOK_SECRET"):
        missions.add_webhook("http://127.0.0.1:1/", "")


def test_notices_have_numbers_that_grow(missions: Missions) -> None:
    """A client that asks for what is new misses nothing."""
    missions.run(mission('do = "wait"; seconds = 0')).wait(10.0)
    found: list[Notice] = list(missions.state.notices)
    assert [notice.number for notice in found] == list(range(1, len(found) + 1))


def test_missions_are_awaited(sim: SimulatedChassis, tmp_path: Path) -> None:
    """The same in asyncio: start, answer, and the end of the handle."""

    async def drive() -> Run:
        async with Chassis(sim.master_uri, missions_state=tmp_path).aio as robot:
            ask = 'do = "ask"; text = "?"; answers = { a = "next", b = "stop" }'
            handle = await robot.missions.run(mission(ask, 'do = "move"; metres = 0.1'))
            await robot.missions.wait_for(lambda: robot.missions.state.run.question is not None, 10.0)  # type: ignore[union-attr]
            await robot.missions.answer("a")
            run: Run = await handle
            return run

    assert asyncio.run(drive()).phase is Phase.DONE
