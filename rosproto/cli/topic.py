"""`rosproto topic`: list, info, type, find, echo, hz, bw, delay, pub; the words and forms of rostopic."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from rosproto.errors import MasterError

from . import topic_echo, topic_list, topic_pub, topic_rates
from .connection import CommandError, absolute, library_for, master_client, print_json, unknown, verbs, warn
from .field_path import split_topic
from .parser import near
from .shared_options import argument

if TYPE_CHECKING:
    from rosproto.node.graph.master_client import MasterClient, SystemState

__all__ = ["add_arguments"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """One verb each."""
    verbs(
        parser,
        {
            "list": (topic_list.add_arguments, topic_list.run, "list the topics of the graph, or of a bag"),
            "info": (argument("topic"), _info, "tell the type of a topic, who publishes and who subscribes"),
            "type": (argument("topic"), _type, "print the type of a topic"),
            "find": (argument("type", help="package/Type"), _find, "list the topics of a type"),
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


def _known(master: MasterClient, topic: str) -> tuple[SystemState, str]:
    state = master.get_system_state()
    if topic not in state.publishers and topic not in state.subscribers:
        names = {*state.publishers, *state.subscribers}
        raise unknown("nobody publishes or subscribes to", topic, names, "topic list")
    return state, master.get_topic_types().get(topic, "*")


def _info(arguments: argparse.Namespace) -> int:
    topic = absolute(arguments.topic)
    with master_client(arguments) as master:
        state, kind = _known(master, topic)
        uris = {
            n: _uri(master, n) for n in {*state.publishers.get(topic, []), *state.subscribers.get(topic, [])}
        }
    if arguments.json:
        print_json({**topic_list.row(topic, state, {topic: kind}), "uris": uris})
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
    with master_client(arguments) as master:
        types = master.get_topic_types()
        topic, path = split_topic(absolute(arguments.topic), list(types))
        _, kind = _known(master, topic)
    inner = _field_type(arguments, kind, path) if path else ""
    if arguments.json:
        print_json({"type": kind, "field": path, "field_type": inner} if path else kind)
    else:
        print(f"{kind} {path} {inner}" if path else kind)
    return 0


def _field_type(arguments: argparse.Namespace, kind: str, path: str) -> str:
    """Type of a field inside a message type, array marks of elements taken off."""
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


def _find(arguments: argparse.Namespace) -> int:
    with master_client(arguments) as master:
        types = master.get_topic_types()
    found = sorted(t for t, kind in types.items() if kind == arguments.type)
    if arguments.json:
        print_json(found)
    elif found:
        print("\n".join(found))
    else:
        warn(f"no topic carries {arguments.type}{near(arguments.type, set(types.values()))}")
    return 0
