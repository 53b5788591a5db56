"""Faults of a robot, simulated: what does your program do then?"""

from woosh_pure import Chassis, GoalFailed, MotionRefused, SimulatedChassis

with SimulatedChassis(speed=4) as sim, Chassis(sim.master_uri) as chassis:
    chassis.faults  # noqa: B018  (begin to listen: faults are told once, when they happen)
    handle = chassis.go_to_mark("B1")
    sim.press_emergency_stop()
    try:
        handle.wait(timeout=30)
    except GoalFailed as failed:
        print("failed:", failed)
    try:
        chassis.go_to_mark("A1")
    except MotionRefused as refused:
        print("refused:", refused)
    sim.release_emergency_stop()
    chassis.wait_until_ready(timeout=10)
    sim.add_obstacle(1.5, 0.0)
    print(chassis.go_to(2.8, 0.0).wait(timeout=60).sentence())
