"""`MessagePublisher`: builds a vehicle's state, visualization and factsheet, and sends them to the broker.

The connection belongs to `Vehicle`, and sends its connection messages itself.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

from rosproto.version import __version__
from woosh_pure.fleet.action_handlers.log_report import Journal
from woosh_pure.fleet.broker_connection import BrokerConnection
from woosh_pure.fleet.chassis_facts import ChassisFacts
from woosh_pure.fleet.config import VehicleConfig
from woosh_pure.fleet.order.state import OrderState
from woosh_pure.fleet.order.vehicle_limits import Capabilities
from woosh_pure.fleet.published_messages import (
    MessageHeaders,
    PhysicalParameters,
    factsheet_message,
    state_message,
    visualization_message,
)
from woosh_pure.values import Parameters


class MessagePublisher:
    """Sends the messages of one vehicle.

    Args:
        config: The vehicle.
        connection: Its connection with the broker.
        headers: Makes the messages' headers.
        journal: Each state is noted there; None notes nothing.

    Attributes:
        outline: Corners (x, y) in m in base_link, for the factsheet.
    """

    def __init__(
        self,
        config: VehicleConfig,
        connection: BrokerConnection,
        headers: MessageHeaders,
        journal: Journal | None = None,
    ) -> None:
        self._config, self._connection, self._headers, self._journal = config, connection, headers, journal
        self.outline: Sequence[tuple[float, float]] = tuple((float(x), float(y)) for x, y in config.footprint)

    def _header(self, topic: str) -> dict[str, Any]:
        return self._headers.header(topic, time.time())

    def send_state(self, order: OrderState, facts: ChassisFacts) -> None:
        """Send the state; does nothing while the broker is not connected."""
        self._connection.revive()
        if not self._connection.connected.is_set():
            return
        message = state_message(order, facts, self._header("state"), self._config.version)
        self._connection.send("state", message)
        if self._journal is not None:
            actions = [f"{each.action.id} {each.status.value}" for each in order.action_states[-5:]]
            errors = [problem.kind for problem in order.problems]
            self._journal.note(f"> state {message['headerId']}: at {order.last_node}, {actions}, {errors}")

    def send_visualization(self, facts: ChassisFacts) -> None:
        """Send pose and velocity."""
        self._connection.send("visualization", visualization_message(facts, self._header("visualization")))

    def send_factsheet(self, limits: Capabilities, known: Parameters | None) -> None:
        """Send the factsheet.

        Args:
            limits: The vehicle's capabilities.
            known: The chassis's driving parameters; None if they are not known yet.
        """
        config = self._config
        body = PhysicalParameters(
            series=config.series,
            speed_max=0.0 if known is None else known.max_linear,
            turn_max=0.0 if known is None else known.max_angular,
            height=config.height,
            load=config.load,
            acceleration=config.acceleration,
            outline=self.outline,
        )
        message = factsheet_message(
            body,
            limits,
            self._header("factsheet"),
            version=config.version,
            visualization=config.visualization,
            software=(("woosh-pure", __version__),),
        )
        self._connection.send("factsheet", message, retain=True)
