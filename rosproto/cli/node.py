"""`rosproto node`: list, info, ping, kill, cleanup, machine; output as of rosnode."""

from __future__ import annotations

import argparse
import time
from typing import TYPE_CHECKING, Any

from rosproto.cli.console import warn
from rosproto.cli.exit_codes import CommandError
from rosproto.cli.graph_clients import absolute, below, master_client, node_client, unknown, warn_if_none
from rosproto.cli.graph_options import add_verbs, host_names
from rosproto.cli.options import argument, count, positive
from rosproto.errors import ConnectionLost, MasterError, RosError, RosTimeout
from rosproto.text import printable

if TYPE_CHECKING:
    from rosproto.node.graph.master_client import MasterClient, SystemState
    from rosproto.node.graph.slave_client import BusConnection


RULE = "-" * 80
GONE = (ConnectionLost, RosTimeout)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verbs."""
    add_verbs(
        parser,
        {
            "list": (_list_arguments, _list, "list the nodes of the graph"),
            "info": (
                argument("node", nargs="+"),
                _info,
                "tell what a node publishes, subscribes to, serves, and its links",
            ),
            "ping": (_ping_arguments, _ping, "ask a node for a sign of life, again and again"),
            "kill": (_kill_arguments, _kill, "ask nodes to shut down"),
            "cleanup": (_cleanup_arguments, _cleanup, "unregister nodes that no longer answer"),
            "machine": (argument("host", nargs="*"), _machine, "list hosts, or the nodes on one host"),
        },
    )


def _cleanup_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--timeout", type=positive, default=2.0, metavar="S", help="seconds to wait for a node's answer (2)"
    )


def _list_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("namespace", nargs="?", default="", help="only nodes below this namespace")
    parser.add_argument("-u", "--uris", action="store_true", help="print URIs instead of names")
    parser.add_argument("-a", "--all", action="store_true", help="print URIs and names")


def _list(arguments: argparse.Namespace) -> None:
    with master_client(arguments) as master:
        nodes = master.get_system_state().nodes
        names = below(nodes, arguments.namespace)
        warn_if_none(names, "node", arguments.namespace, nodes)
        if not (arguments.uris or arguments.all or arguments.json):
            arguments.out.answer(names, names)
            return
        uris = {name: _uri(master, name) for name in names}
    lines = [f"{uri} \t{name}" if arguments.all else uri for name, uri in uris.items()]
    arguments.out.answer([{"name": name, "uri": uri} for name, uri in uris.items()], lines)


def _uri(master: MasterClient, name: str) -> str:
    try:
        return master.lookup_node(name)
    except MasterError as error:
        nodes = master.get_system_state().nodes
        raise unknown("the master knows no node", name, nodes, "node list") from error


def _info(arguments: argparse.Namespace) -> None:
    with master_client(arguments) as master:
        state, types = master.get_system_state(), master.get_topic_types()
        facts = [_facts(master, absolute(name), state, types, arguments) for name in arguments.node]
    if arguments.json:
        arguments.out.record(facts if len(facts) > 1 else facts[0])
    else:
        for fact in facts:
            _print_facts(fact)


def _facts(
    master: MasterClient,
    name: str,
    state: SystemState,
    types: dict[str, str],
    arguments: argparse.Namespace,
) -> dict[str, Any]:
    uri = _uri(master, name)
    facts: dict[str, Any] = {
        "name": name,
        "uri": uri,
        "publications": _of(state.publishers, name, types),
        "subscriptions": _of(state.subscribers, name, types),
        "services": sorted(s for s, nodes in state.services.items() if name in nodes),
    }
    try:
        with node_client(uri, arguments) as node:
            facts["pid"] = node.get_pid()
            facts["connections"] = [_connection(master, state, row) for row in node.get_bus_info()]
    except GONE as error:
        facts["error"] = str(error)
    return facts


def _of(table: dict[str, list[str]], name: str, types: dict[str, str]) -> dict[str, str]:
    return {topic: types.get(topic, "*") for topic, nodes in sorted(table.items()) if name in nodes}


def _connection(master: MasterClient, state: SystemState, row: BusConnection) -> dict[str, object]:
    """Return a link. Subscribers know publishers by URI (as in rospy); the master has the names."""
    peer = row.destination
    if peer.startswith("http"):
        name = next((n for n in state.nodes if _same(master, n, peer)), None)
        peer = f"{name} ({peer})" if name else peer
    direction = {"o": "outbound", "i": "inbound", "b": "both"}.get(row.direction, row.direction)
    return {"topic": row.topic, "peer": peer, "direction": direction, "transport": row.transport}


def _same(master: MasterClient, name: str, uri: str) -> bool:
    from rosproto.transport.uri import parse_uri

    try:
        return parse_uri(master.lookup_node(name)) == parse_uri(uri)
    except (RosError, ValueError):
        return False


def _print_facts(fact: dict[str, Any]) -> None:
    print(RULE)
    print(f"Node [{fact['name']}]")
    for title, key in (("Publications", "publications"), ("Subscriptions", "subscriptions")):
        print(f"{title}: " + ("" if fact[key] else "None"))
        for topic, kind in fact[key].items():
            print(f" * {topic} [{'unknown type' if kind == '*' else kind}]")
        print()
    print("Services: " + ("" if fact["services"] else "None"))
    for service in fact["services"]:
        print(f" * {service}")
    print(f"\n\ncontacting node {fact['uri']} ...")
    if "error" in fact:
        print(f"ERROR: Communication with node[{fact['uri']}] failed! {printable(str(fact['error']))}")
        return
    print(f"Pid: {fact['pid']}")
    if fact["connections"]:
        print("Connections:")
    for link in fact["connections"]:
        print(f" * topic: {link['topic']}")
        print(f"    * to: {link['peer']}")
        print(f"    * direction: {link['direction']}")
        print(f"    * transport: {link['transport']}")
    print()


def _ping_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("node", nargs="*")
    parser.add_argument("-a", "--all", action="store_true", help="every node, once")
    parser.add_argument(
        "-c", "--count", type=count, default=None, metavar="N", help="stop after this many (default: Ctrl-C)"
    )
    parser.add_argument(
        "--timeout", type=positive, default=3.0, metavar="S", help="seconds to wait for a node's answer (3)"
    )


def _chosen(master: MasterClient, arguments: argparse.Namespace) -> list[str]:
    """Return the named nodes, or all with --all."""
    names = master.get_system_state().nodes if arguments.all else [absolute(n) for n in arguments.node]
    if not names:
        raise ValueError("name a node, or give --all; see: rosproto node list")
    return names


def _ping(arguments: argparse.Namespace) -> int:
    with master_client(arguments) as master:
        names = _chosen(master, arguments)
        times = 1 if arguments.all else arguments.count
        results = [_ping_node(master, name, times, arguments) for name in names]
    if arguments.json:
        arguments.out.record(results)
    return 0 if all(result["answers"] for result in results) else 1


def _ping_node(
    master: MasterClient, name: str, count: int | None, arguments: argparse.Namespace
) -> dict[str, object]:
    uri = _uri(master, name)
    if not arguments.json:
        print(f"rosnode: node is [{name}]\npinging {name} with a timeout of {arguments.timeout}s")
    times: list[float] = []
    sent = 0
    with node_client(uri, arguments) as node:
        while count is None or sent < count:
            sent += 1
            began = time.perf_counter()
            try:
                node.get_pid(timeout=arguments.timeout)
            except GONE as error:
                if not arguments.json:
                    print(f"cannot ping [{name}]: {printable(str(error))}", flush=True)
            else:
                times.append(1e3 * (time.perf_counter() - began))
                if not arguments.json:
                    print(f"xmlrpc reply from {uri}\ttime={times[-1]:f}ms", flush=True)
            if count is None or sent < count:
                time.sleep(1.0)
    if times and not arguments.json:
        print(f"ping average: {sum(times) / len(times):f}ms")
    return {"name": name, "uri": uri, "sent": sent, "answers": len(times), "milliseconds": times}


def _kill_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("node", nargs="*")
    parser.add_argument("-a", "--all", action="store_true", help="every node of the graph")


def _kill(arguments: argparse.Namespace) -> int:
    with master_client(arguments) as master:
        names = _chosen(master, arguments)
        killed, failed = [], {}
        for name in names:
            try:
                uri = _uri(master, name)
            except CommandError as error:
                failed[name] = str(error)
                continue
            try:
                with node_client(uri, arguments, guess=False) as node:
                    node.shutdown("user request")
                killed.append(name)
            except RosError as error:
                failed[name] = str(error)
    if arguments.json:
        arguments.out.record({"killed": killed, "failed": failed})
        return 1 if failed else 0
    for name in killed:
        print(f"killing {name}\nkilled")
    if failed:
        raise CommandError("; ".join(failed.values()))
    return 0


def _cleanup(arguments: argparse.Namespace) -> None:
    with master_client(arguments) as master:
        state = master.get_system_state()
        silent = [name for name in state.nodes if not _answers(master, name, arguments)]
        elsewhere = [name for name in silent if _is_elsewhere(master, name, arguments)]
        dead = [name for name in silent if name not in elsewhere]
        for name in dead:
            _unregister(master, name, state)
    if elsewhere:
        warn(
            f"not known whether they live, and left alone: {', '.join(elsewhere)}: their host names cannot "
            "be resolved here; give --resolve NAME=IP"
        )
    lines = [f"Unregistering {name}" for name in dead]
    arguments.out.answer(dead, lines if dead or elsewhere else "every node answers")


def _answers(master: MasterClient, name: str, arguments: argparse.Namespace) -> bool:
    try:
        with node_client(_uri(master, name), arguments) as node:
            node.get_pid(timeout=arguments.timeout)
        return True
    except GONE:
        return False


def _is_elsewhere(master: MasterClient, name: str, arguments: argparse.Namespace) -> bool:
    """Whether its host name cannot be resolved here; then a missing answer proves nothing."""
    from rosproto.transport.uri import parse_uri

    try:
        return host_names(arguments).is_guess(parse_uri(_uri(master, name))[0])
    except (CommandError, ValueError):
        return False


def _unregister(master: MasterClient, name: str, state: SystemState) -> None:
    """Unregister a dead node by its old URI: a restarted node has another."""
    uri = _uri(master, name)
    from rosproto.node.graph.master_client import MasterClient

    with MasterClient(master.uri, name) as as_node:
        for topic, nodes in state.publishers.items():
            if name in nodes:
                as_node.unregister_publisher(topic, uri)
        for topic, nodes in state.subscribers.items():
            if name in nodes:
                as_node.unregister_subscriber(topic, uri)
        for service, nodes in state.services.items():
            if name in nodes:
                as_node.unregister_service(service, master.lookup_service(service))


def _machine(arguments: argparse.Namespace) -> None:
    from rosproto.transport.uri import parse_uri

    with master_client(arguments) as master:
        hosts: dict[str, list[str]] = {}
        for name in master.get_system_state().nodes:
            hosts.setdefault(parse_uri(_uri(master, name))[0], []).append(name)
    for host in arguments.host:
        if host not in hosts:
            raise CommandError(f"no node runs on {host!r}; hosts: {', '.join(sorted(hosts)) or 'none'}")
    asked = {host: sorted(hosts[host]) for host in arguments.host} or hosts
    nodes = [name for names in asked.values() for name in names]
    arguments.out.answer(asked, "\n".join(nodes if arguments.host else sorted(hosts)))
