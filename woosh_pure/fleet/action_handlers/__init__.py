"""What each action does: predefined actions, maps, triggers, and actions that the user configures."""

from __future__ import annotations

from woosh_pure.fleet.action_handlers.running_action import Task

__all__ = ["Task"]
