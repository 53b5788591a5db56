"""A fleet manager made of vda5050-sdk, unmodified; every message is checked by its schemas of 2.1."""

import asyncio
import json
import os

from vda5050 import Action, BlockingType, MasterClient, MasterConfig, OrderBuilder

PLACES = {"n1": (0.0, 0.0), "n2": (1.0, -0.5), "n3": (3.0, 1.0)}
VEHICLE = "Woosh/A-17"


def say(**values: object) -> None:
    print(json.dumps(values), flush=True)


def act(name: str, kind: str = "beep", blocking: BlockingType = BlockingType.HARD) -> Action:
    return Action(action_id=name, action_type=kind, blocking_type=blocking)


def build(order_id: str, way: str, *, actions: dict[str, list[Action]] | None = None, released: int = 99):
    builder = OrderBuilder(order_id=order_id, manufacturer="Woosh", serial_number="A-17")
    names = way.split()
    for n, name in enumerate(names):
        if n:
            builder = builder.add_edge(names[n - 1], name, released=n < released)
        x, y = PLACES[name]
        builder = builder.add_node(
            name, x=x, y=y, map_id="hall", allowed_deviation_xy=0.3, released=n < released,
            actions=(actions or {}).get(name, []),
        )  # fmt: skip
    return builder.build()


async def main() -> None:
    config = MasterConfig(broker_url=os.environ["BROKER"], validate_messages=True)
    master = MasterClient(config)
    states: list[dict[str, object]] = []

    def on_state(state, key) -> None:
        told = {
            "order": state.order_id, "update": state.order_update_id, "last": state.last_node_id,
            "ahead": [node.node_id for node in state.node_states], "paused": state.paused,
            "actions": {each.action_id: str(each.action_status.value) for each in state.action_states},
            "errors": [error.error_type for error in state.errors],
        }  # fmt: skip
        if told not in states[-1:]:
            states.append(told)
            say(event="state", **told)

    master.on_state(on_state)  # before it connects: what is retained comes at once
    master.on_error(lambda event: say(event="complaint", kind=str(event.error_type), text=str(event.error)))
    master.on_connection(lambda c, key: say(event="connection", state=str(c.connection_state.value)))
    master.on_factsheet(
        lambda sheet, key: say(event="factsheet", series=sheet.type_specification.series_name)
    )

    async def until(what: str, accept, seconds: float = 100.0) -> None:
        """Wait for a state: the newest, or one that follows, also if more have come when this process looks."""
        first = max(0, len(states) - 1)
        for _ in range(int(seconds / 0.05)):
            if any(map(accept, states[first:])):
                return
            await asyncio.sleep(0.05)
        say(event="failed", waiting_for=what, state=states[-1:])
        raise SystemExit(1)

    async with master:
        await until("a state", lambda s: True)
        await master.request_factsheet(VEHICLE)
        actions = {"n1": [act("a1"), act("a2", blocking=BlockingType.SOFT)], "n3": [act("a3")]}
        await master.dispatch(build("one", "n1 n2 n3", actions=actions), target=VEHICLE)
        await until("pause", lambda s: s["last"] == "n2")
        await master.pause(VEHICLE, action_id="p")
        await until("paused", lambda s: s["paused"])
        await master.resume(VEHICLE, action_id="r")
        await until(
            "the end",
            lambda s: s["order"] == "one" and not s["ahead"] and s["actions"].get("a3") == "FINISHED",
        )
        # Its last node is not released: the order does not end before it is cancelled.
        await master.dispatch(build("two", "n3 n2 n1", released=2), target=VEHICLE)
        await until("order two", lambda s: s["order"] == "two")
        await asyncio.sleep(0.3)
        await master.cancel_order(VEHICLE, action_id="c")
        await until("cancelled", lambda s: s["actions"].get("c") == "FINISHED" and not s["ahead"])
        await master.cancel_order(VEHICLE, action_id="d")
        await until(
            "refused", lambda s: s["actions"].get("d") == "FAILED" and "noOrderToCancel" in s["errors"]
        )
        say(event="done")


asyncio.run(main())
