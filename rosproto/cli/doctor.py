"""`rosproto doctor`: checks the graph from this computer; each finding has advice."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

from rosproto.cli.console import counted
from rosproto.cli.graph_clients import CALLER_ID, master_client
from rosproto.cli.graph_options import add_graph_options, host_names, master_uri
from rosproto.errors import ConnectionLost, RosError, RosTimeout
from rosproto.text import printable

if TYPE_CHECKING:
    from rosproto.node.graph.master_client import MasterClient, SystemState
    from rosproto.transport.robot_host_names import HostNames


PATIENCE = 2.0


class Finding(NamedTuple):
    """One check.

    Attributes:
        check: Name of the check.
        ok: True for success, False for a problem, None for information.
        text: The result.
        advice: What to do, or "".
    """

    check: str
    ok: bool | None
    text: str
    advice: str = ""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the graph."""
    add_graph_options(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print the findings; return 1 if one is a problem."""
    findings = []
    for finding in _all(arguments):
        findings.append(finding)
        if not arguments.json:
            mark = {True: "ok     ", False: "PROBLEM", None: "note   "}[finding.ok]
            print(printable(f"{mark} {finding.check}: {finding.text}"))
            if finding.advice:
                print(printable(f"        -> {finding.advice}"), flush=True)
    if arguments.json:
        arguments.out.record([finding._asdict() for finding in findings])
    return 1 if any(finding.ok is False for finding in findings) else 0


def _all(arguments: argparse.Namespace) -> Iterator[Finding]:
    with master_client(arguments) as master:
        yield from examine(master_uri(arguments), master, host_names(arguments))


def examine(uri: str, master: MasterClient, hosts: HostNames) -> Iterator[Finding]:
    """Yield all findings; each check needs the previous one, so a failure may end the checks."""
    from rosproto.transport.uri import parse_uri

    try:
        host, port = parse_uri(uri)
    except ValueError as error:
        yield Finding("master URI", False, str(error), "write it as http://HOST:11311")
        return
    own = _own_address(hosts.mapped(host), port)
    yield own
    if own.ok is False:
        return
    began = time.monotonic()
    try:
        master.get_pid()
    except RosError as error:
        yield Finding("master", False, str(error), _master_advice(error, host))
        return
    yield Finding("master", True, f"{master.uri} answers after {1e3 * (time.monotonic() - began):.1f} ms")
    yield from _named(master, host)
    state = master.get_system_state()
    yield from _nodes(master, state, hosts)
    yield from _topics(state)


def _own_address(host: str, port: int) -> Finding:
    from rosproto.transport.name_lookup import resolve
    from rosproto.transport.own_address import local_address_towards
    from rosproto.transport.uri import is_loopback

    try:
        address = resolve(host)[0]
        own = local_address_towards(address, port)
    except (RosError, OSError) as error:
        return Finding(
            "route",
            False,
            str(error),
            "is the cable in, is the name right, is this computer on that network?",
        )
    if is_loopback(own) and not is_loopback(address):
        return Finding(
            "route", False, f"{host} is reached through {own}", "check the routes of this computer"
        )
    return Finding("route", True, f"{host} is {address}, reached from our address {own}")


def _master_advice(error: RosError, host: str) -> str:
    if isinstance(error, RosTimeout):
        return (
            f"nothing answers at {host}: check its power, the cable, the address, and a firewall on the way"
        )
    if isinstance(error, ConnectionLost):
        return f"{host} can be reached, but no master listens on that port: start one, or check the port"
    return "is that a ROS master?"


def _named(master: MasterClient, host: str) -> Iterator[Finding]:
    """Report a master with an unresolvable name: it was started without ROS_IP."""
    from rosproto.transport.name_lookup import resolve
    from rosproto.transport.uri import is_loopback, parse_uri

    try:
        name, _ = parse_uri(master.get_uri())
        resolve(name)
    except (RosError, ValueError) as error:
        yield Finding(
            "master's own URI",
            None,
            str(error),
            "its computer should set ROS_IP; we use the address you gave",
        )
    else:
        if is_loopback(resolve(name)[0]) and not is_loopback(resolve(host)[0]):
            yield Finding(
                "master's own URI",
                None,
                f"the master calls itself {name}",
                "start it with ROS_IP set, for others' sake",
            )


def _nodes(master: MasterClient, state: SystemState, hosts: HostNames) -> Iterator[Finding]:
    """Check that each node answers at its registered URI; a common cause is reported once with all nodes."""
    good = 0
    unknown: dict[str, dict[str, str]] = {}  # host name -> node -> why the master's address fails
    for node in state.nodes:
        problem, advice, host = "", "", ""
        try:
            uri = master.lookup_node(node)
            host = _host_of(uri)
            from rosproto.node.graph.slave_client import NodeClient

            with NodeClient(uri, CALLER_ID, timeout=PATIENCE, hosts=hosts) as client:
                client.get_pid(timeout=PATIENCE)
            good += 1
        except RosError as error:
            problem, advice = str(error), _node_advice(error)
        if host in hosts.unknown:
            unknown.setdefault(host, {})[node] = problem
        elif problem:
            yield Finding(f"node {node}", False, problem, advice)
    for host, found in unknown.items():
        yield _unresolved(host, found, hosts)
    yield Finding("nodes", True, f"{good} of {counted(len(state.nodes), 'node')} answer from here")


def _host_of(uri: str) -> str:
    from rosproto.transport.uri import parse_uri

    try:
        return parse_uri(uri)[0]
    except ValueError as error:
        raise RosError(str(error)) from error


def _unresolved(host: str, found: dict[str, str], hosts: HostNames) -> Finding:
    """Report nodes with an unknown host name; `found` maps each to why the master's address fails."""
    from rosproto.transport.robot_host_names import hosts_advice

    address = hosts.resolve(host)[0]
    silent = [node for node, problem in found.items() if problem]
    text = f"{', '.join(found)} announce the host name {host}, which does not resolve here; the master's "
    if silent:
        which = "them" if len(silent) == len(found) else ", ".join(silent)
        text += f"address {address} was tried, and does not answer for {which}"
    else:
        text += f"address {address} answers for all of them, and is used"
    advice = hosts_advice(host, address, sure=len(silent) < len(found))
    return Finding("host name", False if silent else None, text, advice)


def _node_advice(error: RosError) -> str:
    if isinstance(error, RosTimeout):
        return (
            "not reachable from here, or a firewall drops us: set ROS_IP on the node's computer, check routes"
        )
    return "it has probably died without unregistering: rosproto node cleanup"


def _topics(state: SystemState) -> Iterator[Finding]:
    waiting = sorted(t for t, nodes in state.subscribers.items() if nodes and not state.publishers.get(t))
    if waiting:
        yield Finding("topics", None, f"subscribed but published by nobody: {', '.join(waiting)}")
