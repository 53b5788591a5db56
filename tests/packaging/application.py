"""A small application that integrators would ship as one file; check.py freezes it."""

import tempfile
from pathlib import Path

import rosproto
from msgdefs.actionlib.msg import TestAction, TestGoal, TestResult
from msgdefs.std_msgs.msg import Float32
from msgdefs.woosh_msgs.msg import RobotStatus
from woosh_pure import Chassis, SimulatedChassis

with SimulatedChassis(speed=8, full_graph=False) as sim, Chassis(sim.master_uri) as chassis:
    print(f"battery {chassis.battery.wait(timeout=20).percent} %")
    chassis.move(0.2).wait(timeout=30)
    print("moved 0.2 m")
    with rosproto.Node("/extra", master_uri=sim.master_uri) as node:
        node.publisher("/extra/number", Float32).publish(data=1.5)
        rosproto.ActionServer(node, "/act", TestAction, lambda goal: TestResult(goal.goal.goal))
        client = rosproto.ActionClient(node, "/act", TestAction)
        client.wait_for_server(timeout=20)
        print("action:", client.send_goal(TestGoal(7)).wait(timeout=20).result)

with tempfile.TemporaryDirectory() as folder:
    for compression in ("none", "bz2", "lz4"):
        path = Path(folder, f"{compression}.bag")
        with rosproto.BagWriter(path, compression=compression) as bag:
            bag.write("/robot_status", RobotStatus(task_id=5, dest="dock"), 1.5)
        with rosproto.BagReader(path) as bag:
            ((topic, message, _),) = bag.read_messages()
        print(compression, topic, message.task_id, message.dest)
