"""Visit marks in turn, and decide for each way it can go wrong."""

from _robot import robot

import rosproto
from woosh_pure import Chassis, GoalFailed, MotionRefused, OutcomeKind

MARKS = ("A1", "no such mark", "B1", "P1")


def visit(chassis: Chassis, mark: str) -> bool:
    """True when the robot stands at the mark; a second try for what may have been an accident."""
    for _ in range(2):
        try:
            print(chassis.go_to_mark(mark).wait(timeout=120))
            return True
        except MotionRefused as refused:  # nothing moves; the text says why
            print("refused:", refused)
            if refused.readiness is None or not refused.readiness.blocked:
                return False  # nothing keeps it from moving, but not there: a wrong name
            chassis.wait_until_ready(timeout=60)  # a person releases the button, turns the key ...
        except GoalFailed as failed:  # it began, and did not arrive
            print("failed:", failed)
            if failed.outcome.kind in (OutcomeKind.REPLACED, OutcomeKind.CANCELLED):
                return False  # somebody else wants something else
    return False


with robot() as chassis:
    try:
        reached = [mark for mark in MARKS if visit(chassis, mark)]
        print("reached:", ", ".join(reached))
    except rosproto.RosError as error:  # the network, or a node of the chassis
        print("given up:", error)
