"""`rosproto graph`: who talks to whom, as text, Graphviz DOT, or a picture."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

from rosproto.text import printable

from .connection import absolute, add_graph_options, master_client, print_json, unknown
from .graph_svg import svg
from .option_types import folder_exists
from .pictures import form_of, write_picture

if TYPE_CHECKING:
    from rosproto.node.graph.master_client import SystemState

__all__ = ["add_arguments", "run"]

QUIET = frozenset(("/rosout", "/rosout_agg", "/clock", "/statistics"))


class Edge(NamedTuple):
    """A topic between two nodes; "" where nobody is on that side."""

    publisher: str
    topic: str
    subscriber: str


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Form, file, and what to leave out."""
    add_graph_options(parser)
    parser.add_argument(
        "--format", choices=("text", "dot", "svg", "png", "pdf"), help="default: text, or by the file's name"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=folder_exists,
        metavar="FILE",
        help="write .svg, .dot or .txt; .png, .pdf by Graphviz",
    )
    parser.add_argument("-a", "--all", action="store_true", help="with /rosout, /clock and the like")
    parser.add_argument("--node", metavar="NAME", help="only what this node is part of")


def run(arguments: argparse.Namespace) -> int:
    """Print or write the graph."""
    form = form_of(arguments.output, arguments.format)
    with master_client(arguments) as master:
        state, types = master.get_system_state(), master.get_topic_types()
    if arguments.node is not None and absolute(arguments.node) not in state.nodes:
        raise unknown("the master knows no node", arguments.node, state.nodes, "node list")
    edges = _edges(state, arguments.all, arguments.node and absolute(arguments.node))
    if arguments.json:
        print_json([edge._asdict() | {"type": types.get(edge.topic, "*")} for edge in edges])
        return 0
    shown = _shown(edges)
    writers = {"text": lambda: _text(shown), "dot": lambda: _dot(shown), "svg": lambda: svg(shown)}
    sys.stdout.write(write_picture(arguments.output, form, writers))
    return 0


def _edges(state: SystemState, everything: bool, node: str | None) -> list[Edge]:
    edges = []
    for topic in sorted({*state.publishers, *state.subscribers}):
        if topic in QUIET and not everything:
            continue
        for publisher in state.publishers.get(topic) or [""]:
            for subscriber in state.subscribers.get(topic) or [""]:
                if node is None or node in (publisher, subscriber):
                    edges.append(Edge(publisher, topic, subscriber))
    return edges


def _shown(edges: list[Edge]) -> list[Edge]:
    """With names as a terminal, an XML reader and Graphviz can take them: JSON alone has them as they are."""
    return [Edge(*map(printable, edge)) for edge in edges]


def _text(edges: list[Edge]) -> str:
    by_publisher: dict[str, list[Edge]] = {}
    for edge in edges:
        by_publisher.setdefault(edge.publisher, []).append(edge)
    lines = []
    for publisher, found in sorted(by_publisher.items()):
        lines.append(publisher or "(nobody publishes)")
        lines += [f"  {edge.topic} -> {edge.subscriber or '(nobody)'}" for edge in found]
    return "".join(line + "\n" for line in lines)


def _dot(edges: list[Edge]) -> str:
    lines = ["digraph ros {", "  rankdir=LR;", "  node [shape=ellipse];"]
    lines += [f"  {quoted(node)};" for node in _nodes(edges)]
    for topic in sorted({edge.topic for edge in edges if not (edge.publisher and edge.subscriber)}):
        lines.append(f"  {quoted('topic ' + topic)} [shape=box, label={quoted(topic)}];")
    for edge in edges:
        if edge.publisher and edge.subscriber:
            lines.append(
                f"  {quoted(edge.publisher)} -> {quoted(edge.subscriber)} [label={quoted(edge.topic)}];"
            )
        elif edge.publisher:
            lines.append(f"  {quoted(edge.publisher)} -> {quoted('topic ' + edge.topic)};")
        else:
            lines.append(f"  {quoted('topic ' + edge.topic)} -> {quoted(edge.subscriber)};")
    return "\n".join([*lines, "}"]) + "\n"


def quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _nodes(edges: Iterable[Edge]) -> list[str]:
    return sorted({name for edge in edges for name in (edge.publisher, edge.subscriber) if name})
