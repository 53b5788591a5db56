"""The Windows side of test_interop.py: one program per round, run by `tests/windows/run python`.

It prints what it saw, one fact per line; the test on Linux reads that.
"""

from __future__ import annotations

import sys
import threading

import rosproto
from msgdefs.actionlib.msg import TestAction, TestFeedback, TestGoal, TestResult
from msgdefs.sensor_msgs.msg import PointCloud2
from msgdefs.std_msgs.msg import Empty, String
from msgdefs.std_srvs.srv import SetBool
from woosh_pure import Chassis


def say(*words: object) -> None:
    """A fact for the test; ASCII, because a pipe's encoding is the machine's."""
    print(*map(ascii, words), flush=True)


def leftovers() -> list[str]:
    """Our threads that still run."""
    return [thread.name for thread in threading.enumerate() if thread.name.startswith("rosproto:")]


def act(goal: rosproto.action.ServerGoal) -> None:
    """The action server's handler: one feedback, then twice the number."""
    goal.publish_feedback(TestFeedback(feedback=1))
    goal.succeed(TestResult(result=goal.goal.goal * 2), "done on Windows")


def graph(master_uri: str) -> None:
    """Publisher, subscriber, service client and server, action client and server beside a rospy node."""
    asked_to_quit = threading.Event()
    with rosproto.Node("/windows", master_uri=master_uri, host="127.0.0.1") as node:
        node.service_server("/win/set", SetBool, lambda request: (request.data, f"windows {request.data}"))
        node.publisher("/win/latched", String, latch=True).publish(data="from Windows: 货架")
        node.subscriber("/win/quit", Empty, callback=lambda _: asked_to_quit.set())
        words, clouds = node.subscriber("/ros/words", String), node.subscriber("/ros/cloud", PointCloud2)
        with rosproto.ActionServer(node, "/win/act", TestAction, act):
            say("up")
            say("heard", words.next(timeout=60).data)
            cloud = clouds.next(timeout=60)
            say("cloud", len(cloud.data), int(cloud.data.sum()))
            with node.service_client("/ros/set", SetBool) as client:
                say("answered", client.call(data=True, timeout=20).message)
            with rosproto.ActionClient(node, "/ros/act", TestAction) as actions:
                actions.wait_for_server(timeout=30)
                goal = actions.send_goal(TestGoal(goal=21))
                say("result", goal.wait(timeout=30).result, goal.text)
            say("quit", asked_to_quit.wait(60))
    say("leftovers", leftovers())


def chassis(master_uri: str) -> None:
    """A Chassis on Windows, the simulator on Linux."""
    with Chassis(master_uri) as robot:
        say("battery", robot.battery.wait(timeout=20).percent)
        robot.move(0.3).wait(timeout=40)
        say("moved")
        with robot.velocity(bypasses_protection=True, max_linear=0.3) as drive:
            drive.hold(0.1, seconds=0.5)
        say("driven")
        robot.go_to_mark("A1").wait(timeout=60)
        pose = robot.pose.wait(timeout=20)
        say("arrived", round(pose.x), round(pose.y))
    say("leftovers", leftovers())


if __name__ == "__main__":
    {"graph": graph, "chassis": chassis}[sys.argv[1]](sys.argv[2])
