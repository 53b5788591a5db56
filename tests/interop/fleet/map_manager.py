"""A fleet manager made of vda5050-sdk, unmodified, that brings a vehicle another map and sends it there."""

import asyncio
import hashlib
import json
import os
from pathlib import Path

from vda5050 import Action, BlockingType, MasterClient, MasterConfig, OrderBuilder
from vda5050.errors import MapError
from vda5050.model.common import ActionParameter

VEHICLE = "Woosh/A-17"
HERE, LIFT, THERE = (0.0, 0.0), (1.0, -0.5), (1.0, -1.5)


def say(**values: object) -> None:
    print(json.dumps(values), flush=True)


def order(order_id: str, nodes: list[tuple[str, tuple[float, float], str]], lift: str | None = None):
    """Over nodes, each with its place and map; at `lift` the map becomes the next node's."""
    builder = OrderBuilder(order_id=order_id, manufacturer="Woosh", serial_number="A-17")
    for n, (name, (x, y), map_id) in enumerate(nodes):
        if n:
            builder = builder.add_edge(nodes[n - 1][0], name)
        actions = []
        if name == lift:
            target = {"x": x, "y": y, "theta": 0.0, "mapId": nodes[n + 1][2], "lastNodeId": name}
            parameters = [ActionParameter(key=key, value=value) for key, value in target.items()]
            actions = [
                Action(
                    action_id=f"{order_id}-lift", action_type="initPosition",
                    blocking_type=BlockingType.HARD, action_parameters=parameters,
                )
            ]  # fmt: skip
        builder = builder.add_node(
            name, x=x, y=y, map_id=map_id, allowed_deviation_xy=0.3, released=True, actions=actions
        )
    return builder.build()


async def main() -> None:
    archive = Path(os.environ["ARCHIVE"]).read_bytes()
    config = MasterConfig(broker_url=os.environ["BROKER"], validate_messages=True)
    async with MasterClient(config) as master:
        seen: dict[str, object] = {}

        def on_state(state, key) -> None:
            position = state.agv_position
            told = {
                "order": state.order_id, "last": state.last_node_id,
                "ahead": [node.node_id for node in state.node_states],
                "map": position.map_id if position else None,
                "maps": {f"{m.map_id} {m.map_version}": str(m.map_status.value) for m in state.maps or ()},
                "actions": {a.action_id: str(a.action_status.value) for a in state.action_states},
                "errors": [error.error_type for error in state.errors],
            }  # fmt: skip
            if told != seen.get("state"):
                seen["state"] = told
                say(event="state", **told)

        master.on_state(on_state)
        master.on_error(
            lambda event: say(event="complaint", kind=str(event.error_type), text=str(event.error))
        )

        async def until(what: str, accept, seconds: float = 100.0) -> None:
            for _ in range(int(seconds / 0.05)):
                state = seen.get("state")
                if state is not None and accept(state):
                    return
                await asyncio.sleep(0.05)
            say(event="failed", waiting_for=what, state=seen.get("state"))
            raise SystemExit(1)

        async def ended(action_id: str) -> None:
            await until(action_id, lambda s: s["actions"].get(action_id) in ("FINISHED", "FAILED"))
            say(event="action", id=action_id, status=seen["state"]["actions"][action_id])

        await until("a state", lambda s: bool(s["maps"]) and s["map"] is not None)
        upstairs = [("n1", HERE, "hall"), ("lift", LIFT, "hall"), ("up1", THERE, "up")]
        try:
            await master.dispatch(order("early", upstairs, "lift"), target=VEHICLE, require_maps=True)
        except MapError as error:
            say(event="held back", text=str(error))
        for version in ("1", "2"):
            name = await master.download_map(
                VEHICLE, map_id="up", map_version=version, map_download_link=os.environ["LINK"],
                map_hash=hashlib.sha256(archive).hexdigest(),
            )  # fmt: skip
            await ended(name)
        await ended(await master.enable_map(VEHICLE, map_id="up", map_version="1"))
        await ended(await master.enable_map(VEHICLE, map_id="up", map_version="2"))
        await ended(await master.delete_map(VEHICLE, map_id="up", map_version="1"))
        await ended(
            await master.delete_map(VEHICLE, map_id="up", map_version="2", action_id="delete-enabled")
        )
        await master.dispatch(order("no-lift", upstairs), target=VEHICLE)
        await until("the rejection", lambda s: "orderError" in s["errors"])
        await master.dispatch(order("up", upstairs, "lift"), target=VEHICLE, require_maps=True)
        await until("upstairs", lambda s: s["order"] == "up" and s["last"] == "up1" and not s["ahead"])
        say(event="done")


asyncio.run(main())
