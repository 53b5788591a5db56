"""A message as the values that a rosbridge client gets."""

from __future__ import annotations

import json
from typing import Any

from rosproto.gateway.values import to_json


def to_values(message: Any) -> dict[str, Any]:
    """A message as decoded rosbridge JSON: dicts, lists, texts, numbers, None for NaN."""
    values: dict[str, Any] = json.loads(to_json(message))
    return values
