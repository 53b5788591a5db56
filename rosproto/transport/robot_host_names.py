"""Map host names that a robot announces and this computer cannot resolve.

A robot whose ROS_IP is not set announces its nodes by a host name, which a laptop beside it seldom knows. The
user can give an address for a name (`--resolve`); any other unresolvable name is assumed to be the master's
computer, on which a robot nearly always runs everything. If a connection to that fails, the error names the
unresolved name as the cause.
"""

from __future__ import annotations

import re
import sys
import threading
import time
from collections.abc import Iterable, Mapping

from rosproto.errors import ConnectionLost, RosTimeout
from rosproto.logs import get_logger
from rosproto.sentence import both, say
from rosproto.transport.deadline import Deadline
from rosproto.transport.name_lookup import resolve
from rosproto.transport.uri import is_numeric

VARIABLE = "ROSPROTO_RESOLVE"
"""Read by the commands, by programs for rospy, and by `Node(use_environment=True)`: "NAME=IP,NAME=IP"."""
LOOKUP_SECONDS = 1.5
"""Seconds for a name server: where there is none (a cable to a robot), a lookup hangs for half a minute."""
MAX_NAMES = 64  # names remembered and warned of, since peers choose them
RETRY_SECONDS = 30.0  # after this an unknown name is looked up again

_PLAIN = re.compile(r"[a-z0-9._-]{1,253}", re.ASCII)
"""A host name; any other text that a peer announces is only looked up."""

_log = get_logger("rosproto.transport")


class HostNames:
    """Resolves host names for one node or command. Thread-safe.

    Args:
        given: Name -> address (or another name), given by the user.
        master: Host of the master, assumed for names that cannot be resolved; "" for none.
        quiet: Do not log a warning for those; the caller reports them.

    Raises:
        ValueError: A name or an address is invalid.
    """

    def __init__(
        self, given: Mapping[str, str] | None = None, *, master: str = "", quiet: bool = False
    ) -> None:
        self._quiet = quiet
        self.given = {_checked(name).lower(): _checked(address) for name, address in (given or {}).items()}
        self.master = master.strip("[]").lower()
        self._lock = threading.Lock()
        self._unknown: dict[str, float] = {}
        self._warned = 0

    def __repr__(self) -> str:
        return f"<HostNames {self.given}, else {self.master or 'as the system says'}>"

    def mapped(self, host: str) -> str:
        """The host given for this one, or the host itself."""
        return self.given.get(host.strip("[]").lower(), host)

    @property
    def unknown(self) -> list[str]:
        """Names for which the master's host was assumed, sorted."""
        with self._lock:
            return sorted(self._unknown)

    def is_guess(self, host: str) -> bool:
        """Whether the master's host was assumed for this one, so that a refused connection proves nothing."""
        return self.mapped(host).strip("[]").lower() in self.unknown

    def resolve(self, host: str, deadline: Deadline | None = None) -> list[str]:
        """Numeric addresses of a host, the best first; see `rosproto.transport.name_lookup.resolve`.

        Raises:
            ConnectionLost: The name is unknown, and there is no master's host to assume.
            RosTimeout: The name server did not answer.
        """
        mapped = self.mapped(host).strip("[]")
        if is_numeric(mapped):
            return [mapped]
        key = mapped.lower()
        deadline = deadline or Deadline(10.0)
        if not self.master or not _PLAIN.fullmatch(key):
            return resolve(mapped, deadline)
        if key in ("localhost", self.master):
            return resolve(mapped, deadline)
        if not self._was_unknown(key):
            try:
                return resolve(mapped, deadline.at_most(LOOKUP_SECONDS))
            except (ConnectionLost, RosTimeout):
                deadline.check(say("look up host name {host!r}", host=mapped))
        addresses = resolve(self.mapped(self.master), deadline)
        self._note(key, addresses[0])
        return addresses

    def why(self, host: str) -> str:
        """A sentence to add to an error about this host; "" if its name was resolved."""
        mapped = self.mapped(host).strip("[]")
        if not self.is_guess(host):
            return ""
        return say(
            "host name {name!r} cannot be resolved here, so the master's address was tried: give the "
            "right one "
            "with --resolve {given}=ADDRESS (resolve= in Python), or add it to the hosts file",
            name=mapped,
            given=mapped,
        )

    def _was_unknown(self, key: str) -> bool:
        with self._lock:
            since = self._unknown.get(key)
        return since is not None and time.monotonic() - since < RETRY_SECONDS

    def _note(self, key: str, address: str) -> None:
        with self._lock:
            first = key not in self._unknown
            if first or time.monotonic() - self._unknown[key] >= RETRY_SECONDS:
                if first and len(self._unknown) >= MAX_NAMES:
                    del self._unknown[min(self._unknown, key=self._unknown.__getitem__)]
                self._unknown[key] = time.monotonic()
            self._warned += first
            logged = self._warned <= MAX_NAMES
        if first and logged and not self._quiet:
            _log.warning(
                "! host name %r cannot be resolved here: trying the master's address %s for it; if it is "
                "another computer, give its own with --resolve %s=ADDRESS (resolve= in Python)",
                key,
                address,
                key,
            )


def hosts_advice(name: str, address: str | None, *, sure: bool = True) -> str:
    """Advice for a name that does not resolve: the line for the hosts file, and the alternatives.

    Args:
        name: The host name.
        address: Its address; None if unknown.
        sure: False if the address is only assumed to be the master's, and does not answer.
    """
    shown = address or "ADDRESS"
    if sys.platform == "win32":
        file = r"C:\Windows\System32\drivers\etc\hosts"
        add = 'for all programs: add the line "{address} {name}" to {file} (as administrator)'
    else:
        file = "/etc/hosts"
        add = 'for all programs: add the line "{address} {name}" to {file} (with sudo)'
    line = say(add, name=name, address=shown, file=file)
    if not sure:
        line = say(
            "{text}, with its own address in place of {address} if {name} is another computer than the "
            "master's",
            text=line,
            address=shown,
            name=name,
        )
    elif not address:
        line = say("{text} (ADDRESS is that of the computer that calls itself {name})", text=line, name=name)
    give = "give --resolve {name}={address} (or {variable}={name}={address}, or resolve= in Python)"
    return both(
        say(give, name=name, address=shown, variable=VARIABLE),
        line,
        "it is best to set ROS_IP on that computer",
    )


def parse_host_names(texts: Iterable[str]) -> dict[str, str]:
    """Name -> address of "NAME=IP" texts; one text may hold several, separated by commas or blanks.

    Raises:
        ValueError: One cannot be parsed; the text shows the correct form.
    """
    found = {}
    for text in texts:
        for part in re.split(r"[,;\s]+", text.strip()) if text.strip() else ():
            name, mark, address = part.partition("=")
            if not (mark and name and address):
                wrong = "{text!r} is not of the form NAME=IP; expected something like robot-7=169.254.128.2"
                raise ValueError(say(wrong, text=part))
            found[_checked(name)] = _checked(address)
    return found


def _checked(host: str) -> str:
    bare = host.strip().strip("[]") if isinstance(host, str) else ""
    if not bare or any(c.isspace() or c in "/@=,;[]" for c in bare) or (":" in bare and not is_numeric(bare)):
        raise ValueError(
            say("{text!r} is not a host name or address; expected something like 169.254.128.2", text=host)
        )
    return bare
