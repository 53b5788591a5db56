"""Carries out drives of the order machine as goals of the chassis, each in a thread of its own.

A new drive replaces the one under way, so that a vehicle passes a node without a stop. A halt cancels, and
its end is reported once the chassis has confirmed that it stands still.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rosproto.errors import RosError
from rosproto.logs import get_logger
from woosh_pure.enums import NavDirection, NavigationMode
from woosh_pure.fleet.messages.elements import Edge, Node
from woosh_pure.fleet.order.deviation import AgvPosition
from woosh_pure.fleet.order.effects import Drive

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis

__all__ = ["Driver"]

_log = get_logger("woosh_pure.fleet.driver")
_LIMITS_SECONDS = 5.0


class Driver:
    """Drives one chassis.

    Args:
        chassis: The chassis.
        ended: Called with token, whether it arrived, and why not; in the drive's thread.
        place: Where the vehicle is now.
        marks: Whether a node without a position is a mark.
    """

    def __init__(
        self,
        chassis: Chassis,
        ended: Callable[[int, bool, str], object],
        place: Callable[[], AgvPosition | None],
        *,
        marks: bool = False,
    ) -> None:
        self._chassis, self._ended, self._place, self._marks = chassis, ended, place, marks
        self._lock = threading.Lock()
        self._sending = threading.Lock()  # one goal after the other: an older one must not replace a newer
        self._newest = 0
        self._halted = 0
        self._handle: tuple[int, Any] | None = None
        self._limits: tuple[float, NavDirection] = (0.0, NavDirection.CHASSIS_DECIDES)
        self._closed = False

    def drive(self, effect: Drive) -> None:
        """Start driving; returns at once."""
        with self._lock:
            self._newest = effect.token
        self._begin(lambda: self._work(effect), f"woosh:drive-{effect.node.id}")

    def halt(self, token: int) -> None:
        """Cancel the drive; returns at once, and its end is reported."""
        with self._lock:
            self._halted = token
            handle = self._handle
        if handle is not None and handle[0] == token:
            self._begin(lambda: self._cancel(handle[1]), "woosh:halt")

    def close(self) -> None:
        """Start no further drive, and cancel the one under way."""
        with self._lock:
            self._closed = True
            handle = self._handle
        if handle is not None:
            self._cancel(handle[1])

    @staticmethod
    def _begin(work: Callable[[], None], name: str) -> None:
        threading.Thread(target=work, name=name, daemon=True).start()

    def _cancel(self, handle: Any) -> None:
        try:
            handle.cancel()
        except RosError as error:
            _log.warning("! a drive was not cancelled: %s; the robot may still be driving", error)

    def _unwanted(self, token: int) -> bool:
        return self._closed or token != self._newest or token == self._halted

    def _work(self, effect: Drive) -> None:
        arrived, text = False, "it was not begun"
        try:
            with self._sending:
                with self._lock:
                    unwanted = self._unwanted(effect.token)
                handle = None if unwanted else self._send(effect)
                with self._lock:
                    self._handle = None if handle is None else (effect.token, handle)
                    late = handle is not None and (self._closed or effect.token == self._halted)
            if handle is not None:
                if late:
                    self._cancel(handle)
                outcome = handle.wait(None, raises=False)
                arrived, text = outcome.arrived, outcome.text or str(outcome.kind)
        except (RosError, ValueError) as error:
            text = str(error)
        except Exception as error:
            _log.exception("! a drive failed")
            text = f"{type(error).__name__}: {error}"
        self._ended(effect.token, arrived, text)

    def _send(self, effect: Drive) -> Any:
        node, edge = effect.node, effect.edge
        self._obey(edge)
        if node.position is None:
            return self._chassis.go_to_mark(node.description or node.id, timeout=None, replace=True)
        yaw = node.position.theta
        if yaw is None:
            yaw = self._heading(node)
        return self._chassis.go_to(node.position.x, node.position.y, yaw, timeout=None, replace=True)

    def _heading(self, node: Node) -> float:
        """The direction of travel, for a node that asks for no heading."""
        place, position = self._place(), node.position
        assert position is not None
        if place is None:
            return 0.0
        dx, dy = position.x - place.x, position.y - place.y
        return math.atan2(dy, dx) if math.hypot(dx, dy) > 0.1 else place.theta

    def _obey(self, edge: Edge | None) -> None:
        """Speed and direction of an edge, told to the chassis where they differ from what it was told
        last."""
        options = {} if edge is None else edge.options
        speed = float(options.get("maxSpeed", 0.0))
        direction = NavDirection.CHASSIS_DECIDES
        if "orientation" in options:
            backwards = abs(options["orientation"]) > 1.0
            direction = NavDirection.BACKWARD if backwards else NavDirection.FORWARD
        if (speed, direction) == self._limits:
            return
        self._chassis.set_navigation_mode(
            NavigationMode.PRECISE_AVOIDANCE, max_speed=speed, direction=direction, timeout=_LIMITS_SECONDS
        )
        self._limits = (speed, direction)
