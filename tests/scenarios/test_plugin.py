"""The pytest plugin for applications, and faults of the simulator from Python and from the command line."""

from __future__ import annotations

import pytest

from rosproto.errors import RosError
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.cli import main
from woosh_pure.cli.commands.sim import FAULTS, inject
from woosh_pure.enums import RobotMode


@pytest.mark.slow
def test_an_application_gets_its_chassis(tmp_path):
    import subprocess
    import sys
    from pathlib import Path

    (tmp_path / "conftest.py").write_text('pytest_plugins = ["woosh_pure.pytest_plugin"]\n')
    (tmp_path / "test_app.py").write_text(
        "def test_delivery(chassis, simulated_chassis):\n"
        "    chassis.go_to_mark('P1').wait(60)\n"
        "    assert simulated_chassis.pose.y > 2\n"
    )
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-p",
        "no:xdist",
        "-p",
        "no:randomly",
        "-p",
        "no:cacheprovider",
    ]
    import os

    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[2])}
    environment.pop("PYTEST_ADDOPTS", None)
    result = subprocess.run(
        [*command, "--rootdir", str(tmp_path), str(tmp_path)],
        capture_output=True,
        text=True,
        timeout=110,
        cwd=tmp_path,
        env=environment,
    )
    assert "1 passed" in result.stdout, result.stdout + result.stderr


def test_faults_of_the_command_line_reach_the_world(sim, until):
    for fault in ("estop", "release", "obstacle:1:2", "lost", "manual", "automatic", "cable", "uncable"):
        inject(sim, fault)
    assert sim.world.obstacles == [(1.0, 2.0, 0.25)]
    assert not sim.world.located
    assert sim.world.robot_mode is RobotMode.AUTOMATIC
    sim.world.bumper = True
    inject(sim, "free")
    assert not sim.world.bumper
    inject(sim, "clear")
    assert sim.world.obstacles == []
    with pytest.raises(ValueError, match="obstacle"):
        inject(sim, "obstacle")


def test_the_schedule_of_the_sim_command(capsys):
    assert main(["sim", "--port", "0", "--for", "0.01", "--at", "0.005=estop"]) == 0  # noticed after the end
    assert "now: estop" in capsys.readouterr().out
    assert main(["sim", "--port", "0", "--at", "1=earthquake"]) == 2
    assert next(iter(FAULTS)) in capsys.readouterr().err


def test_a_slow_network_delays_what_is_heard(sim, chassis, until):
    chassis.odometry.wait(5.0)
    sim.slow_network(0.3)
    slow = sim.now
    until(lambda: chassis.odometry.reading.stamp > slow, what="odometry that was sent over the slow network")
    before = sim.now
    reading = chassis.odometry.wait(5.0) and chassis.odometry.reading
    assert reading.stamp < before


def test_a_master_restart_is_survived(sim, chassis, until):
    chassis.battery.wait(5.0)
    sim.restart_master()
    with Chassis(sim.master_uri) as late:
        assert late.battery.wait(30.0).percent == 87
    assert chassis.battery.wait(5.0).percent == 87


@pytest.mark.slow  # it waits for an answer
def test_a_crashed_node_is_an_error_in_time(sim, chassis):
    sim.crash_node("/ros_interface")
    with pytest.raises(RosError):
        chassis.go_to_mark("A1")


def test_many_chassis_in_one_process():
    sims = [SimulatedChassis(full_graph=False, speed=4) for _ in range(4)]
    try:
        for sim in sims:
            sim.start()
        assert len({sim.master_uri for sim in sims}) == 4
    finally:
        for sim in sims:
            sim.close()


def test_a_simulated_chassis_that_is_not_started_says_so():
    with pytest.raises(RuntimeError, match="with SimulatedChassis"):
        SimulatedChassis().master_uri  # noqa: B018
    with pytest.raises(ValueError, match="speed"):
        SimulatedChassis(speed=0.0)
