"""An assistant at `woosh mcp`: it asks for the state, looks at the map, and goes to a mark after a question.

It needs `pip install ".[mcp]"`.
"""

import asyncio
import sys

from _robot import robot
from mcp import Client, StdioServerParameters
from mcp.client import ClientRequestContext
from mcp.types import ElicitRequestParams, ElicitResult


async def ask_the_person(context: ClientRequestContext, params: ElicitRequestParams) -> ElicitResult:
    """An assistant shows this in its window; here the person says yes."""
    print("asked:", params.message)
    return ElicitResult(action="accept", content={"allow": True})


async def main(master_uri: str) -> None:
    options = ["--allow-motion", "--only-marks"]
    server = StdioServerParameters(
        command=sys.executable, args=["-m", "woosh_pure", "--master", master_uri, "mcp", *options]
    )
    async with Client(server, elicitation_callback=ask_the_person) as client:
        state = await client.call_tool("state")
        print(state.structured_content)
        for part in (await client.call_tool("look_at_map")).content:
            print("map:", part.type)
        arrived = await client.call_tool("go_to_mark", {"mark": "A1"})
        print(arrived.structured_content)


with robot() as chassis:
    asyncio.run(main(chassis.master_uri))
