"""Read battery, pose and state; every value has an age."""

from _robot import robot

with robot() as chassis:
    battery = chassis.battery.wait(timeout=5)
    print(f"battery {battery.percent} %, {battery.voltage:.1f} V, {battery.charge_status}")
    print(f"pose {chassis.pose.wait(timeout=5)}, {chassis.pose.age:.2f} s old")

    # /robot_status is sent on change only: "not heard yet" is a value, not an error.
    status = chassis.status.latest
    print("state", "not heard yet" if status is None else status.robot_state)

    for name, reading in chassis.snapshot(timeout=2).items():
        print(f"{name:15s}", "silent" if reading is None else f"{reading.age:.2f} s old")
