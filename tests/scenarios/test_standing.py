"""That the robot stands is said only of measurements that were sent after the stop.

STANDING_TRIALS=50 in the environment repeats the trials of chance so often.
"""

from __future__ import annotations

import os
import random
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest

from rosproto import Node
from rosproto.node import NodeClient
from tests.support.slow_link import SlowLink
from tests.support.waiting import until
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.feed import feed
from woosh_pure.geometry import Velocity
from woosh_pure.values.messages import message_type

TRIALS = int(os.environ.get("STANDING_TRIALS", "2"))
TURNING = 0.5
"""rad/s"""


@pytest.fixture
def links(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[SlowLink]]:
    """The measured velocity comes through these, without delay at first."""
    with ExitStack() as stack:
        made: dict[int, SlowLink] = {}
        request = NodeClient.request_topic

        def by_a_slow_link(client: NodeClient, topic: str, *given: Any, **options: Any) -> list[object]:
            answer = request(client, topic, *given, **options)
            if topic != "/odom_twist":
                return answer
            port = int(str(answer[2]))
            if port not in made:
                made[port] = stack.enter_context(SlowLink("127.0.0.1", port, latency=0.0, rate=1e6))
                found.append(made[port])
            return [answer[0], "127.0.0.1", made[port].port]

        found: list[SlowLink] = []
        monkeypatch.setattr(NodeClient, "request_topic", by_a_slow_link)
        yield found


@pytest.fixture
def turn(sim: SimulatedChassis) -> Iterator[Callable[[float], None]]:
    """Turn the robot by another program, at that rate until further notice, whatever others send."""
    rate = [0.0]
    with Node("turner", master_uri=sim.master_uri, anonymous=True) as node:
        publisher = node.publisher("/base_cmd_vel", "geometry_msgs/Twist", queue_size=1)
        publisher.wait_for_connection(10.0)

        def send(_: object) -> None:
            message = message_type("geometry_msgs/Twist")()
            message.angular.z = rate[0]
            publisher.publish(message)

        with node.clock.timer(0.01, send):
            yield lambda given: rate.__setitem__(0, given)


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.promise("`chassis.stop()`, from any thread")
def test_a_measurement_from_before_the_stop_does_not_show_that_it_stands(
    sim: SimulatedChassis,
    real_time: Callable[[], None],
    links: list[SlowLink],
    chassis: Chassis,
    turn: Callable[[float], None],
) -> None:
    """It stood, it turns since a few tenths of a second, and what is heard is older than that."""
    chassis.measured_velocity.wait(10.0)
    chance, wrong, told = random.Random(3), [], Counter[bool | None]()
    for trial in range(TRIALS):
        links[0].latency = 0.0
        turn(0.0)
        until(lambda: sim.world.body.velocity.is_standing())
        chassis.measured_velocity.wait_for(Velocity.is_standing, 10.0)
        links[0].latency = chance.uniform(0.5, 0.8)
        time.sleep(1.0)  # the delay holds for what is under way now
        turn(TURNING)
        until(lambda: not sim.world.body.velocity.is_standing(0.1, 0.1))
        began = time.monotonic()
        report = chassis.stop(timeout=chance.choice((0.2, 3.0)))
        told[report.standing] += 1
        if report.standing:
            wrong.append((trial, round(time.monotonic() - began, 2), round(links[0].latency, 2)))
    print(f"told while it turned: {told}; standing: {len(wrong)} of {TRIALS}: {wrong[:5]}")
    assert not wrong


@pytest.mark.promise("`chassis.stop()`, from any thread")
def test_in_a_slow_network_it_is_seen_to_stand_all_the_same(
    real_time: Callable[[], None], links: list[SlowLink], chassis: Chassis
) -> None:
    chassis.measured_velocity.wait(10.0)
    links[0].latency = 0.4
    assert chassis.stop(timeout=10.0).standing is True
    assert chassis.stop(timeout=0.1).standing is None  # too short to hear anything from after the stop


def test_one_measurement_of_zero_is_not_enough(chassis: Chassis, monkeypatch: pytest.MonkeyPatch) -> None:
    """A robot that reverses passes zero."""
    moving, zero = message_type("geometry_msgs/Twist")(), message_type("geometry_msgs/Twist")()
    moving.angular.z = TURNING

    def told(*measured: Any) -> bool | None:
        monkeypatch.setattr(feed, "fresh_messages", lambda *given: (message for message in measured))
        return chassis._components.feeds.wait_standing(2.0)

    chassis.measured_velocity.wait(10.0)
    assert told(moving, zero, moving) is False
    assert told(moving, zero) is None
    assert told() is None
    assert told(moving, zero, zero) is True
