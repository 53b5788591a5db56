"""The same goals and cancels, with stamps of many clocks, end alike at Debian's simple action servers and at ours.

Where rospy and roscpp differ, ours is as roscpp: move_base is written in C++.
"""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

import rosproto
from msgdefs.actionlib.msg import TestGoal
from msgdefs.actionlib_msgs.msg import GoalID
from rosproto.action import ActionServer, GoalStatus, ServerGoal
from rosproto.master import Master
from rosproto.time import Time
from tests.support import ros

ACTION = "actionlib/TestAction"
SERVERS, STEPS = 24, 14
WAIT = 60.0

ROSPY_SERVERS = """
import sys, time, rospy, actionlib
from actionlib.msg import TestAction
from std_msgs.msg import Int32
rospy.init_node("peer", disable_signals=True)
finished = set()
rospy.Subscriber("/finish", Int32, lambda m: finished.add(m.data), queue_size=1000)
def serve(name):
    def execute(goal):
        if server.is_preempt_requested():
            server.set_preempted(); return
        while goal.goal not in finished:
            if name.startswith("obeys") and server.is_preempt_requested():
                server.set_preempted(); return
            time.sleep(0.005)
        server.set_succeeded()
    server = actionlib.SimpleActionServer(name, TestAction, execute, auto_start=False)
    server.start()
    return server
servers = [serve(name) for name in sys.argv[1:]]
print("up", flush=True)
rospy.spin()
"""


@dataclass(frozen=True)
class Do:
    """One step: send a goal, cancel, or finish what runs."""

    what: str
    id: str = ""
    stamp: float = 0.0


def sequence(number: int, base: float) -> list[Do]:
    """Steps with stamps of this computer's clock, of others, and without; `base` is a time before all of them.

    No goal is sent twice: roscpp forgets one that was cancelled before it came by comparing its stamp with its clock.
    """
    chance = random.Random(number)
    steps: list[Do] = []
    at, goals = base - 500.0, 0
    for _ in range(STEPS):
        at += chance.choice((-2, -1, 0, 1, 2, 3))
        stamp = 0.0 if chance.random() < (0.0, 0.3, 0.7)[number % 3] else at
        what = chance.choice(("goal",) * 5 + ("finish",) * 2 + ("id", "stamp", "all", "both", "early"))
        if what == "goal":
            goals += 1
            # A laptop that is ahead: whatever has an earlier stamp is replaced from then on.
            ahead = chance.random() < 0.05
            steps.append(Do("goal", f"g{goals}", base + 5000.0 if ahead else stamp))
        elif what == "finish":
            steps.append(Do("finish"))
        elif what == "early":
            steps.append(Do("cancel", f"g{goals + 1}", 0.0))
        else:
            some = f"g{chance.randint(1, goals)}" if goals and what in ("id", "both") else ""
            steps.append(Do("cancel", some, at if what in ("stamp", "both") else 0.0))
    return steps


class Client:
    """Carries out the steps of one sequence, each after the server has dealt with the one before."""

    def __init__(self, node: rosproto.Node, name: str, number: int) -> None:
        self.name, self.first = name, 1000 * (number + 1)
        self.changed = threading.Condition()
        self.status: dict[str, GoalStatus] = {}
        self.ended: dict[str, GoalStatus] = {}
        self.barriers = 0
        self.goal = node.publisher(f"{name}/goal", "actionlib/TestActionGoal", queue_size=100)
        self.cancel = node.publisher(f"{name}/cancel", "actionlib_msgs/GoalID", queue_size=100)
        self.finish = node.publisher("/finish", "std_msgs/Int32", queue_size=1000)
        node.subscriber(f"{name}/status", "actionlib_msgs/GoalStatusArray", self._heard, queue_size=100)
        self.results = node.subscriber(
            f"{name}/result", "actionlib/TestActionResult", self._result, queue_size=100
        )

    def connect(self) -> None:
        for publisher in (self.goal, self.cancel, self.finish):
            publisher.wait_for_connection(timeout=WAIT)
        self._until(lambda: self.results.connections > 0, "no connection")

    def _heard(self, message: Any) -> None:
        with self.changed:
            for each in message.status_list:
                self.status[each.goal_id.id] = GoalStatus(each.status)
            self.changed.notify_all()

    def _result(self, message: Any) -> None:
        with self.changed:
            assert message.status.goal_id.id not in self.ended
            self.ended[message.status.goal_id.id] = GoalStatus(message.status.status)
            self.changed.notify_all()

    def _until(self, holds: Callable[[], bool], why: str) -> None:
        end = time.monotonic() + WAIT
        with self.changed:
            while not holds():
                assert time.monotonic() < end, (self.name, why, self.status, self.ended)
                self.changed.wait(0.1)

    def _live(self) -> dict[str, GoalStatus]:
        return {
            goal: status
            for goal, status in self.status.items()
            if goal.startswith("g")
            and goal in self.sent
            and not status.is_terminal
            and goal not in self.ended
        }

    def _settled(self) -> bool:
        live = list(self._live().values())
        running = [s for s in live if s in (GoalStatus.ACTIVE, GoalStatus.PREEMPTING)]
        if "obeys" in self.name:
            return live in ([], [GoalStatus.ACTIVE])
        return not live or len(running) == 1

    def run(self, steps: list[Do]) -> dict[str, GoalStatus]:
        self.sent: set[str] = set()
        for step in steps:
            self._step(step)
        while self._live():
            self._step(Do("finish"))
        return self.ended

    def _step(self, step: Do) -> None:
        if step.what == "goal":
            number = self.first + int(step.id[1:])
            early = self.status.get(step.id)
            self.sent.add(step.id)
            goal_id = GoalID(id=step.id, stamp=Time.from_sec(step.stamp))
            self.goal.publish(goal_id=goal_id, goal=TestGoal(goal=number))
            self._until(
                lambda: step.id in self.ended if early else step.id in self.status, "the goal did not arrive"
            )
        elif step.what == "cancel":
            self.cancel.publish(id=step.id, stamp=Time.from_sec(step.stamp))
        else:
            for goal in [
                g for g, s in self._live().items() if s in (GoalStatus.ACTIVE, GoalStatus.PREEMPTING)
            ]:
                self.finish.publish(data=self.first + int(goal[1:]))
                self._until(lambda goal=goal: goal in self.ended, "it was not finished")  # type: ignore[misc]
                self._until(lambda goal=goal: self.status[goal].is_terminal, "status")  # type: ignore[misc]
        # A cancel of an unknown goal is remembered and listed: what was sent before it has been dealt with.
        self.barriers += 1
        barrier = f"barrier{self.barriers}"
        self.cancel.publish(id=barrier)
        self._until(lambda: barrier in self.status, "the barrier did not arrive")
        self._until(self._settled, f"not settled after {step}")


def names() -> list[str]:
    return [f"{'obeys' if n % 2 else 'holds'}{n}" for n in range(SERVERS)]


def outcomes(uri: str, scripts: dict[str, list[Do]]) -> dict[str, dict[str, GoalStatus]]:
    with rosproto.Node("/driver", master_uri=uri, host="127.0.0.1") as node:
        clients = {name: Client(node, "/" + name, n) for n, name in enumerate(scripts)}
        for client in clients.values():
            client.connect()
        with ThreadPoolExecutor(len(clients)) as pool:
            running = {name: pool.submit(clients[name].run, steps) for name, steps in scripts.items()}
            return {name: future.result() for name, future in running.items()}


def ours(uri: str, scripts: dict[str, list[Do]]) -> dict[str, dict[str, GoalStatus]]:
    with rosproto.Node("/ours", master_uri=uri, host="127.0.0.1") as node, ExitStack() as stack:
        finished: set[int] = set()
        node.subscriber("/finish", "std_msgs/Int32", lambda m: finished.add(m.data), queue_size=1000)

        def handler(name: str) -> Callable[[ServerGoal], None]:
            def handle(goal: ServerGoal) -> None:
                while goal.goal.goal not in finished:
                    if name.startswith("obeys") and goal.cancel_requested:
                        return goal.preempted()
                    time.sleep(0.005)
                return goal.succeed()

            return handle

        for name in scripts:
            stack.enter_context(ActionServer(node, name, ACTION, handler(name)))
        return outcomes(uri, scripts)


def compare(theirs: dict[str, Any], our: dict[str, Any], scripts: dict[str, list[Do]]) -> None:
    for name in scripts:
        assert our[name] == theirs[name], (name, scripts[name])
    ends = {status for ended in our.values() for status in ended.values()}
    assert ends == {GoalStatus.SUCCEEDED, GoalStatus.PREEMPTED, GoalStatus.RECALLED}


@pytest.mark.slow
@pytest.mark.promise("A simple server drops a goal")
def test_goals_and_cancels_end_as_at_rospys_simple_server(our_master: Master, ros_installed: None) -> None:
    base = time.time() - 1.0
    scripts = {name: sequence(n, base) for n, name in enumerate(names())}
    with ros.start_rospy(ROSPY_SERVERS, our_master.uri, *scripts) as server:
        server.wait_for("up")
        theirs = outcomes(our_master.uri, scripts)
    compare(theirs, ours(our_master.uri, scripts), scripts)


@pytest.mark.slow
@pytest.mark.promise("A simple server drops a goal")
def test_goals_and_cancels_end_as_at_roscpps_simple_server(roscpp_peer: Path, our_master: Master) -> None:
    """Also after a cancel with a stamp ahead of the server's clock, which rospy's applies to goals without a stamp."""
    base = time.time() - 1.0
    scripts = {name: sequence(100 + n, base) for n, name in enumerate(names())}
    for name in names()[::4]:
        scripts[name].insert(STEPS // 2, Do("cancel", "", base + 5000.0))
    with ros.start_program(roscpp_peer, our_master.uri, "action_holders", *scripts) as server:
        server.wait_for("up")
        theirs = outcomes(our_master.uri, scripts)
    compare(theirs, ours(our_master.uri, scripts), scripts)
