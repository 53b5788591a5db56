"""A command beside somebody else: what it could not begin, or has lost, it does not stop for the other."""

from __future__ import annotations

import pytest

from rosproto.errors import RosError
from tests.support.woosh_command import woosh_process
from woosh_pure import Chassis, OutcomeKind


@pytest.fixture
def zeros(sim, monkeypatch) -> list[object]:
    """Velocities that reach the robot from now on."""
    commands: list[object] = []
    monkeypatch.setattr(sim.world, "command_velocity", lambda velocity, **_: commands.append(velocity))
    return commands


def test_a_refused_command_sends_nothing_into_the_task_of_another(sim, chassis, woosh, zeros):
    """It said THE ROBOT IS STILL MOVING, which it did for the other, and sent zeros into that."""
    task = chassis.go_to_mark("A2")
    chassis.status.wait_for(lambda status: status.task_id == task.task_id)
    code, out, err = woosh("goto", "B1")
    assert code == 3
    assert out == ""
    assert "another task is running (robot state: in task)" in err
    assert zeros == []
    task.cancel()


def test_a_command_that_was_replaced_leaves_the_robot_to_the_other(sim, chassis, woosh, until, zeros):
    with Chassis(sim.master_uri, name="other") as other:
        other.wait_until_ready()

        def replace(_: object) -> None:
            off()
            other.move(0.2, check=False)

        off = chassis.measured_velocity.on(lambda v: v.is_standing() or replace(v))
        code, out, err = woosh("move", "3")
    assert code == 1
    assert "replaced after" in err
    assert "another client commands this robot now, and may move it" in err
    assert "STILL MOVING" not in err
    assert "stopping" not in out
    assert zeros == []


def test_a_reader_that_leaves_stops_the_motion_without_a_traceback(sim, until):
    """`woosh move 5 | head -1`: the progress is printed by the thread that waits."""
    with woosh_process("--master", sim.master_uri, "move", "5", "--speed", "0.05") as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "moving 5 m ...\n"
        process.stdout.close()
        assert process.stderr is not None
        said = process.stderr.read()
        assert process.wait(20.0) == 1
    said = said.removeprefix("stopping ...\n")  # said where the stop takes long
    assert said == "woosh: move: the output was closed: the motion was stopped\n"
    until(lambda: sim.world.motion is None)


def test_what_shows_the_progress_ends_a_wait_and_its_goal(sim, chassis):
    handle = chassis.move(3.0)

    def shown() -> None:
        raise RosError("the window is closed")

    with pytest.raises(RosError, match="the window is closed"):
        handle.wait(meanwhile=shown)
    assert handle.outcome.kind is OutcomeKind.CANCELLED
    assert not chassis.under_way
