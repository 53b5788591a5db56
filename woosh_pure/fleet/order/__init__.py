"""What a vehicle does with orders, updates and actions: a machine without clock, threads or network."""

from __future__ import annotations

from woosh_pure.fleet.order.machine import OrderMachine

__all__ = ["OrderMachine"]
