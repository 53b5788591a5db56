"""What the actions of an order do: those of the standard, the maps, and actions of the user's own."""

from __future__ import annotations

from woosh_pure.fleet.action_handlers.running_action import Task

__all__ = ["Task"]
