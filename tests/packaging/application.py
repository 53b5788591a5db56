"""A small application that integrators would ship as one file; check.py freezes it."""

import rosproto
from msgdefs.std_msgs.msg import Float32
from woosh_pure import Chassis, SimulatedChassis

with SimulatedChassis(speed=8, full_graph=False) as sim, Chassis(sim.master_uri) as chassis:
    print(f"battery {chassis.battery.wait(timeout=20).percent} %")
    chassis.move(0.2).wait(timeout=30)
    print("moved 0.2 m")
    with rosproto.Node("/extra", master_uri=sim.master_uri) as node:
        node.publisher("/extra/number", Float32).publish(data=1.5)
