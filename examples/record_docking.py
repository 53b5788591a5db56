"""Write down battery and pose while the robot drives to its charger."""

import csv
import time

from _robot import robot

with robot() as chassis, open("docking.csv", "w", newline="", encoding="utf-8") as file:
    table = csv.writer(file)
    table.writerow(["time", "percent", "volt", "ampere", "x", "y", "yaw"])
    handle = chassis.charge("C1")
    while not handle.done:
        battery, pose = chassis.battery.wait(timeout=5), chassis.pose.wait(timeout=5)
        table.writerow(
            [time.time(), battery.percent, battery.voltage, battery.current, pose.x, pose.y, pose.yaw]
        )
    print(handle.wait(timeout=120))
    chassis.battery.wait_for(lambda b: b.charging, timeout=10)
    print("charging; all topics at once, as a bag: woosh record")
