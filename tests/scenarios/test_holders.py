"""Nothing that moves is left without a holder: what begins while a Chassis is closed, and nodes that are shut down."""

from __future__ import annotations

import contextlib
import os
import random
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

import rosproto
from rosproto.errors import ConnectionLost, RosError
from rosproto.node import NodeClient
from tests.support.doors import held, in_thread
from tests.support.load import crowd
from woosh_pure import Chassis, GoalFailed, MotionRefused, OutcomeKind, SimulatedChassis, Velocity
from woosh_pure.connection.connection import FinalMessage, say_elsewhere
from woosh_pure.values.messages import twist

ROOT = Path(__file__).resolve().parents[2]


def stands(sim: SimulatedChassis) -> bool:
    return sim.world.motion is None and sim.world.body.velocity.is_standing(0.0, 0.0)


# -- closing ---------------------------------------------------------------------------------------------------


@pytest.mark.promise("the `Chassis` block is left, or the program ends in an orderly way")
@pytest.mark.parametrize("verb", ["goal", "task", "velocity"])
def test_nothing_begins_while_a_chassis_is_being_closed(sim, until, monkeypatch, verb):
    """A worker that tries again and again, as workers do; ending what moves takes its time."""
    chassis = Chassis(sim.master_uri)
    chassis.go_to(2.5, 0.0)
    until(lambda: not stands(sim))
    with held(monkeypatch, Chassis, "_end") as (came, go_on):
        closing, problems = in_thread(chassis.close)
        assert came.wait(10.0)
        with pytest.raises(ConnectionLost, match="this Chassis is closed"):
            begin(chassis, verb)
        go_on.set()
        closing.join(20.0)
    assert problems == []
    until(lambda: stands(sim))
    assert not sim.world.tasks.busy


def begin(chassis: Chassis, verb: str) -> Any:
    if verb == "goal":
        return chassis.go_to(2.5, 0.5, check=False)
    if verb == "task":
        return chassis.go_to_mark("B1", check=False)
    return chassis.velocity(bypasses_protection=True, check=False).__enter__()


@pytest.mark.parametrize("verb", ["goal", "task", "velocity"])
def test_what_was_prepared_when_a_chassis_was_closed_does_not_begin(sim, until, monkeypatch, verb):
    """It has passed the first door, and comes to the second one too late."""
    chassis = Chassis(sim.master_uri)
    chassis.readiness()
    running = chassis._components.motions
    door = "add_drive" if verb == "velocity" else "add_goal"
    with held(monkeypatch, type(running), door) as (came, go_on):
        worker, errors = in_thread(lambda: begin(chassis, verb))
        assert came.wait(10.0)
        running.note_end("this Chassis is closed")
        go_on.set()
        worker.join(10.0)
    chassis.close()
    assert isinstance(errors[0], ConnectionLost)
    assert stands(sim)


def test_a_worker_that_retries_is_ended_with_its_chassis(sim, until):
    for _ in range(3):
        chassis = Chassis(sim.master_uri)
        over = threading.Event()

        def work(chassis: Chassis = chassis, over: threading.Event = over) -> None:
            while not over.is_set():
                try:
                    chassis.go_to(2.5, 0.0).wait()
                except GoalFailed:
                    continue
                except RosError:
                    over.wait(0.01)

        worker, errors = in_thread(work)
        until(lambda: not stands(sim))
        chassis.close()
        until(lambda: stands(sim))
        over.set()
        worker.join(20.0)
        assert errors == []
        assert stands(sim)


def test_what_did_not_end_at_first_is_ended_once_more_before_the_node_goes(sim, until, monkeypatch):
    chassis = Chassis(sim.master_uri)
    handle = chassis.go_to(2.5, 0.0)
    until(lambda: not stands(sim))
    asked = []
    original = type(handle._motion).request_cancel

    def lost_at_first(self: Any, timeout: float) -> None:
        asked.append(timeout)
        if len(asked) == 1:
            raise ConnectionLost("the network is away")
        original(self, timeout)

    def lost(self: Any) -> None:
        raise ConnectionLost("the network is away")

    monkeypatch.setattr(type(handle._motion), "request_cancel", lost_at_first)
    monkeypatch.setattr(type(handle._motion), "write_cancel", lost)
    chassis.close()
    assert len(asked) == 2
    until(lambda: stands(sim))


# -- nodes that are shut down ----------------------------------------------------------------------------------


def by_a_peer(node: rosproto.Node) -> None:
    with NodeClient(node.uri, "/rosnode") as client:
        client.shutdown("user request")


def by_the_master(node: rosproto.Node) -> None:
    """Another node takes the name, and has it until the older one has obeyed.

    If it left before the master's call arrives, our node would be registered again, and refuse the call.
    """
    with rosproto.Node(node.name, master_uri=node.master_uri):
        node.wait(20.0)


@pytest.mark.promise(
    "a new node sends zero again",
    "sends zero and cancels its goals before it obeys",
    "`rosnode kill` of our node",
)
@pytest.mark.parametrize("topic", ["smooth", "direct"])
@pytest.mark.parametrize(
    ("shut_down", "error", "says"),
    [
        (by_a_peer, MotionRefused, r"shut down.*user request"),
        # This master also tells the robot that the publisher is gone: that may be heard first.
        (by_the_master, (MotionRefused, ConnectionLost), r"shut down.*same name|no longer has a subscriber"),
    ],
    ids=["by a peer", "by the master"],
)
def test_zero_is_sent_before_the_driving_node_is_shut_down(sim, until, shut_down, error, says, topic):
    with Chassis(sim.master_uri) as chassis:
        block = chassis.velocity(bypasses_protection=True, direct=topic == "direct")
        with pytest.raises(error, match=says), block as drive:  # noqa: PT012
            drive.set(0.05, valid_for=5.0)
            until(lambda: not sim.world.body.velocity.is_standing())
            shut_down(chassis.node)
            drive.hold(0.05, seconds=20.0)
        assert chassis.node.wait(20.0)
        until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0), 1.0 * crowd())
        with pytest.raises(ConnectionLost, match=r"shut down \(shutdown by /"):
            chassis.move(0.1)


@pytest.mark.promise("a new node sends zero again")
def test_another_node_says_zero_at_once_and_again_when_our_own_is_over(sim, chassis, until):
    """The robot may read the last velocity of our own link after the zeros of the other node."""
    connection = chassis._components.connection
    words = [FinalMessage("/base_cmd_vel", twist(Velocity()), 3)]
    own_over = threading.Event()

    def moves() -> bool:
        return not sim.world.body.velocity.is_standing()

    with chassis.node.publisher("/base_cmd_vel", "geometry_msgs/Twist", latch=True) as own:
        own.publish(twist(Velocity(0.2)))
        until(moves)
        saying, errors = in_thread(lambda: say_elsewhere(connection, words, own_over))
        until(lambda: not moves(), what="the zero at once")
        own.publish(twist(Velocity(0.2)))
        until(moves)
        own_over.set()
        until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0), what="the zero again")
        saying.join(20.0)
    assert not errors


@pytest.mark.promise("sends zero and cancels its goals before it obeys", "`rosnode kill` of our node")
@pytest.mark.parametrize("verb", ["goal", "task"])
def test_goals_are_cancelled_before_their_node_is_shut_down(sim, real_time, until, verb):
    with Chassis(sim.master_uri) as chassis:
        handle = begin(chassis, verb)
        until(lambda: not stands(sim))
        by_a_peer(chassis.node)
        with pytest.raises(GoalFailed, match=r"shut down.*user request") as caught:
            handle.wait(20.0)
        assert caught.value.outcome.kind is OutcomeKind.CANCELLED
        until(lambda: stands(sim) and not sim.world.tasks.busy)


@pytest.mark.promise("`rosnode kill` of our node")
@pytest.mark.parametrize("verb", ["goal", "steps", "task"])
def test_goals_are_cancelled_when_another_node_takes_our_name(sim, real_time, until, verb):
    """The action server has dropped the links to us by then: a fresh node cancels, as it sends zeros.

    Whether the goal has ended our own node may not hear any more; then `close` says that it does not know.
    """
    chassis = Chassis(sim.master_uri)
    chassis.move(2.0) if verb == "steps" else begin(chassis, verb)
    until(lambda: not stands(sim))
    by_the_master(chassis.node)
    until(lambda: stands(sim) and not sim.world.tasks.busy, 2.0 * crowd(), "standing")
    with contextlib.suppress(ConnectionLost):
        chassis.close()


@pytest.mark.promise("`rosnode kill` of our node")
def test_a_cancel_that_is_lost_with_its_link_is_said_by_another_node_meanwhile(
    sim, real_time, until, monkeypatch
):
    """It seems sent, and is lost: the robot must not drive on for the 3 s in which a reply may come."""
    with Chassis(sim.master_uri) as chassis:
        chassis.move(2.0)
        until(lambda: not stands(sim))
        (motion,) = chassis._components.motions.goals
        monkeypatch.setattr(motion, "write_cancel", lambda: None)
        monkeypatch.setattr(motion, "request_cancel", lambda timeout: None)
        obeying, errors = in_thread(lambda: by_a_peer(chassis.node))
        until(lambda: stands(sim))
        obeying.join(20.0)
        assert not errors
        assert sim.pose.x < 1.2  # without the other node 1.6 m, since the reply is waited for first


def test_leave_running_leaves_a_goal_when_the_node_is_shut_down_and_no_velocity(sim, real_time, until):
    with Chassis(sim.master_uri, leave_running=True) as chassis:
        chassis.go_to_mark("B1")
        until(lambda: not stands(sim))
        by_a_peer(chassis.node)
        assert chassis.node.wait(20.0)
        assert sim.world.tasks.busy


# -- who ended it ----------------------------------------------------------------------------------------------


def test_an_outcome_says_that_it_was_this_program_and_why(sim, real_time, chassis):
    assert "this program ended it: cancel() was called" in chassis.go_to(2.5, 0.0).cancel().sentence()
    task = chassis.go_to_mark("B1")
    chassis.stop()
    assert task.outcome.by_us == "stop() was called"
    assert "did not cancel it" not in task.outcome.sentence()


def test_an_outcome_says_that_it_was_somebody_else(sim, real_time, chassis, until):
    task = chassis.go_to_mark("B1")
    with Chassis(sim.master_uri, name="other") as other:
        assert other.stop(everything=True).standing
    outcome = task.wait(20.0, raises=False)
    assert outcome.by_us == ""
    assert "this program did not cancel it" in outcome.sentence()


# -- a storm of interrupts -------------------------------------------------------------------------------------


@pytest.mark.promise("Ctrl-C again and again")
@pytest.mark.skipif(os.name == "nt", reason="sends POSIX signals to a process, and forks")
@pytest.mark.slow
def test_a_storm_of_interrupts_abandons_nothing():
    """Every verb and every command once; `python -m tests.storm --trials 1000` is the long one."""
    seed, jobs = random.randrange(2**32), 3
    done = subprocess.run(
        [sys.executable, "-m", "tests.storm", "--all", "--jobs", str(jobs), "--seed", str(seed)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=600.0,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("in 0 the robot went on") == jobs
