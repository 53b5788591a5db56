"""Task 1: two metres forward, and back to where it began. `woosh run --sim --watch task1_first_move.py`."""

from woosh_pure import Chassis

with Chassis() as chassis:
    print("battery:", chassis.battery.wait(timeout=5).percent, "%")
    chassis.forward(2).wait()
    chassis.forward(-2).wait()  # a negative number drives backwards
    print("back again; battery:", chassis.battery.wait(timeout=5).percent, "%")
