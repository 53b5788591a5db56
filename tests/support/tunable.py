"""A reconfigurable node: the topics and the service of dynamic_reconfigure's server."""

from __future__ import annotations

from typing import Any

from rosproto.codec import message_class
from rosproto.codec.dicts import from_dict
from rosproto.node import Node

__all__ = ["Tunable"]

Config = message_class("dynamic_reconfigure/Config")
Description = message_class("dynamic_reconfigure/ConfigDescription")
FIELDS = ("bools", "ints", "strs", "doubles")
START = {
    "bools": [{"name": "enabled", "value": True}],
    "ints": [{"name": "size", "value": 3}],
    "strs": [{"name": "mode", "value": "slow"}],
    "doubles": [{"name": "speed", "value": 0.5}],
}
KINDS = {"enabled": "bool", "size": "int", "mode": "str", "speed": "double"}
DESCRIPTION = {
    "groups": [
        {
            "name": "Default",
            "parameters": [{"name": n, "type": k, "description": f"the {n}"} for n, k in KINDS.items()],
        }
    ],
    "max": {"doubles": [{"name": "speed", "value": 1.0}], "ints": [{"name": "size", "value": 9}]},
    "dflt": START,
}


class Tunable:
    """A dynamic_reconfigure server: latched description and values, a service; limits speed to its maximum."""

    def __init__(self, node: Node, name: str) -> None:
        self.values = from_dict(Config, START)
        self._updates = node.publisher(f"{name}/parameter_updates", Config, latch=True)
        self._updates.publish(self.values)
        node.publisher(f"{name}/parameter_descriptions", Description, latch=True).publish(
            from_dict(Description, DESCRIPTION)
        )
        node.service_server(f"{name}/set_parameters", "dynamic_reconfigure/Reconfigure", self._set)

    def _set(self, request: Any) -> dict[str, Any]:
        for field in FIELDS:
            new = {one.name: one.value for one in getattr(request.config, field)}
            for one in getattr(self.values, field):
                one.value = new.get(one.name, one.value)
        self.values.doubles[0].value = min(1.0, self.values.doubles[0].value)
        self._updates.publish(self.values)
        return {"config": self.values}
