"""`woosh doctor`'s look at the nodes of the chassis: whether each can be reached where it says it is.

Each cause is reported once, with all its nodes: a robot that announces an unknown host name has twenty of
them.
"""

from __future__ import annotations

import socket
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from rosproto.errors import ConnectionLost, MasterError, RosError, RosTimeout
from rosproto.sentence import both, led, say
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
        yield Finding("node", Level.PROBLEM, led(name_list(found_nodes), problem), advice)
    if not others and not any(any(found.values()) for found in unknown.values()):
        yield Finding("node", Level.OK, say("{count} nodes of the chassis can be reached", count=len(nodes)))


_RESTART = "it may have crashed: restart the robot"


def unresolved(host: str, found: dict[str, str], hosts: HostNames) -> Finding:
    """Nodes that announce an unknown host name; `found`: why the master's address does not do."""
    address = hosts.resolve(host)[0]
    text = say(
        "{nodes} announce the host name {host}, which does not resolve here",
        nodes=name_list(found),
        host=host,
    )
    silent = [node for node, problem in found.items() if problem]
    if silent:
        if len(silent) == len(found):
            tried = say(
                "the master's address {address} was tried, and does not answer for them", address=address
            )
        else:
            tried = say(
                "the master's address {address} was tried, and does not answer for {nodes}",
                address=address,
                nodes=name_list(silent),
            )
        text = both(text, tried)
    else:
        used = "the master's address {address} answers for all of them, and is used"
        text = both(text, say(used, address=address))
    level = Level.PROBLEM if silent else Level.WARNING
    return Finding("node", level, text, hosts_advice(host, address, sure=len(silent) < len(found)))


def name_list(nodes: Iterable[str]) -> str:
    """ "/a", or "17 nodes (/a, /b, /c, /d, /e and 12 more)"."""
    names = sorted(nodes)
    if len(names) == 1:
        return names[0]
    if len(names) <= _SHOWN:
        return say("{count} nodes ({names})", count=len(names), names=names)
    more = "{count} nodes ({names} and {more} more)"
    return say(more, count=len(names), names=names[:_SHOWN], more=len(names) - _SHOWN)


def _not_told(error: Exception) -> tuple[str, str]:
    if isinstance(error, MasterError):
        return say("the master cannot tell where it is: {error}", error=error.text), _RESTART
    return say("the master cannot tell where it is: {error}", error=error), _RESTART


def _reach(host: str, port: int, hosts: HostNames, timeout: float) -> str:
    """Why nobody answers there; "" when somebody does."""
    sock: socket.socket | None = None
    try:
        sock = connect(host, port, Deadline(timeout), hosts=hosts)
    except RosTimeout:
        return say("nothing answers at {host} within {seconds:g} s", host=host, seconds=timeout)
    except ConnectionLost as error:
        refused = isinstance(error.__cause__, ConnectionRefusedError)
        return (
            say("nobody listens on the ports they announce at {host}", host=host) if refused else str(error)
        )
    finally:
        if sock is not None:
            sock.close()
    return ""
