"""Message classes by name, typed Any: their fields are made at run time, so no type checker can know them."""

from __future__ import annotations

from typing import Any

import rosproto

__all__ = ["message_type", "service_type"]


def message_type(name: str) -> Any:
    """The class of a message type, "package/Type"."""
    return rosproto.message_class(name)


def service_type(name: str) -> Any:
    """The class of a service type, "package/Type"."""
    return rosproto.service_class(name)
