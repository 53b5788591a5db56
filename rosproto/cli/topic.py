"""`rosproto topic`: list, info, type, find, echo, hz, bw, delay, pub; the words and forms of rostopic."""

from __future__ import annotations

import argparse

from rosproto.errors import MasterError
from rosproto.node.master_client import MasterClient, SystemState

from . import topic_echo, topic_pub, topic_rates
from .graph import CommandError, master_client, print_json, verbs

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """One verb each."""
    verbs(
        parser,
        {
            "list": (_list_arguments, _list, "list the topics of the graph"),
            "info": (_topic_arguments, _info, "tell the type of a topic, who publishes and who subscribes"),
            "type": (_topic_arguments, _type, "print the type of a topic"),
            "find": (_find_arguments, _find, "list the topics of a type"),
            "echo": (topic_echo.add_arguments, topic_echo.run, "print messages, or one field of them"),
            "hz": (topic_rates.add_hz_arguments, topic_rates.run_hz, "measure how often messages come"),
            "bw": (topic_rates.add_bw_arguments, topic_rates.run_bw, "measure how many bytes a second come"),
            "delay": (
                topic_rates.add_hz_arguments,
                topic_rates.run_delay,
                "measure arrival minus header stamp",
            ),
            "pub": (topic_pub.add_arguments, topic_pub.run, "publish messages"),
        },
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the verb."""
    code: int = arguments.run_verb(arguments)
    return code


def _topic_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("topic")


def _find_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("type", help="package/Type")


def _list_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("namespace", nargs="?", default="", help="only topics below this namespace")
    parser.add_argument(
        "-v", "--verbose", dest="details", action="store_true", help="types, and numbers of both sides"
    )
    parser.add_argument("-p", "--publishers", action="store_true", help="only published ones")
    parser.add_argument("-s", "--subscribers", action="store_true", help="only subscribed ones")


def _below(names: dict[str, list[str]], namespace: str) -> dict[str, list[str]]:
    below = namespace.rstrip("/")
    return {n: nodes for n, nodes in names.items() if n == below or n.startswith(below + "/")}


def _list(arguments: argparse.Namespace) -> int:
    with master_client(arguments) as master:
        state, types = master.get_system_state(), master.get_topic_types()
    published = {} if arguments.subscribers else _below(state.publishers, arguments.namespace)
    subscribed = {} if arguments.publishers else _below(state.subscribers, arguments.namespace)
    names = sorted({*published, *subscribed})
    if arguments.json:
        print_json([_row(name, state, types) for name in names])
    elif arguments.details:
        _print_side("Published topics:", "publisher", published, types)
        _print_side("Subscribed topics:", "subscriber", subscribed, types)
        print()
    elif names:
        print("\n".join(names))
    return 0


def _row(name: str, state: SystemState, types: dict[str, str]) -> dict[str, object]:
    return {
        "name": name,
        "type": types.get(name, "*"),
        "publishers": state.publishers.get(name, []),
        "subscribers": state.subscribers.get(name, []),
    }


def _print_side(title: str, what: str, table: dict[str, list[str]], types: dict[str, str]) -> None:
    print(f"\n{title}")
    for name, nodes in table.items():
        kind = types.get(name, "*")
        shown = "unknown type" if kind == "*" else kind
        print(f" * {name} [{shown}] {len(nodes)} {what}{'s'[: len(nodes) > 1]}")


def _known(master: MasterClient, topic: str) -> tuple[SystemState, str]:
    state = master.get_system_state()
    if topic not in state.publishers and topic not in state.subscribers:
        raise CommandError(f"nobody publishes or subscribes to {topic!r}; see: rosproto topic list")
    return state, master.get_topic_types().get(topic, "*")


def _global(name: str) -> str:
    return name if name.startswith("/") else "/" + name


def _info(arguments: argparse.Namespace) -> int:
    topic = _global(arguments.topic)
    with master_client(arguments) as master:
        state, kind = _known(master, topic)
        uris = {
            n: _uri(master, n) for n in {*state.publishers.get(topic, []), *state.subscribers.get(topic, [])}
        }
    if arguments.json:
        print_json({**_row(topic, state, {topic: kind}), "uris": uris})
        return 0
    print(f"Type: {'unknown type' if kind == '*' else kind}\n")
    for title, nodes in (("Publishers", state.publishers), ("Subscribers", state.subscribers)):
        found = nodes.get(topic, [])
        print(f"{title}: " + ("" if found else "None"))
        for node in found:
            print(f" * {node} ({uris[node]})")
        print()
    print()
    return 0


def _uri(master: MasterClient, node: str) -> str:
    try:
        return master.lookup_node(node)
    except MasterError:
        return "unknown address"  # it left between two calls


def _type(arguments: argparse.Namespace) -> int:
    from .field_path import split_topic

    with master_client(arguments) as master:
        types = master.get_topic_types()
        topic, path = split_topic(_global(arguments.topic), list(types))
        _, kind = _known(master, topic)
    inner = _field_type(kind, path) if path else ""
    if arguments.json:
        print_json({"type": kind, "field": path, "field_type": inner} if path else kind)
    else:
        print(f"{kind} {path} {inner}" if path else kind)
    return 0


def _field_type(kind: str, path: str) -> str:
    """Type of a field inside a message type, array marks of elements taken off."""
    from rosproto.codec import message_class

    for step in path.split("/"):
        name, bracket, _ = step.partition("[")
        cls = message_class(kind)
        if name not in cls.__slots__:
            raise CommandError(f"{kind} has no field {name!r}; it has: {', '.join(cls.__slots__) or 'none'}")
        kind = cls._slot_types[list(cls.__slots__).index(name)]
        if bracket:
            kind = kind.partition("[")[0]
    return kind


def _find(arguments: argparse.Namespace) -> int:
    with master_client(arguments) as master:
        found = sorted(t for t, kind in master.get_topic_types().items() if kind == arguments.type)
    if arguments.json:
        print_json(found)
    elif found:
        print("\n".join(found))
    return 0
