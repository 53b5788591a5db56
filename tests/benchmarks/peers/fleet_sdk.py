"""Vehicles of vda5050-sdk for `tests.benchmarks fleet`: all in one event loop; N and the broker's URL."""

import asyncio
import json
import sys
import time

from vda5050 import VehicleClient, VehicleConfig
from vda5050.client.agv.executor import OrderExecutor
from vda5050.model.enums import OperatingMode


class Executor(OrderExecutor):
    """The reference executor; a node takes a second, as it does at 1 m/s."""

    def __init__(self, vehicle, serial, log):
        super().__init__(vehicle.publisher)
        self.vehicle, self.serial, self.log, self.moved = vehicle, serial, log, False

    def note(self, event):
        order = self.vehicle.publisher.order_id
        self.log.append({"event": event, "serial": self.serial, "order": order, "at": time.monotonic()})

    async def visit_node(self, node):
        if not self.moved:
            self.moved = True
            self.note("motion")
        at = self.vehicle.publisher.agv_position
        goal = node.node_position
        far = max(abs(goal.x - at.x), abs(goal.y - at.y))
        for step in range(1, int(10 * far) + 1):  # ten poses a second, as a chassis tells them
            await asyncio.sleep(0.1)
            part = step / max(1, int(10 * far))
            self.vehicle.update_position(x=at.x + part * (goal.x - at.x), y=goal.y, theta=0.0, map_id="hall")
        self.vehicle.update_position(x=goal.x, y=goal.y, theta=0.0, map_id="hall")
        if not [n for n in self.vehicle.publisher.node_states if n.sequence_id > node.sequence_id]:
            self.note("arrival")


async def main(size, url):
    log, loop = [], asyncio.get_running_loop()
    vehicles, tasks = [], set()
    print("standing", flush=True)
    await loop.run_in_executor(None, sys.stdin.readline)
    for number in range(size):
        serial = f"v{number}"
        vehicle = VehicleClient(
            VehicleConfig(broker_url=url, manufacturer="Woosh", serial_number=serial, state_interval=25.0)
        )
        await vehicle.connect()
        vehicle.update_position(x=0.0, y=float(number), theta=0.0, map_id="hall", position_initialized=True)
        vehicle.set_operating_mode(OperatingMode.AUTOMATIC)

        def take(order, vehicle=vehicle, serial=serial):
            task = asyncio.ensure_future(Executor(vehicle, serial, log).run(order))
            tasks.add(task)
            task.add_done_callback(tasks.discard)

        vehicle.on_order(take)
        await vehicle.publish_state()
        vehicles.append(vehicle)
    print("open", flush=True)
    while line := await loop.run_in_executor(None, sys.stdin.readline):
        if line.strip() == "log":
            for entry in log:
                print(json.dumps(entry))
            print("logged", flush=True)
    for vehicle in vehicles:
        await vehicle.disconnect()


asyncio.run(main(int(sys.argv[1]), sys.argv[2]))
