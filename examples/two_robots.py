"""Two robots in one program; each Chassis has a node of its own."""

from woosh_pure import Chassis, SimulatedChassis

with (
    SimulatedChassis(speed=6) as one,
    SimulatedChassis(speed=6) as two,
    Chassis(one.master_uri) as first,
    Chassis(two.master_uri) as second,
):
    handles = [first.go_to_mark("A1"), second.go_to_mark("B2")]
    for handle in handles:
        print(handle.wait(timeout=60).sentence())
