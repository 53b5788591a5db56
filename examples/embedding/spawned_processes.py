"""multiprocessing: each process opens a Chassis of its own; plain values and messages cross between them."""

import multiprocessing

from msgdefs.geometry_msgs.msg import Vector3
from woosh_pure import Chassis, SimulatedChassis


def measure(master_uri: str) -> tuple[float, Vector3]:
    """Runs in another process. Open connections there: sockets and threads do not survive being copied."""
    with Chassis(master_uri) as chassis:
        return chassis.battery.wait(timeout=20).percent, Vector3(x=1.0)


if __name__ == "__main__":
    spawn = multiprocessing.get_context("spawn")  # as on Windows and macOS; a fork copies locks that are held
    with SimulatedChassis(speed=4, full_graph=False) as sim, spawn.Pool(2) as pool:
        for percent, vector in pool.map(measure, [sim.master_uri] * 2):
            print(f"battery {percent} %, {vector.x}")
