"""Three ways to hear a topic: wait, iterate, be called back."""

from itertools import islice

from _robot import robot

from woosh_pure.faults import StatusCode

with robot() as chassis:
    codes: list[StatusCode] = []
    chassis.status_code.on(codes.append)  # called in the receiving thread: keep it short
    handle = chassis.go_to(1.0, 0.5)
    for velocity in islice(chassis.measured_velocity, 5):
        print(f"{velocity.vx:.2f} m/s, {velocity.wz:.2f} rad/s")
    handle.wait(timeout=60)
    print("heard:", *(code.english for code in codes), sep="\n  ")
    print("the last", len(chassis.odometry.history), "odometry values are kept from now on")
