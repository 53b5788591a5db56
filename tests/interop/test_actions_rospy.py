"""Actions between us and rospy's actionlib, both ways; and the state table against the installed one."""

from __future__ import annotations

import json
import subprocess
import time
from collections.abc import Iterator

import pytest

import rosproto
from rosproto.action import ActionClient, ActionServer, CommState, GoalStatus, ServerGoal
from rosproto.errors import ConnectionLost
from rosproto.protocol.goal_client import transition_path
from tests.support import ros
from tests.support.load import crowd

ACTIONS = ["actionlib/TestAction", "woosh_msgs/StepControl"]
FIELD = {
    "actionlib/TestAction": ("goal", "result", "feedback"),
    "woosh_msgs/StepControl": ("mode", "percent", "percent"),
}

PREAMBLE = """
import sys, time, importlib, rospy, actionlib
package, name = sys.argv[1].split("/")
name = name.replace("Action", "")
module = importlib.import_module(package + ".msg")
Action, Goal, Result, Feedback = [getattr(module, name + part) for part in ("Action", "Goal", "Result", "Feedback")]
GOAL, RESULT, FEEDBACK = sys.argv[2:5]
def make(cls, field, value):
    m = cls(); setattr(m, field, value); return m
rospy.init_node("peer", disable_signals=True)
def say(*words): print(*words, flush=True)
"""

RosServer = (
    PREAMBLE
    + """
def execute(goal):
    value = getattr(goal, GOAL)
    say("goal", value)
    if value == 3:
        raise RuntimeError("rospy broke")
    if value == 4:
        server.set_aborted(make(Result, RESULT, 4), "cannot"); return
    server.publish_feedback(make(Feedback, FEEDBACK, 1))
    while value == 2:
        if server.is_preempt_requested():
            server.set_preempted(make(Result, RESULT, 9), "as you wish"); return
        time.sleep(0.01)
    server.set_succeeded(make(Result, RESULT, 7), "well")
server = actionlib.SimpleActionServer("act", Action, execute, auto_start=False)
server.start()
say("up")
rospy.spin()
"""
)

SimpleClient = (
    PREAMBLE
    + """
client = actionlib.SimpleActionClient("act", Action)
assert client.wait_for_server(rospy.Duration(60))
feedback = []
def fed(message):
    feedback.append(message); rospy.set_param("/fed", len(feedback))
def run(value, wait=60.0):
    client.send_goal(make(Goal, GOAL, value), feedback_cb=fed)
    rospy.set_param("/sent", value)
    assert client.wait_for_result(rospy.Duration(wait)), "no result for %s" % value
    say(value, client.get_state(), getattr(client.get_result(), RESULT),
    repr(client.get_goal_status_text()), len(feedback))
run(1)
run(3)
client.send_goal(make(Goal, GOAL, 2), feedback_cb=fed)
rospy.set_param("/sent", 2)
while client.get_state() != actionlib.GoalStatus.ACTIVE: time.sleep(0.01)
client.cancel_goal()
assert client.wait_for_result(rospy.Duration(60))
say("cancelled", client.get_state(), repr(client.get_goal_status_text()))
"""
)

ManyClient = (
    PREAMBLE
    + """
client = actionlib.ActionClient("act", Action)
assert client.wait_for_server(rospy.Duration(60))
seen = {}
def transition(handle):
    if handle.get_comm_state() == actionlib.CommState.DONE:
        seen[id(handle.comm_state_machine)] = (handle.get_terminal_state(), handle.get_goal_status_text())
handles = [client.send_goal(make(Goal, GOAL, 2), transition) for _ in range(3)]
def wait(count):
    end = time.time() + 60
    while len(seen) < count and time.time() < end: time.sleep(0.01)
while not all(h.get_comm_state() == actionlib.CommState.ACTIVE for h in handles): time.sleep(0.01)
handles[1].cancel()
wait(1)
say("one", seen.get(id(handles[1].comm_state_machine)))
client.cancel_all_goals()
wait(3)
say("all", sorted(seen.values()))
"""
)


@pytest.fixture
def node(any_master: str) -> Iterator[rosproto.Node]:
    with rosproto.Node("/ours", master_uri=any_master, host="127.0.0.1") as node:
        yield node


def handler_for(action: str, told_by: rosproto.Node | None = None):
    """Does what RosServer does; with `told_by`, in step with a client that sets /sent and /fed.

    rospy's simple client loses feedback that arrives before its `send_goal` returns, or after the result, which has
    another connection. A server that takes no time at all shows that.
    """

    def until(name: str, value: int) -> None:
        end = time.monotonic() + 60
        while told_by is not None and told_by.params.get(name, None) != value:
            assert time.monotonic() < end, f"the client never set {name}"
            time.sleep(0.01)

    goal_field, result_field, feedback_field = FIELD[action]

    def handle(goal: ServerGoal) -> None:
        value = getattr(goal.goal, goal_field)
        until("/sent", value)
        if value == 3:
            raise RuntimeError("ours broke")
        goal.publish_feedback({feedback_field: 1})
        while value == 2:
            if goal.wait_for_cancel(10):
                goal.preempted({result_field: 9}, "as you wish")
                return
        until("/fed", 1)
        goal.succeed({result_field: 7}, "well")

    return handle


@pytest.mark.parametrize("action", ACTIONS)
def test_our_client_with_rospys_simple_server(node, any_master, genpy_packages, action):
    goal_field, result_field, feedback_field = FIELD[action]
    with (
        ros.start_rospy(RosServer, any_master, action, *FIELD[action], packages=genpy_packages) as server,
        ActionClient(node, "/act", action) as client,
    ):
        server.wait_for("up")
        client.wait_for_server(60)
        assert client.servers == ["/peer"]
        states = []
        handle = client.send_goal(
            client.type.goal(**{goal_field: 1}), transition=lambda h: states.append(h.state)
        )
        assert getattr(handle.wait(60), result_field) == 7
        assert (handle.status, handle.text) == (GoalStatus.SUCCEEDED, "well")
        assert states[-1] is CommState.DONE
        # rospy's server sends feedback and result at once, on two connections: the result may be first.
        assert [getattr(f, feedback_field) for f in handle.feedback()] in ([], [1])

        handle = client.send_goal(client.type.goal(**{goal_field: 2}))
        assert getattr(next(handle.feedback(60)), feedback_field) == 1
        assert handle.cancel()
        assert getattr(handle.wait(60), result_field) == 9
        assert (handle.status, handle.text) == (GoalStatus.PREEMPTED, "as you wish")

        handle = client.send_goal(client.type.goal(**{goal_field: 3}))
        handle.wait(60)
        assert handle.status is GoalStatus.ABORTED
        assert "rospy broke" in handle.text

        first = client.send_goal(client.type.goal(**{goal_field: 2}))
        next(first.feedback(60))
        second = client.send_goal(client.type.goal(**{goal_field: 1}))
        first.wait(60)
        second.wait(60)
        assert (first.status, second.status) == (GoalStatus.PREEMPTED, GoalStatus.SUCCEEDED)


@pytest.mark.parametrize("action", ACTIONS)
def test_rospys_simple_client_with_our_server(node, any_master, genpy_packages, action):
    with ActionServer(node, "/act", action, handler_for(action, told_by=node)):
        done = ros.run_rospy(SimpleClient, any_master, action, *FIELD[action], packages=genpy_packages)
    lines = done.stdout.splitlines()
    value = "7.0" if "Step" in action else "7"
    zero = "0.0" if "Step" in action else "0"
    assert lines == [
        f"1 {GoalStatus.SUCCEEDED.value} {value} 'well' 1",
        f"3 {GoalStatus.ABORTED.value} {zero} 'RuntimeError: ours broke' 1",
        f"cancelled {GoalStatus.PREEMPTED.value} 'as you wish'",
    ]


def test_rospys_client_with_many_goals_at_our_concurrent_server(node, any_master, genpy_packages):
    action = ACTIONS[0]
    with ActionServer(node, "/act", action, handler_for(action), concurrent=True):
        done = ros.run_rospy(ManyClient, any_master, action, *FIELD[action], packages=genpy_packages)
    assert done.stdout.splitlines() == ["one (2, 'as you wish')", f"all {[(2, 'as you wish')] * 3}"]


def test_a_killed_server_is_noticed_and_its_successor_loses_the_goal(our_master, genpy_packages):
    action = ACTIONS[0]
    arguments = (our_master.uri, action, *FIELD[action])
    with (
        rosproto.Node("/ours", master_uri=our_master.uri, host="127.0.0.1") as node,
        ActionClient(node, "/act", action, status_timeout=1.5) as client,
    ):
        with ros.start_rospy(RosServer, *arguments, packages=genpy_packages) as server:
            client.wait_for_server(60)
            handle = client.send_goal(client.type.goal(goal=2))
            next(handle.feedback(60))
            server.kill()
            began = time.monotonic()
            with pytest.raises(ConnectionLost, match="no status from /peer"):
                handle.wait(60)
            assert time.monotonic() - began < 3.0 * crowd()
            assert not handle.done
        with ros.start_rospy(RosServer, *arguments, packages=genpy_packages):
            client.wait_for_server(60)
            with pytest.raises(ConnectionLost, match="restarted"):
                handle.wait(60)
            assert handle.status is GoalStatus.LOST
            assert client.send_goal(client.type.goal(goal=1)).wait(60).result == 7


def test_the_state_table_is_that_of_the_installed_actionlib(ros_installed):
    code = """
import json
from actionlib import action_client as a
rows = []
for state, row in a._transitions.items():
    for status, to in row.items():
        path = None if to == a.INVALID_TRANSITION else [] if to == a.NO_TRANSITION else to
        rows.append([state, status, list(path) if isinstance(path, (tuple, list)) else None if path is None
        else [path]])
print(json.dumps(rows))
"""
    done = subprocess.run([ros.PYTHON, "-c", code], capture_output=True, text=True, timeout=300, check=True)
    rows = json.loads(done.stdout)
    assert len(rows) == 72
    for state, status, path in rows:
        ours = transition_path(CommState(state), GoalStatus(status))
        assert (None if ours is None else list(ours)) == path, (CommState(state), GoalStatus(status))
