"""`rosproto topic list`: the topics of a graph, in rostopic's forms, or of a bag."""

from __future__ import annotations

import argparse
import time
from typing import TYPE_CHECKING

from rosproto.errors import MasterError
from rosproto.text import printable

from .connection import below, master_client, print_json, warn_if_none
from .shared_options import add_allow_damaged

if TYPE_CHECKING:
    from rosproto.bag import BagReader
    from rosproto.node.graph.master_client import MasterClient, SystemState

__all__ = ["add_arguments", "row", "run"]

Side = dict[str, list[str]]
"""Topics of one side, publishers or subscribers, with their nodes."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of rostopic list."""
    parser.add_argument(
        "namespace", nargs="?", default="", help="only topics below this namespace, or of a pattern: '/move*'"
    )
    parser.add_argument(
        "-v", "--verbose", dest="details", action="store_true", help="types, and numbers of both sides"
    )
    side = parser.add_mutually_exclusive_group()
    side.add_argument("-p", "--publishers", action="store_true", help="only published ones")
    side.add_argument("-s", "--subscribers", action="store_true", help="only subscribed ones")
    parser.add_argument("--host", action="store_true", help="grouped by the host of their nodes")
    parser.add_argument("-b", "--bag", metavar="FILE", help="the topics of a bag, not of a graph")
    add_allow_damaged(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print them."""
    if arguments.bag:
        return _of_bag(arguments)
    with master_client(arguments) as master:
        state, types = master.get_system_state(), master.get_topic_types()
        published = {} if arguments.subscribers else _only(state.publishers, arguments.namespace)
        subscribed = {} if arguments.publishers else _only(state.subscribers, arguments.namespace)
        hosts = _by_host(master, published, subscribed) if arguments.host else None
    names = {*state.publishers, *state.subscribers}
    warn_if_none({*published, *subscribed}, "topic", arguments.namespace, names)
    if arguments.json:
        rows = [row(name, state, types) for name in sorted({*published, *subscribed})]
        print_json(rows if hosts is None else {h: sorted({*a, *b}) for h, (a, b) in hosts.items()})
    elif hosts is None:
        _print(published, subscribed, types, arguments, "")
    else:
        for host, (a, b) in hosts.items():
            print(f"Host [{host}]:")
            _print(a, b, types, arguments, "  ")
    return 0


def _only(side: Side, asked: str) -> Side:
    """Those below a namespace or of a pattern, in the master's order, in which -v shows them."""
    wanted = set(below(side, asked))
    return {name: nodes for name, nodes in side.items() if name in wanted}


def row(name: str, state: SystemState, types: dict[str, str]) -> dict[str, object]:
    """Facts of one topic, for --json."""
    return {
        "name": name,
        "type": types.get(name, "*"),
        "publishers": state.publishers.get(name, []),
        "subscribers": state.subscribers.get(name, []),
    }


def _print(
    published: Side, subscribed: Side, types: dict[str, str], arguments: argparse.Namespace, indent: str
) -> None:
    if arguments.details:
        if not arguments.subscribers:
            print(f"\n{indent}Published topics:")
            _print_side("publisher", published, types, indent)
        if not arguments.publishers:
            print(f"{indent}\n{indent}Subscribed topics:")
            _print_side("subscriber", subscribed, types, indent)
        print()
    else:
        for name in sorted({*published, *subscribed}):
            print(indent + name)


def _print_side(what: str, side: Side, types: dict[str, str], indent: str) -> None:
    for name, nodes in side.items():
        kind = types.get(name, "*")
        shown = "unknown type" if kind == "*" else kind
        print(f"{indent} * {name} [{shown}] {len(nodes)} {what}{'s'[: len(nodes) > 1]}")


def _by_host(master: MasterClient, published: Side, subscribed: Side) -> dict[str, tuple[Side, Side]]:
    """Each host's part of both sides; a node that leaves meanwhile is left out."""
    from rosproto.transport.address import parse_uri

    host_of: dict[str, str] = {}
    for node in {node for side in (published, subscribed) for nodes in side.values() for node in nodes}:
        try:
            host_of[node] = parse_uri(master.lookup_node(node))[0]
        except (MasterError, ValueError):
            continue

    def part(side: Side, host: str) -> Side:
        found = {name: [n for n in nodes if host_of.get(n) == host] for name, nodes in side.items()}
        return {name: nodes for name, nodes in found.items() if nodes}

    return {host: (part(published, host), part(subscribed, host)) for host in sorted(set(host_of.values()))}


def _stamps(bag: BagReader, names: list[str]) -> list[float]:
    """When each message came, s."""
    from .bag_progress import Progress

    found = []
    with Progress(f"reading {bag.path}", sum(bag.topics[name].message_count for name in names)) as progress:
        for _, _, stamp in bag.read_messages(topics=names, raw="view"):
            found.append(stamp.to_sec())
            progress.step()
    return found


def _of_bag(arguments: argparse.Namespace) -> int:
    """Topics, or with a namespace how many messages it has, from when to when: as rostopic list -b."""
    from .bag_opening import opened

    with opened(arguments.bag, arguments) as bag:
        names = below(bag.topics, arguments.namespace)
        stamps = _stamps(bag, names) if arguments.namespace and names else []
        facts = [(name, bag.topics[name]) for name in names]
    if arguments.json:
        print_json([{"name": n, "types": t.types, "messages": t.message_count} for n, t in facts])
    elif arguments.namespace:
        times = [time.strftime("%d %b %Y %H:%M:%S", time.localtime(t)) for t in stamps]
        between = f" from {times[0]} to {times[-1]}" if times else ""
        print(f"{len(times)} message(s){between}")
    else:
        for name in names:
            print(printable(name))
    return 0
