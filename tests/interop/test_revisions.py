"""Peers whose classes genpy and gencpp made from another revision of woosh_msgs: they know nothing of ours.

Neither rospy nor roscpp negotiates: a publisher of theirs refuses an md5sum that is not its own, a subscriber
takes its own only. So whatever comes through here was carried over by us.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from rosproto import ActionClient, Node
from rosproto.codec import message_class, service_class
from rosproto.errors import RosTimeout
from rosproto.master import Master
from rosproto.msg import bundled
from tests.support import ros
from woosh_pure import Chassis, FirmwareLimit
from woosh_pure.enums import NavDirection, NavigationMode
from woosh_pure.firmware.learn import KnownDefinitions, compare
from woosh_pure.firmware.survey import survey

Packages = Callable[[str], str]
TYPES = [
    ("1.1.0", "woosh_msgs/StepControlActionGoal"),
    ("1.0.8", "woosh_msgs/NavigationModeActionGoal"),
    ("page", "woosh_msgs/Battery"),
    ("page", "woosh_msgs/Parameter"),
    ("page", "woosh_msgs/ExecTask"),
]


@pytest.mark.parametrize(("label", "name"), TYPES)
def test_genpy_has_the_md5sums_of_our_revisions(revised_packages: Packages, label: str, name: str) -> None:
    """The revisions, as another implementation reads them."""
    package, _, base = name.partition("/")
    kind = "srv" if name == "woosh_msgs/ExecTask" else "msg"
    code = f"from {package}.{kind} import {base} as c; print(c._md5sum)"
    said = ros.run_rospy(code, "http://127.0.0.1:1", packages=revised_packages(label))
    library = bundled().package_revisions(package)[label]
    assert said.stdout.strip() == library.md5sum(name, kind=kind) != bundled().md5sum(name, kind=kind)


ECHO = """
import rospy
from woosh_msgs.msg import Battery, Parameter
rospy.init_node("robot", disable_signals=True)
for name, cls in (("battery", Battery), ("parameter", Parameter)):
    out = rospy.Publisher("/" + name, cls, queue_size=10)
    rospy.Subscriber("/%s_in" % name, cls, out.publish)
print("up", flush=True)
rospy.spin()
"""


def exchanged(publisher: Any, subscriber: Any, message: Any) -> Any:
    """The echo of a message; rospy counts a subscriber as connected only after it has answered it."""
    publisher.wait_for_connection(60)
    subscriber.wait_for_connection(60)
    for _ in range(20):
        publisher.publish(message)
        try:
            return subscriber.next(1.0)
        except TimeoutError:
            continue
    raise AssertionError(f"no echo: {subscriber.errors}, {publisher.stats()}")


def test_topics_with_rospy_of_another_revision(any_master: str, revised_packages: Packages) -> None:
    """Fields in another place and of another type: ours -> rospy -> ours, every value under its name."""
    battery, parameter = message_class("woosh_msgs/Battery"), message_class("woosh_msgs/Parameter")
    with (
        ros.start_rospy(ECHO, any_master, packages=revised_packages("page")) as process,
        Node("/ours", master_uri=any_master) as node,
    ):
        process.wait_for("up")
        out, back = node.publisher("/battery_in", battery), node.subscriber("/battery", battery)
        sent = battery(batteryPercentage=81, bmsStatus=70000, cellVoltageMax=3.5, cellVoltageMin=3.25)
        got = exchanged(out, back, sent)
        assert type(got) is battery
        assert (got.batteryPercentage, got.bmsStatus) == (81, 70000)
        assert (got.cellVoltageMax, got.cellVoltageMin) == (3.5, 3.25)
        assert out.revisions["/robot"]._md5sum == "fd17243c9e3a3a1061b0c8f4e5bf0361"
        out, back = node.publisher("/parameter_in", parameter), node.subscriber("/parameter", parameter)
        assert surveyed(node, "/battery", "/parameter") == [("revision", "page")] * 2
        got = exchanged(out, back, parameter(pulsePerCircle=10000, maxSpeed=1.5, minSpeed=0.25))
        assert (got.pulsePerCircle, got.maxSpeed, got.minSpeed) == (10000, 1.5, 0.25)
        assert isinstance(got.pulsePerCircle, int)


def surveyed(node: Node, *names: str) -> list[tuple[str, str]]:
    """What `woosh learn` finds out about topics and services: verdict and revision."""
    findings = {answer.name: compare(answer, KnownDefinitions()) for answer in survey(node, timeout=60)}
    return [(findings[name].verdict, findings[name].source) for name in names]


SERVICES = """
import rospy
from woosh_msgs.srv import ExecTask, ExecTaskResponse
rospy.init_node("robot", disable_signals=True)
def answer(r): return ExecTaskResponse(success=True, message=r.mark_no, statuscode=r.task_exec + 1)
rospy.Service("/theirs", ExecTask, answer)
rospy.wait_for_service("/ours", 60)
for persistent in (False, True):
    call = rospy.ServiceProxy("/ours", ExecTask, persistent=persistent)
    for _ in range(2):
        r = call(task_exec=4, mark_no="B2"); print("got", r.success, r.message, r.statuscode, flush=True)
print("up", flush=True)
rospy.spin()
"""


def test_services_with_rospy_of_another_revision(any_master: str, revised_packages: Packages) -> None:
    """The page's spelling on the other side: requests and responses arrive under the names of ours."""
    exec_task = service_class("woosh_msgs/ExecTask")
    with (
        Node("/ours_node", master_uri=any_master) as node,
        node.service_server(
            "/ours", exec_task, lambda r: {"success": True, "message": r.mark_no, "statusCode": r.task_exect}
        ),
        ros.start_rospy(SERVICES, any_master, packages=revised_packages("page")) as process,
    ):
        process.wait_for("up")
        assert process.output.count("got True B2 4") == 4
        for persistent in (False, True):
            with node.service_client("/theirs", exec_task, persistent=persistent) as client:
                for _ in range(2):
                    response = client.call(task_exect=2, mark_no="A1", timeout=60)
                    assert (response.success, response.message, response.statusCode) == (True, "A1", 3)


ROBOT = """
import threading, rospy, actionlib
from geometry_msgs.msg import Twist
from std_msgs.msg import UInt64
from woosh_msgs.msg import *
from woosh_msgs.srv import ExecTask, ExecTaskResponse
rospy.init_node("ros_interface", disable_signals=True)
status = rospy.Publisher("/robot_status", RobotStatus, queue_size=10, latch=True)
battery = rospy.Publisher("/battery", Battery, queue_size=10)
measured = rospy.Publisher("/odom_twist", Twist, queue_size=10)
def say(task_id, state): status.publish(RobotStatus(task_id=task_id, task_state=state, robot_state=4, robot_mode=1, work_mode=2))
def exec_task(r):
    say(r.task_id, 3); threading.Timer(0.3, say, (r.task_id, 7)).start()
    return ExecTaskResponse(True, "", 4)
rospy.Service("/exec_task", ExecTask, exec_task)
def step(goal):
    print("steps", [(s.executeMode, round(s.data, 3), [f for f in s.__slots__]) for s in goal.stepControl], flush=True)
    for percent in (50.0, 100.0):
        steps.publish_feedback(StepControlFeedback(executeMode=goal.stepControl[0].executeMode, percent=percent))
    while not rospy.has_param("/seen"): rospy.sleep(0.01)  # the result has a connection of its own, and may be first
    steps.set_succeeded(StepControlResult(result=1, executeMode=1, percent=100.0), "well")
steps = actionlib.SimpleActionServer("/cmd_vel_control", StepControlAction, step, auto_start=False); steps.start()
def mode(goal):
    print("mode", goal.navigation_mode, round(goal.max_speed, 3), flush=True)
    modes.set_succeeded(NavigationModeResult(result=1))
modes = actionlib.SimpleActionServer("/navigation_mode", NavigationModeAction, mode, auto_start=False); modes.start()
def go(goal):
    print("go", goal.target_pose.pose.position.x, flush=True); base.set_succeeded(MoveBaseResult())
base = actionlib.SimpleActionServer("/move_base", MoveBaseAction, go, auto_start=False); base.start()
say(1, 7)
print("up", flush=True)
while not rospy.is_shutdown():
    battery.publish(Battery(batteryPercentage=55, bmsStatus=3, cellVoltageMin=3.5)); measured.publish(Twist()); rospy.sleep(0.05)
"""


@pytest.fixture(params=["1.1.0", "1.0.8", "page"])
def robot(
    request: pytest.FixtureRequest, our_master: Master, revised_packages: Packages
) -> Iterator[tuple[str, Any, Chassis]]:
    """A rospy robot of an older revision, and a Chassis on it."""
    packages = revised_packages(request.param)
    with ros.start_rospy(ROBOT, our_master.uri, packages=packages) as process:
        process.wait_for("up")
        with Chassis(our_master.uri, learned=False) as chassis:
            yield request.param, process, chassis


def test_a_chassis_of_rospy_nodes_of_another_revision(robot: tuple[str, Any, Chassis]) -> None:
    """Reading, tasks, steps, navigation and its mode; what cannot be said is refused and never arrives."""
    label, process, chassis = robot
    battery = chassis.battery.wait(60)
    assert (battery.percent, battery.bms_status, battery.cell_voltage_min) == (55, 3, 3.5)
    assert chassis.go_to_mark("A").wait(60).arrived
    handle = chassis.move(0.5)
    assert next(report.percent for report in handle.reports() if report.percent > 50.0) == 100.0
    chassis.node.params["/seen"] = True
    assert handle.wait(60).code == 1
    assert "angle" not in process.wait_for(r"steps \[\(1, 0.5, .*").group()
    assert chassis.go_to(1.5, 0.0).wait(60).arrived
    process.wait_for(r"go 1.5")
    chassis.set_navigation_mode(NavigationMode.STOP_AND_WAIT, max_speed=0.5)
    process.wait_for(r"mode 2 0.5")
    with pytest.raises(FirmwareLimit):
        chassis.move_diagonal(0.2, 0.5)
    with pytest.raises(FirmwareLimit, match="nav_dir"):
        chassis.set_navigation_mode(NavigationMode.STOP_AND_WAIT, direction=NavDirection.BACKWARD)
    if label == "1.0.8":
        with pytest.raises(FirmwareLimit, match="no lateral steps"):
            chassis.strafe(0.2)
    else:
        assert chassis.strafe(0.25).wait(60).code == 1
        process.wait_for(r"steps \[\(3, 0.25")
    assert process.output.count("mode ") == 1
    assert "(4," not in process.output


def test_our_action_client_with_rospys_server_of_another_revision(robot: tuple[str, Any, Chassis]) -> None:
    """The plain client carries the goal over too, and tells what the server takes."""
    label, process, chassis = robot
    node = chassis.node
    with ActionClient(node, "/cmd_vel_control", "woosh_msgs/StepControl") as client:
        client.wait_for_server(60)
        library = bundled().package_revisions("woosh_msgs")[label]
        assert client.revisions["/ros_interface"]._md5sum == library.md5sum(
            "woosh_msgs/StepControlActionGoal"
        )
        step = message_class("woosh_msgs/StepControl")(executeMode=1, data=0.75, angle=0.5)
        node.params["/seen"] = True
        handle = client.send_goal(client.type.goal(mode=1, stepControl=[step]))
        assert handle.wait(60).percent == 100.0
        assert handle.text == "well"
        process.wait_for(r"steps \[\(1, 0.75")


ROSCPP_ECHO = r"""
#include <ros/ros.h>
#include <woosh_msgs/Battery.h>
#include <woosh_msgs/ExecTask.h>
bool answer(woosh_msgs::ExecTask::Request &request, woosh_msgs::ExecTask::Response &response) {
    response.success = true; response.message = request.mark_no; response.statuscode = request.task_exec + 1;
    return true;
}
int main(int argc, char **argv) {
    ros::init(argc, argv, "robot", ros::init_options::NoSigintHandler);
    ros::NodeHandle node;
    ros::Publisher out = node.advertise<woosh_msgs::Battery>("/battery", 10);
    boost::function<void(const woosh_msgs::Battery &)> back = [&](const woosh_msgs::Battery &m) { out.publish(m); };
    ros::Subscriber in = node.subscribe<woosh_msgs::Battery>("/battery_in", 10, back);
    ros::ServiceServer server = node.advertiseService("/theirs", answer);
    if (!ros::service::waitForService("/ours", ros::Duration(20))) return 1;
    ros::ServiceClient client = node.serviceClient<woosh_msgs::ExecTask>("/ours");
    woosh_msgs::ExecTask call; call.request.task_exec = 4; call.request.mark_no = "B2";
    bool done = client.call(call);
    printf("got %d %s %d\n", done, call.response.message.c_str(), call.response.statuscode); fflush(stdout);
    ros::spin();
}
"""


def test_topics_and_services_with_roscpp_of_another_revision(
    any_master: str, build_revised_roscpp: Callable[..., Path]
) -> None:
    """The same with gencpp's classes, both ways."""
    program = build_revised_roscpp("revised_echo", ROSCPP_ECHO, "page")
    battery, exec_task = message_class("woosh_msgs/Battery"), service_class("woosh_msgs/ExecTask")
    with (
        Node("/ours_node", master_uri=any_master) as node,
        node.service_server(
            "/ours", exec_task, lambda r: {"success": True, "message": r.mark_no, "statusCode": r.task_exect}
        ),
        ros.start_program(program, any_master) as process,
    ):
        process.wait_for("got 1 B2 4")
        out, back = node.publisher("/battery_in", battery), node.subscriber("/battery", battery)
        got = exchanged(out, back, battery(batteryPercentage=81, bmsStatus=70000, cellVoltageMax=3.5))
        assert (got.batteryPercentage, got.bmsStatus, got.cellVoltageMax) == (81, 70000, 3.5)
        with node.service_client("/theirs", exec_task) as client:
            response = client.call(task_exect=2, mark_no="A1", timeout=60)
            assert (response.success, response.message, response.statusCode) == (True, "A1", 3)
        assert surveyed(node, "/battery", "/theirs") == [("revision", "page")] * 2


FUTURE = "uint32 batteryPercentage\nstring chemistry\nuint8 submodule\n"
ROSCPP_FUTURE = r"""
#include <ros/ros.h>
#include <woosh_msgs/Battery.h>
void take(const woosh_msgs::Battery &m) {
    printf("took %u '%s' %u\n", m.batteryPercentage, m.chemistry.c_str(), m.submodule); fflush(stdout);
}
int main(int argc, char **argv) {
    ros::init(argc, argv, "robot", ros::init_options::NoSigintHandler);
    ros::NodeHandle node;
    ros::Publisher other;
    if (argc > 1) other = node.advertise<woosh_msgs::Battery>("/battery_in", 10);
    ros::Subscriber in = node.subscribe("/battery_in", 10, take);
    puts("up"); fflush(stdout);
    ros::spin();
}
"""


@pytest.mark.parametrize("tells", [True, False], ids=["a publisher tells", "nobody tells"])
def test_a_roscpp_subscriber_of_a_definition_nobody_bundled(
    our_master: Master, build_revised_roscpp: Callable[..., Path], tells: bool
) -> None:
    """It names an md5sum only; whoever else publishes the topic tells the definition behind it."""
    program = build_revised_roscpp("future", ROSCPP_FUTURE, "page+future", {"msg/Battery.msg": FUTURE})
    with (
        ros.start_program(program, our_master.uri, *(["publish"] if tells else [])) as process,
        Node("/ours", master_uri=our_master.uri) as node,
    ):
        process.wait_for("up")
        out = node.publisher("/battery_in", "woosh_msgs/Battery")
        if not tells:
            with pytest.raises(RosTimeout, match="woosh learn"):
                out.wait_for_connection(3)
            return
        out.wait_for_connection(60)
        out.publish(batteryPercentage=42, submodule=3)
        process.wait_for("took 42 '' 3")
