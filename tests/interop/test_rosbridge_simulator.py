"""A web page and the simulated chassis: `rosproto bridge` before `woosh sim`, with roslib as it comes from npm."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from tests.interop.web_page import pages
from tests.support import ros
from tests.support.extras import needs
from tests.support.victim import eventually
from woosh_pure import SimulatedChassis

needs("bridge")


@pytest.fixture
def sim() -> Iterator[SimulatedChassis]:
    """A chassis in the built-in hall, ten times as fast as a real one."""
    with SimulatedChassis(speed=10.0) as chassis:
        yield chassis


@contextmanager
def bridge(sim: SimulatedChassis, *options: str) -> Iterator[str]:
    """URL of the command, as a user starts it."""
    command = [
        sys.executable,
        "-m",
        "rosproto",
        "bridge",
        "--master",
        sim.master_uri,
        "--port",
        "0",
        *options,
    ]
    with ros.RosProcess(command, ros.environment(sim.master_uri.rstrip("/"))) as process:
        yield process.wait_for(r"Serving rosbridge at (\S+)").group(1)


LOOK = """
const first = (name, type, more) => new Promise(done => {
  const it = topic(name, type, more); it.subscribe(m => { it.unsubscribe(); done(m); }); });
const odom = await first('/odom', 'nav_msgs/Odometry', {compression: 'cbor'});
say('odom', odom.header.frame_id, odom.pose.covariance.length);
const [worked, {map}] = await call('/aic_map_server/get_map', 'nav_msgs/GetMap', {});
say('map', worked, map.info.width * map.info.height === map.data.length);
say('scan', (await first('/scan', 'sensor_msgs/LaserScan', {compression: 'png'})).ranges.length > 0);
say('tf', await new Promise(done => new ROSLIB.TFClient({ros, fixedFrame: 'map', rate: 20})
  .subscribe('base_link', t => done(typeof t.translation.x))));
"""


def test_a_page_sees_the_chassis(sim: SimulatedChassis) -> None:
    """Odometry, the map (its service only answers), the scan, and where it is, with nothing opened for writing."""
    with bridge(sim) as url, pages(url) as open_page:
        page = open_page(LOOK)
        assert page.said("odom")[0][1] == 36
        assert page.said("map") == [[True, True]]
        assert page.said("scan") == [[True]]
        assert page.said("tf") == [["number"]]


TRY = """
const drive = topic('/smooth_cmd_vel', 'geometry_msgs/Twist');
drive.publish({linear: {x: 0.5}});
say('task', ...await call('/exec_task', 'woosh_msgs/ExecTask', {task_exect: 1, task_id: 1, task_type: 1, mark_no: 'A1'}));
say('goal', await new Promise(done => new ROSLIB.Action({ros, name: '/move_base', actionType: 'woosh_msgs/MoveBase'})
  .sendGoal({target_pose: {}}, () => done('sent'), undefined, done)));
const client = new ROSLIB.ActionClient({ros, serverName: '/move_base', actionName: 'woosh_msgs/MoveBaseAction'});
new ROSLIB.Goal({actionClient: client, goalMessage: {target_pose: {pose: {position: {x: 3}}}}}).send();
const param = new ROSLIB.Param({ros, name: '/anything'});
say('param', await new Promise(done => param.set(1, () => done('set'), done)));
"""


def test_nothing_that_moves_it_is_open_by_default(sim: SimulatedChassis) -> None:
    """A velocity, a task, a goal by either way, a parameter: refused with a sentence, and it stands still."""
    before = sim.pose
    with bridge(sim) as url, pages(url) as open_page:
        page = open_page(TRY)
        ((worked, why),) = page.said("task")
        assert not worked
        assert "--allow-write" in why
        assert "--allow-write" in page.said("goal")[0][0]
        assert "--allow-write" in page.said("param")[0][0]
        refused = "\n".join(text for _, text in page.said("status", 3))
        assert "/smooth_cmd_vel" in refused
        assert "/move_base/goal" in refused
    assert sim.pose == before


DRIVE = """
const pose = (x, y) => ({header: {frame_id: 'map'}, pose: {position: {x, y}, orientation: {w: 1}}});
const go = (x, y, cancel) => new Promise(done => {
  const action = new ROSLIB.Action({ros, name: '/move_base', actionType: 'woosh_msgs/MoveBase'});
  let asked = false;
  const id = action.sendGoal({target_pose: pose(x, y)}, () => done('arrived'), f => {
    if (cancel && !asked) { asked = true; action.cancelGoal(id); } }, e => done(e));
});
say('arrived', await go(1, 0));
say('cancelled', await go(3, 1, true));
const client = new ROSLIB.ActionClient({ros, serverName: '/move_base', actionName: 'woosh_msgs/MoveBaseAction'});
const old = (x, y, cancel) => new Promise(done => {
  const goal = new ROSLIB.Goal({actionClient: client, goalMessage: {target_pose: pose(x, y)}});
  goal.on('feedback', () => { if (cancel) goal.cancel(); });
  goal.on('result', () => done(goal.status.status));
  goal.send();
});
await new Promise(done => setTimeout(done, 1000));
say('old', await old(0, 0));
say('old cancelled', await old(3, 1, true));
"""
TASK = """
topic('/robot_status', 'woosh_msgs/RobotStatus').subscribe(m => say('state', m.robot_state));
const task = (task_exect, mark_no) =>
  call('/exec_task', 'woosh_msgs/ExecTask', {task_exect, task_id: 77, task_type: 1, mark_no});
say('started', ...await task(1, 'A1'));
setTimeout(async () => say('given up', ...await task(4, 'A1')), 300);
"""


def test_a_page_drives_it_to_a_place_and_to_a_mark(sim: SimulatedChassis) -> None:
    """With patterns: goals by the new operations and the old topics, done and cancelled; a task to a mark."""
    open_ = ("--allow-write", "action:/move_base", "--allow-write", "service:/exec_task")
    with bridge(sim, *open_) as url, pages(url) as open_page:
        page = open_page(DRIVE)
        assert page.said("arrived") == [["arrived"]]
        assert "canceled" in page.said("cancelled")[0][0]
        assert page.said("old") == [[3]]
        assert page.said("old cancelled") == [[2]]
        assert sim.pose.x < 3.5
        page = open_page(TASK)
        ((worked, answer),) = page.said("started")
        assert (worked, answer["success"]) == (True, True), answer
        ((worked, answer),) = page.said("given up")
        assert (worked, answer["success"]) == (True, True), answer


VELOCITY = """
const drive = topic('/smooth_cmd_vel', 'geometry_msgs/Twist');
drive.advertise();
const timer = setInterval(() => drive.publish({linear: {x: 0.3}}), 50);
setTimeout(() => say('driving'), 1500);
"""


def test_a_page_that_is_gone_leaves_a_zero(sim: SimulatedChassis) -> None:
    """Driving by velocity, opened by its pattern: the page is killed, and zero follows on the topic."""
    from rosproto import Node

    with (
        bridge(sim, "--allow-write", "topic:/smooth_cmd_vel") as url,
        Node("/ear", master_uri=sim.master_uri) as node,
        node.subscriber("/smooth_cmd_vel", "geometry_msgs/Twist", queue_size=1000) as ear,
    ):
        with pages(url) as open_page:
            open_page(VELOCITY).said("driving")
            eventually(lambda: ear.latest is not None and ear.latest.linear.x == 0.3, 20)
        eventually(lambda: ear.latest.linear.x == 0.0, 20)
