"""`rosproto topic`: list, info, type, find, echo, hz, bw, delay, pub; output as of rostopic.

The options of all verbs are here; `echo`, `publish` and `topic_rates` have the verbs that need nodes.
"""

from __future__ import annotations

import argparse
import time
from typing import TYPE_CHECKING

from rosproto.cli import topic_rates
from rosproto.cli.console import warn
from rosproto.cli.exit_codes import CommandError
from rosproto.cli.fields import split_topic
from rosproto.cli.graph_clients import absolute, below, master_client, unknown, warn_if_none
from rosproto.cli.graph_options import add_verbs, library_for
from rosproto.cli.options import add_allow_damaged, argument, count, positive, whole_from
from rosproto.cli.parser import near
from rosproto.errors import MasterError
from rosproto.text import printable

if TYPE_CHECKING:
    from rosproto.bag import BagReader
    from rosproto.node.graph.master_client import MasterClient, SystemState


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verbs."""
    add_verbs(
        parser,
        {
            "list": (_add_list_arguments, _list, "list the topics of the graph, or of a bag"),
            "info": (argument("topic"), _info, "tell the type of a topic, who publishes and who subscribes"),
            "type": (argument("topic"), _type, "print the type of a topic"),
            "find": (argument("type", help="package/Type"), _find, "list the topics of a type"),
            "echo": (add_echo_arguments, echo, "print messages, or one field of them"),
            "hz": (topic_rates.add_hz_arguments, topic_rates.run_hz, "measure how often messages come"),
            "bw": (topic_rates.add_bw_arguments, topic_rates.run_bw, "measure how many bytes a second come"),
            "delay": (
                topic_rates.add_hz_arguments,
                topic_rates.run_delay,
                "measure arrival minus header stamp",
            ),
            "pub": (_add_pub_arguments, _pub, "publish messages"),
        },
    )


def _known(master: MasterClient, topic: str) -> tuple[SystemState, str]:
    state = master.get_system_state()
    if topic not in state.publishers and topic not in state.subscribers:
        names = {*state.publishers, *state.subscribers}
        raise unknown("nobody publishes or subscribes to", topic, names, "topic list")
    return state, master.get_topic_types().get(topic, "*")


def _info(arguments: argparse.Namespace) -> None:
    topic = absolute(arguments.topic)
    with master_client(arguments) as master:
        state, kind = _known(master, topic)
        uris = {
            n: _uri(master, n) for n in {*state.publishers.get(topic, []), *state.subscribers.get(topic, [])}
        }
    if arguments.json:
        arguments.out.record({**_row(topic, state, {topic: kind}), "uris": uris})
        return
    print(f"Type: {'unknown type' if kind == '*' else kind}\n")
    for title, nodes in (("Publishers", state.publishers), ("Subscribers", state.subscribers)):
        found = nodes.get(topic, [])
        print(f"{title}: " + ("" if found else "None"))
        for node in found:
            print(f" * {node} ({uris[node]})")
        print()
    print()


def _uri(master: MasterClient, node: str) -> str:
    try:
        return master.lookup_node(node)
    except MasterError:
        return "unknown address"  # it has gone since the previous call


def _type(arguments: argparse.Namespace) -> None:
    with master_client(arguments) as master:
        types = master.get_topic_types()
        topic, path = split_topic(absolute(arguments.topic), list(types))
        _, kind = _known(master, topic)
    if path:
        inner = _field_type(arguments, kind, path)
        arguments.out.answer({"type": kind, "field": path, "field_type": inner}, f"{kind} {path} {inner}")
    else:
        arguments.out.answer(kind, kind)


def _field_type(arguments: argparse.Namespace, kind: str, path: str) -> str:
    """Return the type of a field of a message type, without array marks for elements."""
    from rosproto.codec import message_class

    library = library_for(arguments, kind)
    for step in path.split("/"):
        name, bracket, _ = step.partition("[")
        cls = message_class(kind, library)
        if name not in cls.__slots__:
            raise CommandError(f"{kind} has no field {name!r}; it has: {', '.join(cls.__slots__) or 'none'}")
        kind = cls._slot_types[list(cls.__slots__).index(name)]
        if bracket:
            kind = kind.partition("[")[0]
    return kind


def _find(arguments: argparse.Namespace) -> None:
    with master_client(arguments) as master:
        types = master.get_topic_types()
    found = sorted(t for t, kind in types.items() if kind == arguments.type)
    if not found and not arguments.json:
        warn(f"no topic carries {arguments.type}{near(arguments.type, set(types.values()))}")
    arguments.out.answer(found, found)


Side = dict[str, list[str]]
"""Topics of one side, publishers or subscribers, with their nodes."""


def _add_list_arguments(parser: argparse.ArgumentParser) -> None:
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


def _list(arguments: argparse.Namespace) -> None:
    """Print them."""
    if arguments.bag:
        _of_bag(arguments)
        return
    with master_client(arguments) as master:
        state, types = master.get_system_state(), master.get_topic_types()
        published = {} if arguments.subscribers else _only(state.publishers, arguments.namespace)
        subscribed = {} if arguments.publishers else _only(state.subscribers, arguments.namespace)
        hosts = _by_host(master, published, subscribed) if arguments.host else None
    names = {*state.publishers, *state.subscribers}
    warn_if_none({*published, *subscribed}, "topic", arguments.namespace, names)
    if arguments.json:
        rows = [_row(name, state, types) for name in sorted({*published, *subscribed})]
        arguments.out.record(rows if hosts is None else {h: sorted({*a, *b}) for h, (a, b) in hosts.items()})
    elif hosts is None:
        _print(published, subscribed, types, arguments, "")
    else:
        for host, (a, b) in hosts.items():
            print(f"Host [{host}]:")
            _print(a, b, types, arguments, "  ")


def _only(side: Side, asked: str) -> Side:
    """Select by namespace or pattern, in the master's order (for -v)."""
    wanted = set(below(side, asked))
    return {name: nodes for name, nodes in side.items() if name in wanted}


def _row(name: str, state: SystemState, types: dict[str, str]) -> dict[str, object]:
    """Return a topic's data for --json."""
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
    """Group both sides by host, without nodes that leave meanwhile."""
    from rosproto.transport.uri import parse_uri

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
    """Return the receive time of each message, s."""
    from rosproto.cli.bag_progress import Progress

    found = []
    with Progress(f"reading {bag.path}", sum(bag.topics[name].message_count for name in names)) as progress:
        for _, _, stamp in bag.read_messages(topics=names, raw="view"):
            found.append(stamp.to_sec())
            progress.step()
    return found


def _of_bag(arguments: argparse.Namespace) -> None:
    """Print topics, or the message count and times of a namespace, as rostopic list -b."""
    from rosproto.cli.bag_files import opened

    with opened(arguments.bag, arguments) as bag:
        names = below(bag.topics, arguments.namespace)
        stamps = _stamps(bag, names) if arguments.namespace and names else []
        facts = [(name, bag.topics[name]) for name in names]
    lines = [printable(name) for name in names]
    if arguments.namespace:
        times = [time.strftime("%d %b %Y %H:%M:%S", time.localtime(t)) for t in stamps]
        between = f" from {times[0]} to {times[-1]}" if times else ""
        lines = [f"{len(times)} message(s){between}"]
    found = [{"name": n, "types": t.types, "messages": t.message_count} for n, t in facts]
    arguments.out.answer(found, lines)


def add_echo_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of rostopic echo, and ours."""
    parser.add_argument(
        "topic",
        nargs="?",
        help="a topic, with a path to a field behind it: /odom/pose/pose/position/x, /scan/ranges[0:9]; "
        "or a pattern for several: '/battery*'",
    )
    parser.add_argument("topics", nargs="*", default=[], help="with --plot: more numbers to draw")
    parser.add_argument("-n", type=count, metavar="COUNT", help="stop after this many messages")
    parser.add_argument("-p", "--csv", action="store_true", dest="csv", help="one line of CSV per message")
    parser.add_argument("-c", "--clear", action="store_true", help="clear the screen before each message")
    parser.add_argument(
        "--filter", metavar="EXPRESSION", help='only messages for which it is true: "m.x > 1"'
    )
    parser.add_argument("--noarr", action="store_true", help="print the size of arrays, not their elements")
    parser.add_argument("--nostr", action="store_true", help="leave strings out")
    parser.add_argument("--offset", action="store_true", help="times as durations since now")
    parser.add_argument("-b", "--bag", metavar="FILE", help="read messages from a bag, not from a graph")
    add_allow_damaged(parser)
    parser.add_argument("-a", "--all", action="store_true", help="with a bag: the messages of every topic")
    parser.add_argument("--plot", action="store_true", help="draw numbers over time in the terminal")
    parser.add_argument(
        "--seconds", type=positive, metavar="S", help="with --plot: seconds to show (30; of a bag: all)"
    )
    parser.add_argument("-w", type=whole_from(1, 100), metavar="WIDTH", dest="width", help="width of numbers")
    parser.add_argument(
        "--timeout", type=positive, metavar="S", help="give up after S seconds without a message"
    )


def echo(arguments: argparse.Namespace) -> None:
    """Print until interrupted, or -n messages."""
    from rosproto.cli.echo import run  # late: `topic list` needs no codec

    run(arguments)


def _add_pub_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of rostopic pub."""
    parser.add_argument("topic")
    parser.add_argument("type", help="package/Type")
    parser.add_argument(
        "values",
        nargs="*",
        default=[],
        help="{field: value}, or the fields in order; now and auto for times, a whole number is in "
        "nanoseconds; without any they are read from standard input",
    )
    how = parser.add_mutually_exclusive_group()
    how.add_argument("-r", "--rate", type=positive, metavar="HZ", help="publish this often, per second")
    how.add_argument("-1", "--once", action="store_true", help="publish one message and end")
    parser.add_argument(
        "-f", "--file", default=None, help="take the values from a YAML or JSON file, - is stdin"
    )
    parser.add_argument("-l", "--latch", action="store_true", help="latch also with -r, and with a file")
    parser.add_argument(
        "-s", "--substitute-keywords", action="store_true", help="accepted: now and auto always work"
    )
    parser.add_argument("--use-rostime", action="store_true", help="accepted for compatibility with rostopic")
    parser.add_argument("-n", type=count, default=None, metavar="COUNT", help="stop after this many messages")


def _pub(arguments: argparse.Namespace) -> None:
    from rosproto.cli.publish import run

    run(arguments)
