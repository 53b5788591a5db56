"""Which master: a host, a URI, or nothing ($ROS_MASTER_URI)."""

from __future__ import annotations

import os

from rosproto.sentence import say

__all__ = ["DEFAULT_PORT", "VENDOR_ADDRESS", "master_uri_of"]

DEFAULT_PORT = 11311
VENDOR_ADDRESS = "169.254.128.2"
"""The chassis on its debug Ethernet port."""


def master_uri_of(address: str | None) -> str:
    """The master URI of "169.254.128.2", "robot:11311", "http://robot:11311/" or None.

    Raises:
        ValueError: None was given and $ROS_MASTER_URI is not set, or the text is no address.
    """
    uri = _as_uri(address)
    from rosproto.transport import parse_uri  # with the first Chassis, not with this package

    parse_uri(uri)
    return uri


def _as_uri(address: str | None) -> str:
    if address is None:
        address = os.environ.get("ROS_MASTER_URI", "").strip()
        if not address:
            raise ValueError(
                say(
                    "no chassis given and ROS_MASTER_URI is not set; give an address such as {example}",
                    example=VENDOR_ADDRESS,
                )
            )
    if not isinstance(address, str):
        raise ValueError(
            say(
                "{address!r} is no address; give text, a host such as {example!r}",
                address=address,
                example=VENDOR_ADDRESS,
            )
        )
    text = address.strip()
    if "://" in text:
        if not text.startswith("http://"):
            raise ValueError(
                say(
                    "{address}: a master URI starts with http://, for example {example}",
                    address=text,
                    example=f"http://{VENDOR_ADDRESS}:11311",
                )
            )
        return text
    if not text or any(c.isspace() or c == "/" for c in text):
        raise ValueError(
            say(
                "{address!r} is no address; give a host such as {example} or a master URI",
                address=address,
                example=VENDOR_ADDRESS,
            )
        )
    bare_ipv6 = text.count(":") > 1 and not text.startswith("[")
    host = f"[{text}]" if bare_ipv6 else text
    has_port = host.rpartition(":")[2].isdigit() and not host.endswith("]")
    return f"http://{host}/" if has_port else f"http://{host}:{DEFAULT_PORT}/"
