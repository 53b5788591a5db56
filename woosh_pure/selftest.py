"""What `woosh selftest` checks: rosproto's own checks, the table of the chassis, and a simulated drive."""

from __future__ import annotations

import math
import time

from rosproto.selftest import CHECKS as ROS_CHECKS
from rosproto.selftest import Check, CheckFailed
from rosproto.sentence import say
from woosh_pure import interface
from woosh_pure.chassis import Chassis
from woosh_pure.faults import all_codes
from woosh_pure.sim import SimulatedChassis
from woosh_pure.values.messages import message_type
from woosh_pure.velocity.drive import Drive

__all__ = ["CHECKS", "check_drive", "check_table"]

_SPEED = 8.0  # simulated seconds per second
_PATIENCE = 15.0  # seconds for each part of the drive; on a quiet machine the longest takes one


def check_table() -> str:
    """The rows of the chassis's interface have definitions, and the status codes have words."""
    rows = [row for row in interface.topics() if row.definition_known]
    for row in rows:
        message_type(row.type)()
    codes = list(all_codes())
    wordless = [code.code for code in codes if not (code.english and code.chinese)]
    if wordless:
        wrong = "{count} status codes have no words; the first is {first}"
        raise CheckFailed(say(wrong, count=len(wordless), first=wordless[0]))
    return say(
        "{rows} topics of the chassis have their definitions, {codes} status codes their words",
        rows=len(rows),
        codes=len(codes),
    )


def check_drive() -> str:
    """A simulated chassis: a step, a velocity that lapses, a task to a mark, and the stop."""
    with SimulatedChassis(speed=_SPEED, full_graph=False) as sim, Chassis(sim.master_uri) as chassis:
        began = sim.pose
        chassis.move(0.5).wait(timeout=_PATIENCE)
        _near("a step of 0.5 m", began.distance_to(sim.pose), 0.5, 0.05)
        with chassis.velocity(bypasses_protection=True, feedback_timeout=5.0) as drive:
            _turn_until_measured(chassis, drive)
        chassis.measured_velocity.wait_for(lambda v: v.is_standing(), _PATIENCE)
        mark = sim.world.site.marks["A1"].pose
        chassis.go_to_mark("A1").wait(timeout=_PATIENCE)
        off = sim.pose.distance_to(mark)
        _near("the distance from the mark", off, 0.0, 0.1)
        report = chassis.stop(everything=True, timeout=_PATIENCE)
        if report.standing is not True:
            raise CheckFailed(str(report))
    return say(
        "a step, a velocity and a task on a simulated chassis; it ended {off:.0f} mm from its mark",
        off=off * 1000,
    )


def _turn_until_measured(chassis: Chassis, drive: Drive) -> None:
    """Send a velocity again and again, as programs do: one may lapse before a busy machine measures it."""
    end = time.monotonic() + _PATIENCE
    while time.monotonic() < end:
        drive.set(0.0, 0.3, valid_for=0.3)
        measured = chassis.measured_velocity.latest
        if measured is not None and measured.wz > 0.1:
            return
        time.sleep(0.05)
    raise CheckFailed(say("the robot did not turn within {seconds:g} s", seconds=_PATIENCE))


def _near(what: str, found: float, wanted: float, tolerance: float) -> None:
    if not math.isclose(found, wanted, abs_tol=tolerance):
        wrong = "{what}: measured {found:.3f} m, expected {wanted:g} m"
        raise CheckFailed(say(wrong, what=what, found=found, wanted=wanted))


CHECKS = (
    *(check for check in ROS_CHECKS if check.name != "ros"),
    Check("chassis", check_table),
    Check("drive", check_drive),
    *(check for check in ROS_CHECKS if check.name == "ros"),
)
"""The comparison with a real ROS is last: it takes the longest, and most machines have none."""
