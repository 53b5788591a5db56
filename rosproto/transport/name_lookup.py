"""Look up the addresses of a host name: the system's resolver, with a time-out.

No name server is asked about a numeric address or `localhost`, and there is no reverse DNS: a missing name
server would otherwise cost seconds per connection. `robot_host_names.py` adds names given with `--resolve`.
"""

from __future__ import annotations

import socket
import threading

from rosproto.errors import ConnectionLost
from rosproto.sentence import say
from rosproto.transport.deadline import Deadline
from rosproto.transport.uri import is_numeric, plain_host


def resolve(host: str, deadline: Deadline | None = None) -> list[str]:
    """Numeric addresses of a host, the best first: IPv4 before IPv6 (ROS 1 peers speak IPv4).

    Numeric addresses and `localhost` need no lookup (127.0.0.1 before ::1, for which Windows would wait two
    seconds). A name is looked up in a thread, because the system's resolver has no time-out.

    Raises:
        ConnectionLost: The name is unknown.
        RosTimeout: The name server did not answer before `deadline` (None: within 10 seconds).
    """
    host = host.strip("[]")
    try:
        plain_host(host)
    except ValueError as error:
        raise ConnectionLost(str(error), peer=host) from None
    if is_numeric(host):
        return [host]
    if host.lower() == "localhost":
        return ["127.0.0.1", "::1"]
    wrong = _wrong_ipv4(host)
    if wrong:
        raise ConnectionLost(wrong, peer=host)
    return _look_up(host, deadline or Deadline(10.0))


def _wrong_ipv4(host: str) -> str | None:
    """Why a text of digits and dots is not an address; None for a name.

    No name server is asked, since the last part of a name is never a number (RFC 3696, section 2). Short
    forms that some resolvers accept (127.1) are left to them.
    """
    parts = host.removesuffix(".").split(".")
    if not all(part.isascii() and part.isdigit() for part in parts) or len(parts) == 1:
        return None
    large = [part for part in parts if int(part[:9]) > 255]
    if len(parts) > 4:
        why = say("expected 4 numbers, got {count}", count=len(parts))
    elif large and len(parts) == 4:
        why = say("{number} is more than 255", number=large[0][:20])
    else:
        return None
    return say(
        "{host} is not a valid IPv4 address: {why}; expected something like 10.0.0.7", host=host[:80], why=why
    )


class _Lookup:
    """A running lookup of a name, in a thread."""

    def __init__(self, host: str) -> None:
        self.host = host
        self.addresses: list[str] = []
        self.failure: Exception | None = None
        self.done = threading.Event()

    def run(self) -> None:
        try:
            found = socket.getaddrinfo(self.host, None, 0, socket.SOCK_STREAM)
            found.sort(key=lambda entry: entry[0] != socket.AF_INET)
            self.addresses = list(dict.fromkeys(str(entry[4][0]) for entry in found))
        except (OSError, UnicodeError) as error:  # UnicodeError: a label longer than 63 characters
            self.failure = error
        finally:
            with _lookups_lock:
                del _lookups[self.host]
            self.done.set()


# Running lookups, so that many links that retry one unknown name share one thread. It may hang for half a
# minute and cannot be ended earlier.
_lookups: dict[str, _Lookup] = {}
_lookups_lock = threading.Lock()


def _look_up(host: str, deadline: Deadline) -> list[str]:
    with _lookups_lock:
        lookup = _lookups.get(host)
        if lookup is None:
            lookup = _Lookup(host)
            threading.Thread(target=lookup.run, name=f"rosproto:resolve {host}", daemon=True).start()
            _lookups[host] = lookup
    if not lookup.done.wait(deadline.remaining()):
        raise deadline.error(say("look up host name {host!r}", host=host))
    if lookup.addresses:
        return list(lookup.addresses)
    raise ConnectionLost(
        say(
            "host name {host!r} cannot be resolved ({error}); add it to the hosts file or the name "
            "server, or let the other side announce a numeric address (ROS_IP or ROS_HOSTNAME there)",
            host=host,
            error=lookup.failure,
        ),
        peer=host,
    ) from lookup.failure
