"""What a vehicle publishes: connection, state, factsheet and visualization, each with its header."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from rosproto.version import __version__
from woosh_pure.fleet.actions.log_report import Journal
from woosh_pure.fleet.broker import Broker
from woosh_pure.fleet.config import VehicleConfig
from woosh_pure.fleet.factsheet import Body, factsheet_message
from woosh_pure.fleet.link import BrokerConnection
from woosh_pure.fleet.messages.header import Headers
from woosh_pure.fleet.order.limits import Limits
from woosh_pure.fleet.order.state import OrderState
from woosh_pure.fleet.state import Facts, state_message, visualization_message

if TYPE_CHECKING:
    from woosh_pure.values import Parameters

__all__ = ["Publisher"]


class Publisher:
    """The messages of one vehicle.

    Args:
        config: Who it is.
        broker: Where the broker is.
        received: See `BrokerConnection`.
        changed: Likewise.
        journal: What was told is noted there; None notes nothing.

    Attributes:
        connection: The vehicle's connection with the broker.
        outline: Corners (x, y) in m in base_link, for the factsheet.
    """

    def __init__(
        self,
        config: VehicleConfig,
        broker: Broker,
        received: Callable[[str, bytes], object],
        changed: Callable[[bool], object],
        journal: Journal | None = None,
    ) -> None:
        self._config, self._journal = config, journal
        self._headers = Headers(config.version, config.manufacturer, config.serial)
        self._lock = threading.Lock()
        self.connection = BrokerConnection(broker, config.prefix, self._connection_message, received, changed)
        self.outline: Sequence[tuple[float, float]] = tuple((float(x), float(y)) for x, y in config.footprint)

    def _header(self, topic: str) -> dict[str, Any]:
        with self._lock:
            return self._headers.header(topic, time.time())

    def _connection_message(self, state: str) -> dict[str, Any]:
        return {**self._header("connection"), "connectionState": state}

    def send_state(self, order: OrderState, facts: Facts) -> None:
        """The state as it is now; nothing while there is no broker."""
        self.connection.revive()
        if not self.connection.connected.is_set():
            return
        message = state_message(order, facts, self._header("state"), self._config.version)
        self.connection.send("state", message)
        if self._journal is not None:
            told = [f"{each.action.id} {each.status.value}" for each in order.action_states[-5:]]
            kinds = [problem.kind for problem in order.problems]
            self._journal.note(f"> state {message['headerId']}: at {order.last_node}, {told}, {kinds}")

    def send_visualization(self, facts: Facts) -> None:
        """Pose and velocity for displays."""
        self.connection.send("visualization", visualization_message(facts, self._header("visualization")))

    def send_factsheet(self, limits: Limits, known: Parameters | None) -> None:
        """What the vehicle is and can.

        Args:
            limits: What it can do.
            known: The parameters of its drives; None while the chassis has not told them.
        """
        config = self._config
        body = Body(
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
        self.connection.send("factsheet", message, retain=True)
