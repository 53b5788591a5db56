"""Checks arguments of callers: the master (a host, a URI, or $ROS_MASTER_URI by default), and time limits."""

from __future__ import annotations

import math
import os

from rosproto.coercion import as_float
from rosproto.sentence import say

VENDOR_ADDRESS = "169.254.128.2"
"""The chassis on its debug Ethernet port."""


def master_uri_of(address: str | None) -> str:
    """The master URI of "169.254.128.2", "robot:11311", "http://robot:11311/" or None.

    Of a robot that has only the Robot API it is "ws://robot:5480".

    Raises:
        ValueError: None was given and $ROS_MASTER_URI is not set, or the text is not an address.
    """
    uri = _as_uri(address)
    from rosproto.transport import parse_uri  # lazy: imported with the first Chassis

    parse_uri(uri)
    return uri


def _as_uri(address: str | None) -> str:
    if address is None:
        address = os.environ.get("ROS_MASTER_URI", "").strip()
        if not address:
            raise ValueError(
                say(
                    "no chassis is given, and ROS_MASTER_URI is not set: give an address, or save it once "
                    "with `woosh connect {example}`; without a robot: `woosh --sim`, for a program "
                    "`woosh run --sim first.py`, in Python SimulatedChassis",
                    example=VENDOR_ADDRESS,
                )
            )
    if not isinstance(address, str):
        wrong = "{address!r} is not an address; give text, a host such as {example!r}"
        raise ValueError(say(wrong, address=address, example=VENDOR_ADDRESS))
    text = address.strip()
    if text.startswith("ws://"):
        from rosproto.transport import make_uri
        from woosh_pure.robot_api.http import only_robot_api

        api = only_robot_api(text)
        assert api is not None
        return make_uri(api.host, api.port, "ws").removesuffix("/")
    if "://" in text:
        if not text.startswith("http://"):
            wrong = "{address}: a master URI starts with http://, for example {example}"
            raise ValueError(say(wrong, address=text, example=f"http://{VENDOR_ADDRESS}:11311"))
        return text
    if not text or any(c.isspace() or c == "/" for c in text):
        wrong = "{address!r} is not an address; give a host such as {example} or a master URI"
        raise ValueError(say(wrong, address=address, example=VENDOR_ADDRESS))
    from rosproto.transport import master_uri_of as uri_of

    return uri_of(text)


MAX_TIMEOUT_SECONDS = 864_000.0
"""Seconds."""


def require_timeout(timeout: float | None, name: str = "timeout") -> float | None:
    """Return a checked time limit as a float: seconds of at least 0, or None for no limit.

    Raises:
        ValueError: It is negative or NaN (a NaN would never expire).
    """
    seconds = as_float(timeout)
    if seconds is None or (seconds >= 0.0 and not math.isnan(seconds)):
        return seconds
    wrong = "{name}={timeout}: expected a number of seconds, at least 0, or None to wait for ever"
    raise ValueError(say(wrong, name=name, timeout=timeout))


def require_limit(timeout: float, name: str = "timeout") -> float:
    """As `require_timeout`, but a limit is required, of at most 10 days: the system's waits do not accept
    every float.

    Raises:
        ValueError: It is negative, NaN or infinite.
    """
    seconds = as_float(timeout)
    if seconds is None or not 0.0 <= seconds < math.inf:
        wrong = "{name}={timeout}: expected a finite number of seconds, at least 0"
        raise ValueError(say(wrong, name=name, timeout=timeout))
    return min(seconds, MAX_TIMEOUT_SECONDS)


def require_seconds(seconds: float) -> float:
    """Return checked seconds as a float.

    Raises:
        ValueError: They are negative or not finite.
    """
    seconds = as_float(seconds)
    if not (math.isfinite(seconds) and seconds >= 0.0):
        raise ValueError(say("seconds={seconds}: expected a finite number of at least 0", seconds=seconds))
    return seconds
