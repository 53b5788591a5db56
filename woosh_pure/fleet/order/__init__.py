"""The order machine: how a vehicle handles orders, updates and actions. Pure: no clock, threads or
network."""

from __future__ import annotations

from woosh_pure.fleet.order.machine import step
from woosh_pure.fleet.order.state import OrderState, changed, first_state, read_state

__all__ = ["OrderState", "changed", "first_state", "read_state", "step"]
