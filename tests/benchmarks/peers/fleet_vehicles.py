"""Vehicles of ours for `tests.benchmarks fleet`, in a process of their own: N, "light" or "real", the broker's URL.

One thread moves all stand-ins (`tests/support/light_chassis.py`). With "real" each is a whole `Chassis` on a simulated one in another process. What
happens when is said at the end of the run, by the clock that all processes have in common.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

SIMULATORS = """
import sys
from contextlib import ExitStack
from woosh_pure import SimulatedChassis
with ExitStack() as stack:
    for _ in range(int(sys.argv[1])):
        print(stack.enter_context(SimulatedChassis(speed=1.0)).master_uri, flush=True)
    sys.stdin.read()
"""


def main(size: str, kind: str, url: str) -> None:
    from tests.support.light_chassis import LightChassis, moving
    from woosh_pure import Chassis
    from woosh_pure.fleet import Broker, Store, Vehicle, VehicleConfig

    log: list[dict[str, Any]] = []
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        chassis: list[Any]
        if kind == "real":
            command = [sys.executable, "-c", SIMULATORS, size]
            robots = stack.enter_context(
                subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
            )
            assert robots.stdin is not None
            assert robots.stdout is not None
            stack.callback(robots.stdin.close)
            uris = [robots.stdout.readline().strip() for _ in range(int(size))]
            chassis = []
        else:
            uris = []
            chassis = [LightChassis(float(number)) for number in range(int(size))]
            stack.enter_context(moving(chassis))
        __import__("paho.mqtt.client")  # all is loaded before memory is counted
        print("standing", flush=True)
        sys.stdin.readline()
        chassis += [stack.enter_context(Chassis(uri)) for uri in uris]
        for number, each in enumerate(chassis):
            serial = f"v{number}"
            config = VehicleConfig(manufacturer="Woosh", serial=serial, map_id="hall")
            vehicle = Vehicle(each, config, Broker(url), Store(folder, "Woosh", serial))
            watch(vehicle, each, serial, log, real=kind == "real")
            stack.enter_context(vehicle)
        print("open", flush=True)
        for line in sys.stdin:
            if line.strip() == "log":
                for entry in log:
                    print(json.dumps(entry))
                log.clear()
                print("logged", flush=True)


def watch(vehicle: Any, chassis: Any, serial: str, log: list[dict[str, Any]], *, real: bool) -> None:
    """Note when an order sets the robot moving, and when it has arrived at the last node."""
    order, seen = vehicle._order, {""}

    def note(event: str) -> None:
        log.append({"event": event, "serial": serial, "order": order.state.order_id, "at": time.monotonic()})

    def moves() -> None:
        if order.state.order_id not in seen:
            seen.add(order.state.order_id)
            note("motion")

    if real:
        chassis.measured_velocity.on(
            lambda v: moves() if abs(v.vx) + abs(v.wz) > 0.01 and order.state.driving else None, connect=False
        )
    else:
        go_to = chassis.go_to

        def begin(*given: Any, **options: Any) -> Any:
            moves()
            return go_to(*given, **options)

        chassis.go_to = begin
    tell = vehicle._driver._tell

    def over(end: Any) -> None:
        if getattr(end, "arrived", False) and len(order.state.nodes) == 1:
            note("arrival")
        tell(end)

    vehicle._driver._tell = over


if __name__ == "__main__":
    sys.path.append(os.environ["FLEET_BENCHMARK"])  # what another checkout does not have of the tests
    main(*sys.argv[1:])
