"""Task 6: a patrol that drives around an obstacle, leaves out a mark that it cannot reach, and reports."""

import time

from woosh_pure import Chassis, GoalFailed, MotionRefused

ROUND = ["A1", "B1", "B2", "P1"]
ROUNDS = 2

with Chassis() as chassis:
    report = []
    for number in range(1, ROUNDS + 1):
        for mark in ROUND:
            began = time.monotonic()
            try:
                chassis.go_to_mark(mark).wait(timeout=120)
                result = "reached"
            except (MotionRefused, GoalFailed) as reason:
                result = f"left out: {reason}"
                chassis.wait_until_ready(timeout=60)
            line = f"round {number}, {mark}: {result} ({time.monotonic() - began:.0f} s)"
            print(line)
            report.append(line)
    print(f"{sum(': reached' in line for line in report)} of {len(report)} marks were reached")
