"""The order machine over the simulated world, both pure: nodes passed at speed, in a hall with pillars."""

from __future__ import annotations

import random

import pytest

from tests.support.fleet import LIMITS, action, instant, order_json
from woosh_pure.fleet.messages.parsing import read_instant_actions, read_order
from woosh_pure.fleet.order.events import (
    Drive,
    DriveEnded,
    Event,
    Halt,
    ModeChanged,
    PositionMeasured,
    ScheduleRetry,
    StandingMeasured,
)
from woosh_pure.fleet.order.machine import step
from woosh_pure.fleet.order.state import first_state
from woosh_pure.fleet.order.vehicle_limits import AgvPosition
from woosh_pure.geometry import Pose2D
from woosh_pure.sim.motions import Motion, MotionState
from woosh_pure.sim.settings import Settings
from woosh_pure.sim.world import World

DT = 0.05


class Tour:
    """A machine whose drives are goals of the simulated navigation, replaced as `DriveRunner` replaces them."""

    def __init__(self, seed: int) -> None:
        self.world = World(settings=Settings(seed=seed))
        self.state = first_state(LIMITS)
        self.drive: Drive | None = None
        self.motion: Motion | None = None
        self.retries = 0
        self.apply(ModeChanged("AUTOMATIC"))

    def apply(self, event: Event) -> None:
        self.state, effects = step(self.state, event)
        for effect in (*effects.stops, *effects.begins):
            if isinstance(effect, Drive):
                position = effect.node.position
                assert position is not None
                self.drive = effect
                self.motion = self.world.navigate("move_base", [Pose2D(position.x, position.y)])
            elif isinstance(effect, Halt):
                assert self.motion is not None
                self.world.end_motion(self.motion, MotionState.CANCELLED)
            elif isinstance(effect, ScheduleRetry):
                self.retries += 1

    def step(self) -> None:
        self.world.step(DT)
        pose = self.world.believed_pose
        self.apply(PositionMeasured(AgvPosition(pose.x, pose.y, pose.yaw)))
        standing = self.world.body.velocity.is_standing(0.01, 0.1)
        if self.drive is not None and self.motion is not None and self.motion.state.is_final and standing:
            token, arrived = self.drive.token, self.motion.state is MotionState.DONE
            self.drive = self.motion = None
            self.apply(DriveEnded(token, arrived))
            self.apply(StandingMeasured(True))


@pytest.mark.parametrize("seed", [6, 8])
def test_nodes_passed_at_speed_and_cancels_beside_pillars_end_at_no_bumper(seed: int) -> None:
    """Orders over random places, each passed within up to a metre; some are cancelled on the way."""
    chance = random.Random(seed)
    tour = Tour(seed)
    tour.step()
    for n in range(2):
        names = "abcdef"
        order = order_json(f"o{n}", nodes=names)
        here = tour.world.body.pose
        for node in order["nodes"]:
            place = (here.x, here.y)
            while node["nodeId"] != "a":
                place = (chance.uniform(-1.1, 9.1), chance.uniform(-3.1, 3.1))
                if tour.world.planner.is_free(*place):
                    break
            node["nodePosition"].update(x=place[0], y=place[1], allowedDeviationXY=chance.uniform(0.3, 1.0))
        tour.apply(read_order(order))
        stops_at = chance.uniform(5.0, 60.0) if n == 1 else 300.0
        began = tour.world.time
        while tour.state.executing:
            tour.step()
            assert not tour.world.bumper, (tour.world.time, tour.world.body.pose)
            if tour.world.time - began > stops_at:
                stops_at = 1000.0
                tour.apply(read_instant_actions(instant(action(f"c{n}", "cancelOrder"))))
            assert tour.world.time - began < 400.0, "it never ends"
        assert tour.state.last_sequence == 10 or n == 1, [each.description for each in tour.state.problems]
    assert tour.retries == 0
