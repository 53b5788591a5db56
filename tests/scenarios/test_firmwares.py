"""Chassis of every firmware, driven by the same program; and what an older one cannot be told."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest

from rosproto.errors import Md5sumMismatch
from rosproto.msg import bundled
from tests.support.robot_pool import RobotPool
from woosh_pure import Chassis, FirmwareLimit, OutcomeKind, Pose2D, SimulatedChassis
from woosh_pure.cli import main
from woosh_pure.enums import NavDirection, NavigationMode, TaskType
from woosh_pure.firmware.versions import CURRENT, Firmware, firmware, firmware_names
from woosh_pure.geometry import Velocity
from woosh_pure.motion.steps import Step
from woosh_pure.sim import Settings
from woosh_pure.sim.body import BodyLimits

FIRMWARES = ["1.1.4", "1.1.1", "1.1.0", "1.0.8", "1.0.7", "page"]


@pytest.fixture(scope="module")
def pools() -> Iterator[dict[str, RobotPool]]:
    """Omnidirectional chassis of each firmware."""
    settings = Settings(limits=BodyLimits(omnidirectional=True))
    with ExitStack() as stack:
        yield {
            name: stack.enter_context(RobotPool(full_graph=False, firmware=name, settings=settings))
            for name in FIRMWARES
        }


@contextmanager
def taken(pools: dict[str, RobotPool], name: str) -> Iterator[SimulatedChassis]:
    """One of a firmware at 8 times real time."""
    robot = pools[name].take(8.0)
    yield robot.sim
    pools[name].give_back(robot)


@pytest.fixture(
    params=[
        "1.1.4",
        "page",
        *(pytest.param(name, marks=[pytest.mark.whole, pytest.mark.slow]) for name in FIRMWARES[1:-1]),
    ]
)
def sim(request: pytest.FixtureRequest, pools: dict[str, RobotPool]) -> Iterator[SimulatedChassis]:
    """One of each firmware."""
    with taken(pools, request.param) as simulated:
        yield simulated


def test_tasks_navigation_and_moves(sim: SimulatedChassis, chassis: Chassis) -> None:
    """To a mark, to a pose, along a path, straight and around: wherever all that matters can be said."""
    assert chassis.go_to_mark("A1").wait(60.0).arrived
    assert sim.pose.distance_to(sim.world.site.marks["A1"].pose) < 0.1
    assert chassis.go_to(0.5, 0.0).wait(60.0).arrived
    chassis.follow([Pose2D(0.5, 0.5), Pose2D(0.0, 0.0)]).wait(60.0)
    before = sim.pose
    chassis.steps([Step.straight(0.4), Step.turn(math.pi / 2, 1.0)]).wait()
    assert before.distance_to(sim.pose) == pytest.approx(0.4, abs=0.03)
    assert abs(before.angle_to(sim.pose)) == pytest.approx(math.pi / 2, abs=0.05)
    sim.speed = 1.0  # time to cancel it on its way
    handle = chassis.go_to_mark("B1")
    handle.cancel()
    assert handle.wait(20.0, raises=False).kind is OutcomeKind.CANCELLED


def test_reading(sim: SimulatedChassis, chassis: Chassis) -> None:
    """Every value arrives under its own name, whatever its place in the definition."""
    battery = chassis.battery.wait()
    assert battery.percent == round(sim.world.battery.percent)
    assert battery.cell_voltage_max > battery.cell_voltage_min > 2.0
    assert battery.bms_status == 0
    parameters = chassis.parameters.wait()
    assert (parameters.pulses_per_turn, parameters.max_speed) == (10000, sim.world.body.limits.linear)
    assert (parameters.max_linear, parameters.joystick_max_angular) == (1.0, pytest.approx(0.8))
    assert chassis.information.wait().parameters == parameters
    assert chassis.go_to_mark("A1").wait(60.0).arrived
    assert chassis.status.wait_for(lambda s: s.task_state.is_final).task_state.name == "COMPLETED"


def test_navigation_mode(sim: SimulatedChassis, chassis: Chassis) -> None:
    """What every firmware can be told is obeyed; the defaults of later fields get in nobody's way."""
    chassis.set_navigation_mode(NavigationMode.WAIT_THEN_AVOID, waiting_timeout=3.0, max_speed=0.4)
    settings = sim.world.navigation
    assert settings.mode is NavigationMode.WAIT_THEN_AVOID
    assert (settings.waiting_timeout, settings.max_speed) == (3.0, pytest.approx(0.4))


def test_velocity(sim: SimulatedChassis, chassis: Chassis, until: Any) -> None:
    """Driving by velocity has the same definitions everywhere."""
    with chassis.velocity(bypasses_protection=True) as drive:
        drive.set(0.2, valid_for=2.0)
        chassis.measured_velocity.wait_for(lambda v: v.vx > 0.15)
    chassis.measured_velocity.wait_for(Velocity.is_standing)


CANNOT = [
    ("1.0.8", lambda c: c.strafe(0.1), "LATERAL"),
    ("1.0.8", lambda c: c.move_diagonal(0.1, 0.5), "DIAGONALIZE"),
    ("1.1.0", lambda c: c.move_diagonal(0.1, 0.5), "goal.stepControl.angle"),
    ("1.1.0", lambda c: c.move_diagonal(0.1, 0.0), "goal.stepControl.angle"),
    ("page", lambda c: c.move_diagonal(0.1, 0.5), "goal.stepControl.angle"),
    ("page", lambda c: c.follow([Pose2D(0.5, 0.0)], point_by_point=True), "goal.execution_mode"),
    ("1.1.1", lambda c: _mode(c, direction=NavDirection.BACKWARD), "goal.nav_dir"),
    ("1.0.8", lambda c: _mode(c, capacity=2), "goal.capacity"),
    ("1.0.7", lambda c: _mode(c, permitted_passage=True), "goal.permitted_passage"),
    ("page", lambda c: _mode(c, passage_id=7), "goal.id"),
]


def _mode(chassis: Chassis, **options: Any) -> None:
    chassis.set_navigation_mode(NavigationMode.STOP_AND_WAIT, **options)


@pytest.mark.parametrize(
    ("name", "verb", "lack"), CANNOT, ids=[f"{name}-{lack.rpartition('.')[2]}" for name, _, lack in CANNOT]
)
def test_what_a_firmware_cannot_be_told_is_an_error_and_nothing_is_sent(
    name: str, verb: Any, lack: str, pools: dict[str, RobotPool]
) -> None:
    """The error names the limit; the robot gets no goal."""
    with taken(pools, name) as sim, Chassis(sim.master_uri) as chassis:
        before = sim.world.navigation
        with pytest.raises(FirmwareLimit, match="Nothing was sent") as caught:
            verb(chassis)
        assert caught.value.fields == [lack]
        assert bundled().package_revisions("woosh_msgs")[caught.value.firmware]
        with sim.lock:
            assert sim.world.motion is None
            assert sim.world.navigation == before
        assert not chassis.moved


@pytest.mark.parametrize("name", ["1.1.0", "1.1.1"])
def test_a_lateral_step_since_1_1_0(name: str, pools: dict[str, RobotPool]) -> None:
    """What a firmware can do, it does, though its definition is another one."""
    with taken(pools, name) as sim, Chassis(sim.master_uri) as chassis:
        chassis.strafe(0.3).wait()
        assert sim.pose.y == pytest.approx(0.3, abs=0.02)


def test_a_robot_with_all_its_nodes_in_an_old_firmware() -> None:
    """Second publishers, internal listeners and competing clients speak the old definitions too."""
    with SimulatedChassis(speed=8.0, firmware="1.0.8") as sim, Chassis(sim.master_uri) as chassis:
        chassis.move(0.3).wait()
        sim.speed = 1.0  # time to interfere
        handle = chassis.go_to(2.5, 0.0)
        chassis.measured_velocity.wait_for(lambda v: v.vx > 0.1)
        sim.compete(0.0, 1.0)
        assert handle.wait(20.0, raises=False).kind is OutcomeKind.REPLACED


def test_versions_between_the_listed_ones() -> None:
    """A version has the definitions of the next newer one in the list; a newer one has the present ones."""

    def goal(name: str) -> str:
        found: str = firmware(name).message_class("woosh_msgs/NavigationModeActionGoal")._md5sum
        return found

    assert goal("1.0.9") == goal("1.0.10") == goal("1.1.1")
    assert goal("1.0.6") == goal("1.0.7")
    assert goal("1.1.2") == goal("1.1.4") == goal("2.0.0")
    assert goal("1.0.8") != goal("1.0.7") != goal("page")
    assert firmware_names()[0] == CURRENT
    assert isinstance(firmware("page"), Firmware)
    with pytest.raises(ValueError, match=r"1\.1\.4"):
        firmware("latest")


def test_the_page_about_firmwares_names_them_all() -> None:
    """Its table of known revisions, in their order."""
    page = (Path(__file__).resolve().parents[2] / "docs" / "firmware.md").read_text("utf-8")
    rows = page.partition("## Known revisions")[2].partition("\n## ")[0]
    listed = re.findall(r"^\| (page|[0-9.]+)", rows, re.MULTILINE)
    assert listed == firmware_names()


def test_the_command_serves_a_firmware(capsys: pytest.CaptureFixture[str]) -> None:
    """`woosh sim --firmware`; what is not a firmware is wrong use."""
    assert main(["sim", "--port", "0", "--for", "0.1", "--firmware", "1.0.8"]) == 0
    assert "firmware 1.0.8" in capsys.readouterr().out
    assert main(["sim", "--port", "0", "--for", "0.1", "--firmware", "latest"]) == 2
    assert "1.1.0, 1.0.12" in capsys.readouterr().err


def test_a_service_of_a_definition_from_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The vendor's .srv makes it known; what it has no field for is refused, and all else works."""
    text = bundled().service("woosh_msgs/ExecTask").text
    lines = [line for line in text.split("\n") if not re.match(r"byte custom\b", line)]
    assert len(lines) == text.count("\n")
    place = tmp_path / "woosh_msgs" / "srv"
    place.mkdir(parents=True)
    (place / "ExecTask.srv").write_text("\n".join(lines))
    special = Firmware("special", bundled().fork([tmp_path]))
    monkeypatch.setattr("woosh_pure.sim.chassis.firmware_named", lambda name: special)
    with SimulatedChassis(speed=8.0, full_graph=False) as sim:
        with Chassis(sim.master_uri) as chassis, pytest.raises(Md5sumMismatch, match="woosh learn"):
            chassis.go_to_mark("A1")
        with Chassis(sim.master_uri, msg_path=[tmp_path]) as chassis:
            with pytest.raises(FirmwareLimit, match="no field for custom") as caught:
                chassis.task(TaskType.PICK, "A1", custom=3)
            assert (caught.value.name, caught.value.firmware) == ("/exec_task", "")
            assert not sim.world.tasks.busy
            assert chassis.go_to_mark("A1").wait(60.0).arrived
