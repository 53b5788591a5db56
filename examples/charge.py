"""Charge, and wait until the battery says so."""

from _robot import robot

from woosh_pure.enums import RobotState

with robot() as chassis:
    print(chassis.charge("C1").wait(timeout=120).sentence())
    chassis.wait_until(lambda status: status.robot_state is RobotState.CHARGING, timeout=10)
    battery = chassis.battery.wait_for(lambda b: b.charging, timeout=10)
    print(f"charging at {battery.current:.1f} A")
