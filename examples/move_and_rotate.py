"""Precise moves: straight, turning, and several as one goal."""

import math

from _robot import robot

from woosh_pure.motion import Step

with robot() as chassis:
    print(chassis.move(0.5).wait().sentence())
    print(chassis.rotate(90, degrees=True, speed=0.5).wait().sentence())

    square = [Step.straight(0.4), Step.turn(math.pi / 2, speed=0.8)] * 4
    handle = chassis.steps(square)
    for report in handle.reports():
        step = len(square) - len(handle.remaining()) + 1
        print(f"  step {step} of {len(square)}: {report.percent:.0f} %; all: {handle.progress.sentence()}")
    print(handle.wait().sentence())
