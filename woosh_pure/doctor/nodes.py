"""`woosh doctor`'s look at the nodes of the chassis: whether each can be reached where it says it is.

Each cause is reported once, with all its nodes: a robot that announces an unknown host name has twenty of
them.
"""

from __future__ import annotations

import socket
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from rosproto.errors import ConnectionLost, MasterError, RosError, RosTimeout
from rosproto.transport import Deadline, connect, hosts_advice, parse_uri
from woosh_pure import interface
from woosh_pure.doctor.finding import Finding, Level

if TYPE_CHECKING:
    import rosproto
    from rosproto.transport import HostNames

__all__ = ["chassis_nodes", "check_nodes", "name_list"]

_SHOWN = 5


def chassis_nodes(state: rosproto.node.SystemState) -> list[str]:
    """Nodes that provide something of the chassis's interface."""
    wanted = {row.name for row in interface.ROWS}
    tables = (state.publishers, state.services)
    return sorted({node for table in tables for name in table if name in wanted for node in table[name]})


def check_nodes(
    client: rosproto.MasterClient, state: rosproto.node.SystemState, hosts: HostNames, timeout: float
) -> Iterator[Finding]:
    """One finding for each cause, or one that says that all can be reached."""
    nodes = chassis_nodes(state)
    unknown: dict[str, dict[str, str]] = {}  # host name -> node -> why the master's address does not do
    others: dict[tuple[str, str], list[str]] = {}  # (problem, advice) -> nodes
    for node in nodes:
        try:
            host, port = parse_uri(client.lookup_node(node))
        except (RosError, ValueError) as error:
            others.setdefault(_not_told(error), []).append(node)
            continue
        problem = _reach(host, port, hosts, timeout)
        if host in hosts.unknown:
            unknown.setdefault(host, {})[node] = problem
        elif problem:
            others.setdefault((problem, _RESTART), []).append(node)
    for host, found in unknown.items():
        yield unresolved(host, found, hosts)
    for (problem, advice), found_nodes in others.items():
        yield Finding("node", Level.PROBLEM, f"{name_list(found_nodes)}: {problem}", advice)
    if not others and not any(any(found.values()) for found in unknown.values()):
        yield Finding("node", Level.OK, f"{len(nodes)} nodes of the chassis can be reached")


_RESTART = "it may have crashed: restart the robot"


def unresolved(host: str, found: dict[str, str], hosts: HostNames) -> Finding:
    """Nodes that announce an unknown host name; `found`: why the master's address does not do."""
    address = hosts.resolve(host)[0]
    text = f"{name_list(found)} announce the host name {host}, which does not resolve here"
    silent = [node for node, problem in found.items() if problem]
    if silent:
        which = "them" if len(silent) == len(found) else name_list(silent)
        text += f"; the master's address {address} was tried, and does not answer for {which}"
    else:
        text += f"; the master's address {address} answers for all of them, and is used"
    level = Level.PROBLEM if silent else Level.WARNING
    return Finding("node", level, text, hosts_advice(host, address, sure=len(silent) < len(found)))


def name_list(nodes: Iterable[str]) -> str:
    """ "/a", or "17 nodes (/a, /b, /c, /d, /e and 12 more)"."""
    names = sorted(nodes)
    if len(names) == 1:
        return names[0]
    more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    return f"{len(names)} nodes ({', '.join(names[:_SHOWN])}{more})"


def _not_told(error: Exception) -> tuple[str, str]:
    if isinstance(error, MasterError):
        return f"the master cannot tell where it is: {error.text}", _RESTART
    return f"the master cannot tell where it is: {error}", _RESTART


def _reach(host: str, port: int, hosts: HostNames, timeout: float) -> str:
    """Why nobody answers there; "" when somebody does."""
    sock: socket.socket | None = None
    try:
        sock = connect(host, port, Deadline(timeout), hosts=hosts)
    except RosTimeout:
        return f"nothing answers at {host} within {timeout:g} s"
    except ConnectionLost as error:
        refused = isinstance(error.__cause__, ConnectionRefusedError)
        return f"nobody listens on the ports they announce at {host}" if refused else str(error)
    finally:
        if sock is not None:
            sock.close()
    return ""
