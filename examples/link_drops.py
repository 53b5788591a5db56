"""The cable is pulled for a moment, in the middle of a drive and of a goal: what does your program see?"""

from rosproto import ConnectionLost
from woosh_pure import Chassis, SimulatedChassis

with SimulatedChassis(speed=2) as sim, Chassis(sim.master_uri) as chassis:
    try:
        with chassis.velocity(bypasses_protection=True, feedback_timeout=0.5) as drive:
            drive.hold(0.1, seconds=0.5)
            sim.drop_link(1.0)
            drive.hold(0.1, seconds=20.0)
    except ConnectionLost as lost:
        print(lost)
    chassis.measured_velocity.wait_for(lambda v: v.is_standing(), timeout=10)
    print("zero was the last thing that arrived: it stands")

    handle = chassis.go_to_mark("P1")  # a goal goes on without the link, and its end is heard afterwards
    sim.drop_link(1.0)
    print(handle.wait(timeout=60).sentence())
