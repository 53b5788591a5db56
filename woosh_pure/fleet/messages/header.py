"""The header that every message begins with: who it is for, a headerId that counts up for each topic, and the
time. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime, timezone
from typing import Any

from woosh_pure.fleet.messages.schema import HEADER, check, require

__all__ = ["Headers", "check_header", "timestamp"]

_MOST = 2**32  # headerId is a uint32 and begins anew


def timestamp(seconds: float) -> str:
    """Seconds since 1970 as the standard writes them: ISO 8601, UTC, with hundredths and a Z."""
    moment = datetime.fromtimestamp(seconds, timezone.utc)
    return moment.strftime("%Y-%m-%dT%H:%M:%S.") + f"{moment.microsecond // 10000:02d}Z"


def check_header(data: Mapping[str, Any], *, version: str, manufacturer: str, serial: str) -> None:
    """Require that a message is for this vehicle, in a version that it speaks.

    Args:
        data: The message.
        version: Of the protocol; messages may be of any version with the same first number.
        manufacturer, serial: Who this vehicle is.

    Raises:
        Invalid: It is for another vehicle, or of another major version; the path names the field.
    """
    check(data, HEADER, "")
    major = version.partition(".")[0]
    given = data["version"]
    require(given.partition(".")[0] == major, "version", f"a version {major}", given)
    for key, ours in (("manufacturer", manufacturer), ("serialNumber", serial)):
        require(data[key] == ours, key, f"{ours}: this vehicle", data[key])


class Headers:
    """Makes the headers of one vehicle's messages.

    Args:
        version: Of the protocol, "2.1.0".
        manufacturer, serial: Who this vehicle is.
    """

    def __init__(self, version: str, manufacturer: str, serial: str) -> None:
        self._fixed = {"version": version, "manufacturer": manufacturer, "serialNumber": serial}
        self._next: dict[str, int] = {}

    def header(self, topic: str, now: float) -> dict[str, Any]:
        """The next header of a topic; `now` in seconds since 1970."""
        number = self._next.get(topic, 0)
        self._next[topic] = (number + 1) % _MOST
        return {"headerId": number, "timestamp": timestamp(now), **self._fixed}
