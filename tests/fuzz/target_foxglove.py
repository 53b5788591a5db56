"""Fuzz target of the Foxglove server: what viewers send, as text and as bytes."""

from __future__ import annotations

from rosproto.gateway.foxglove import messages
from rosproto.json_text import JsonReader

READER = JsonReader(200, 20)


def foxglove(data: bytes) -> str:
    """One message; the first byte chooses between text and binary."""
    sent: str | bytes = data[1:] if data[:1] < b"\x80" else data[1:].decode("utf-8", "replace")
    try:
        asked = messages.read(sent, READER)
    except messages.MessageError:
        return "wrong"
    if isinstance(asked, messages.Call):
        messages.service_failure(asked, "no")
        messages.service_response(asked, asked.data)
    if isinstance(asked, messages.SetParameters):
        messages.parameter_values(asked.parameters, asked.id)
    return type(asked).__name__


TARGETS = {"foxglove": foxglove}
