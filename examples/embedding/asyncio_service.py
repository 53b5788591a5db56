"""An asyncio program: subscriptions, service calls and a deadline, without a thread of your own."""

import asyncio
from typing import Any

from rosproto import aio
from woosh_pure import SimulatedChassis


async def watch_battery(node: aio.Node) -> None:
    async with node.subscriber("/battery", None) as battery:
        async for message in battery:
            print("battery", message.batteryPercentage, "%")
            return


async def serve(node: aio.Node) -> None:
    async def answer(request: Any) -> dict[str, object]:
        await asyncio.sleep(0.01)  # other tasks run meanwhile
        return {"success": request.data, "message": "done"}

    kind = "std_srvs/SetBool"
    async with node.service_server("/door", kind, answer), node.service_client("/door", kind) as door:
        print("door", await door.call(data=True, timeout=5))


async def main(master_uri: str) -> None:
    async with aio.Node("/service", master_uri=master_uri) as node:
        await asyncio.wait_for(asyncio.gather(watch_battery(node), serve(node)), timeout=30)


if __name__ == "__main__":
    with SimulatedChassis(speed=4) as sim:
        asyncio.run(main(sim.master_uri))
