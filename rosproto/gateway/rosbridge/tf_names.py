"""The graph names of tf2_web_republisher, which clients may use without a write pattern."""

from __future__ import annotations

from rosproto.gateway.access import Kind

ACTION = "/tf2_web_republisher"
SERVICE = "/republish_tfs"
ACTION_TYPE = "tf2_web_republisher/TFSubscriptionAction"
KINDS: dict[str, Kind] = {
    ACTION: "action",
    f"{ACTION}/goal": "topic",
    f"{ACTION}/cancel": "topic",
    SERVICE: "service",
}
"""The names that a client writes to: the action, the topics on which it publishes, and the service."""


def is_tf_name(name: str) -> bool:
    """True for one of `KINDS`."""
    return name in KINDS
