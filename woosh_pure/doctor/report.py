"""`woosh doctor --report FILE`: findings, versions and the graph, without addresses and personal names.

Addresses, host names and the user's folder become `address-1`, `host-1` and `~`, consistently in one report,
so equal ones remain recognisable. Nodes, topics and types stay: they are needed for support.
"""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Iterable, Mapping
from typing import Any

from rosproto.node import SystemState
from woosh_pure.doctor.checks import Finding

__all__ = ["Redaction", "report"]

_IPV4 = r"(?<![\w.])\d{1,3}(?:\.\d{1,3}){3}(?!\w|\.\d)"
_IPV6 = r"(?<![\w.:])[0-9A-Fa-f]*:[0-9A-Fa-f:]*:[0-9A-Fa-f:.]*(?![\w:])"
_ADDRESS = re.compile(f"{_IPV4}|{_IPV6}")
_URI_HOST = re.compile(r"(?<=://)[^/:\s\[\]]+")
_KEPT = frozenset({"127.0.0.1", "::1", "0.0.0.0", "localhost"})


class Redaction:
    """Replaces addresses and host names by numbered placeholders, and the user's folder by `~`.

    Args:
        hosts: Host names to replace, besides those in URIs.
        home: The user's folder; "" for none.
    """

    def __init__(self, hosts: Iterable[str] = (), home: str = "") -> None:
        self._home = home.rstrip("/\\")
        self._addresses: dict[str, str] = {}
        self._hosts: dict[str, str] = {}
        for host in hosts:
            self._host(host)

    def __call__(self, value: object) -> Any:
        """Redact a text, or all texts in lists and mappings, including keys."""
        if isinstance(value, str):
            return self._text(value)
        if isinstance(value, Mapping):
            return {self._text(key): self(each) for key, each in value.items()}
        if isinstance(value, (list, tuple)):
            return [self(each) for each in value]
        return value

    def _text(self, text: str) -> str:
        text = str(text)
        if len(self._home) > 1:
            text = text.replace(self._home, "~")
        text = _ADDRESS.sub(lambda found: self._address(found[0]), text)
        for host in _URI_HOST.findall(text):
            self._host(host)
        for host, instead in sorted(self._hosts.items(), key=lambda pair: -len(pair[0])):
            text = re.sub(rf"(?<![^\W_]){re.escape(host)}(?![^\W_])", instead, text, flags=re.IGNORECASE)
        return text

    def _address(self, text: str) -> str:
        try:
            known = ipaddress.ip_address(text)
        except ValueError:
            return text  # a time, a version
        if str(known) in _KEPT:
            return text
        return self._addresses.setdefault(str(known), f"address-{len(self._addresses) + 1}")

    def _host(self, name: str) -> None:
        name = name.lower()
        if name and name not in _KEPT and not name.startswith(("address-", "host-")):
            self._hosts.setdefault(name, f"host-{len(self._hosts) + 1}")


def report(
    findings: Iterable[Finding],
    state: SystemState | None,
    types: Mapping[str, str],
    system: Mapping[str, str],
    redact: Redaction,
) -> dict[str, object]:
    """Return the report as a JSON-compatible dict.

    Args:
        findings: The doctor's findings.
        state: The graph; None if the master did not answer.
        types: Topic -> type, from the master.
        system: Versions on this computer.
        redact: Replaces hosts, addresses and the user's folder.
    """
    graph = None
    if state is not None:
        graph = {"topics": types, **{name: getattr(state, name) for name in SystemState._fields}}
    found = [finding.document() for finding in findings]
    document: dict[str, object] = redact({"system": system, "findings": found, "graph": graph})
    return {"woosh_report": 1, **document}
