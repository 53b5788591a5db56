"""The doctor: each illness is made, and named."""

from __future__ import annotations

import functools
import json
import re
import socket
import threading

import pytest

import rosproto
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.cli import main
from woosh_pure.doctor.checks import finding_of
from woosh_pure.doctor.examination import Level, check_own_address, examine

pytestmark = pytest.mark.whole


def findings(uri: str, timeout: float = 20.0) -> dict[str, list]:
    """Findings by check."""
    found: dict[str, list] = {}
    for finding in examine(uri, listen=2.0, timeout=timeout, robot_api=False):
        found.setdefault(finding.check, []).append(finding)
    return found


def problems(found: dict[str, list]) -> set[str]:
    return {check for check, some in found.items() for f in some if f.level is Level.PROBLEM}


@pytest.fixture(scope="module")
def healthy():
    with SimulatedChassis() as sim:
        yield sim


def test_a_healthy_chassis_has_no_problem(healthy):
    found = findings(healthy.master_uri)
    assert problems(found) == set()
    assert found["back"][0].level is Level.OK
    assert found["competitor"][0].level is Level.OK


def test_no_master_is_told_with_what_to_check():
    found = findings("http://127.0.0.1:1/")
    assert problems(found) == {"reach"}
    assert "refuses" in found["reach"][0].text


def test_a_name_that_does_not_resolve():
    assert problems(findings("http://no-such-robot.invalid:11311/")) == {"name"}


def test_something_that_is_no_master():
    with socket.create_server(("127.0.0.1", 0)) as server:

        def hang_up() -> None:
            for _ in range(4):
                try:
                    server.accept()[0].close()
                except OSError:
                    return

        threading.Thread(target=hang_up, daemon=True).start()
        assert problems(findings(f"http://127.0.0.1:{server.getsockname()[1]}/")) == {"master"}


def test_another_robots_master():
    with rosproto.Master() as master:
        assert "interface" in problems(findings(master.uri))


def test_a_chassis_that_cannot_reach_us(healthy, monkeypatch):
    """The firewall case: our node turns every caller away, and a node of the robot is really asked to come."""
    monkeypatch.setattr(rosproto, "Node", functools.partial(rosproto.Node, allow=["192.0.2.1"]))
    found = findings(healthy.master_uri, timeout=1.0)
    assert "back" in problems(found)
    assert "firewall" in found["back"][0].advice


def test_a_node_whose_name_does_not_resolve(healthy):
    client = rosproto.MasterClient(healthy.master_uri, "/broken")
    client.register_publisher("/battery", "woosh_msgs/Battery", "http://robot-name.invalid:4711/")
    try:
        found = findings(healthy.master_uri)
        assert any("does not resolve" in f.text and "/broken" in f.text for f in found["node"])
    finally:
        client.unregister_publisher("/battery", "http://robot-name.invalid:4711/")


def test_another_definition_is_named(healthy):
    other = rosproto.define("woosh_msgs/BMS", "uint8 something_else\n")
    with rosproto.Node("/old_firmware", master_uri=healthy.master_uri, intraprocess=False) as node:
        node.publisher("/driver_base/bms", other, latch=True).publish(something_else=1)
        found = findings(healthy.master_uri)
    assert any("/driver_base/bms" in f.text for f in found["definition"])
    assert all(f.level is not Level.OK for f in found["definition"])


def test_a_known_revision_is_named_by_its_firmware_and_needs_nothing():
    with SimulatedChassis(firmware="1.1.0") as sim:
        found = findings(sim.master_uri)["definition"]
    steps = next(f for f in found if f.text.startswith("/cmd_vel_control/goal"))
    assert "as of firmware 1.1.0" in steps.text
    assert "nothing to do" in steps.advice
    assert all(f.level is Level.WARNING for f in found)


def test_services_are_asked_too():
    with SimulatedChassis(firmware="page", full_graph=False) as sim:
        found = findings(sim.master_uri)["definition"]
    assert any(f.text.startswith("/exec_task: /ros_interface has woosh_msgs/ExecTask") for f in found)


def test_an_unknown_revision_is_told_with_both_md5sums_and_what_to_do():
    finding = finding_of("/battery", "/node", "woosh_msgs/Battery", "0" * 32, "1" * 32)
    assert "0" * 32 in finding.text
    assert "1" * 32 in finding.text
    assert "woosh learn" in finding.advice


def test_the_robots_own_nodes_are_no_competitors(healthy):
    """Seen on a real graph: the robot's own programs publish goals and velocities, too."""
    client = rosproto.MasterClient(healthy.master_uri, "/woosh_auto_dock_node")
    client.register_publisher("/smooth_cmd_vel", "geometry_msgs/Twist", "http://127.0.0.1:1/")
    try:
        assert findings(healthy.master_uri)["competitor"][0].level is Level.OK
    finally:
        client.unregister_publisher("/smooth_cmd_vel", "http://127.0.0.1:1/")


def test_a_silent_topic_and_a_competitor():
    with SimulatedChassis(full_graph=False) as sim, Chassis(sim.master_uri) as rival:
        rival.move(0.1).wait()
        sim.fall_silent(30.0)
        found = findings(sim.master_uri)
        name = rival.node.name
    assert "/battery" in found["silent"][0].text
    assert any(name in f.text for f in found["competitor"])


def test_a_clock_that_runs_faster():
    """A simulated robot at six times real time: how far its clock is ahead is another number each second."""
    with SimulatedChassis(speed=6, full_graph=False) as sim:
        found = findings(sim.master_uri)["clock"][0]
    assert found.level is Level.OK
    rate = re.search(r"runs ([\d.]+) times as fast as ours", found.text)
    assert rate
    assert 3.0 < float(rate[1]) < 12.0


def test_a_clock_that_is_off():
    with SimulatedChassis(full_graph=False) as sim:
        sim.set_clock(100.0)
        found = findings(sim.master_uri)["clock"][0]
    told = re.search(r"clock is ([\d.]+) s ahead", found.text)
    assert told is not None
    assert found.level is Level.WARNING
    assert "our goals carry no stamp" in found.advice
    assert 95.0 < float(told[1]) < 101.0  # 100 s, less what a message may be late on a busy computer


@pytest.mark.parametrize(
    ("robot", "own", "level"),
    [
        ("169.254.128.2", "169.254.128.20", Level.OK),
        ("169.254.128.2", "169.254.128.49", Level.OK),
        ("169.254.128.2", "169.254.128.50", Level.PROBLEM),
        ("169.254.128.2", "192.168.1.5", Level.PROBLEM),
        ("10.0.0.7", "10.0.0.9", Level.OK),
    ],
)
def test_the_address_on_the_cable(robot, own, level):
    assert check_own_address(robot, own).level is level


def test_the_command_has_an_exit_code_and_json(healthy, capsys):
    assert main(["doctor", "--master", healthy.master_uri, "--json", "--listen", "1"]) == 0
    assert json.loads(capsys.readouterr().out)["ok"] is True
    assert main(["doctor", "--master", "http://127.0.0.1:1"]) == 1
    assert "->" in capsys.readouterr().out


def test_a_master_without_a_chassis_is_a_problem(capsys):
    """A foreign node is not a chassis, whatever it publishes."""
    with rosproto.Master() as master, rosproto.Node("/foreign", master_uri=master.uri) as node:
        node.publisher("/odom", "nav_msgs/Odometry")
        found = findings(master.uri)
        assert problems(found) == {"interface"}
        text = found["interface"][0].text
        assert text.startswith(
            "no Woosh chassis here, or not all of it: /robot_status, /exec_task, /move_base missing"
        )
        assert sum(map(len, found.values())) < 12
        assert main(["doctor", "--master", master.uri, "--listen", "0.1"]) == 1
        assert "no problem was found" not in capsys.readouterr().out


def test_one_name_that_does_not_resolve_is_told_once_for_all_nodes():
    """The master's address does not answer for them here: what else is needed is said."""
    with SimulatedChassis(full_graph=False) as sim:
        gone = socket.create_server(("127.0.0.1", 0))
        uri = f"http://robot-xyz.invalid:{gone.getsockname()[1]}/"
        gone.close()
        for number in range(17):
            with rosproto.MasterClient(sim.master_uri, f"/node_{number}") as client:
                client.register_publisher("/battery", "woosh_msgs/Battery", uri)
        told = [f for f in findings(sim.master_uri)["node"] if "robot-xyz" in f.text]
    assert len(told) == 1
    assert told[0].level is Level.PROBLEM
    assert "17 nodes (/node_0, /node_1," in told[0].text
    assert "and 12 more" in told[0].text
    assert 'the line "127.0.0.1 robot-xyz.invalid" to ' in told[0].advice
    assert "with its own address in place of 127.0.0.1" in told[0].advice


def test_a_robot_that_is_known_by_its_name_only(healthy, monkeypatch, capsys):
    """Everything by a name that the system does not know: given by hand, to the API and to the commands."""
    uri = healthy.master_uri.replace("127.0.0.1", "robot-xyz.invalid")
    names = {"robot-xyz.invalid": "127.0.0.1"}
    with Chassis(uri, resolve=names) as chassis:
        assert chassis.battery.wait(10.0).percent > 0
    assert main(["--master", uri, "battery", "--resolve", "robot-xyz.invalid=127.0.0.1"]) == 0
    monkeypatch.setenv("ROSPROTO_RESOLVE", "robot-xyz.invalid=127.0.0.1")
    assert main(["--master", uri, "battery"]) == 0
    capsys.readouterr()
    assert main(["--master", uri, "battery", "--resolve", "robot-xyz.invalid"]) == 2
    assert "is not of the form NAME=IP" in capsys.readouterr().err
    with pytest.raises(ValueError, match="not a host name or address"):
        Chassis(uri, resolve={"robot": "http://127.0.0.1"})


def test_the_report_is_written_once_and_does_not_tell_where(healthy, tmp_path, capsys):
    path = tmp_path / "report.json"
    words = [
        "--chassis",
        healthy.master_uri,
        "--lang",
        "en",
        "doctor",
        "--listen",
        "0.5",
        "--report",
        str(path),
    ]
    main(words)
    assert f"the report is in {path}" in capsys.readouterr().out
    document = json.loads(path.read_text("utf-8"))
    assert document["graph"]["topics"]["/robot_status"] == "woosh_msgs/RobotStatus"
    assert {"check", "level", "text", "advice"} <= document["findings"][0].keys()
    assert document["system"]["woosh-pure"] == rosproto.__version__
    assert socket.gethostname() not in path.read_text("utf-8")
    assert main(words) == 2  # an older report is not replaced
    assert "already exists" in capsys.readouterr().err
