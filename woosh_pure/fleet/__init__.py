"""VDA 5050 over MQTT: a chassis as a vehicle of a fleet manager; the command is `woosh vda5050`.

Needs the extra `fleet`.
"""

from __future__ import annotations

from woosh_pure.fleet.action_handlers.running_action import Task
from woosh_pure.fleet.config import Broker, FleetConfig, VehicleConfig, load_config
from woosh_pure.fleet.vehicle import Vehicle
from woosh_pure.state_file import Store

__all__ = ["Broker", "FleetConfig", "Store", "Task", "Vehicle", "VehicleConfig", "load_config"]
