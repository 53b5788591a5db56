"""Stop from any thread, at any time. This is not an emergency stop: keep the red button within reach."""

import threading

from _robot import robot

with robot(speed=1.0) as chassis:
    handle = chassis.go_to(2.5, 0.0)
    threading.Timer(0.5, lambda: print(chassis.stop().sentence())).start()
    outcome = handle.wait(timeout=30, raises=False)
    print(outcome.sentence())
    assert not outcome.arrived
