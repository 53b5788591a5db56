"""`rosproto graph`: who talks to whom, as text, Graphviz DOT, or an SVG picture."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from .graph import absolute, add_graph_options, master_client, print_json, unknown
from .option_types import folder_exists

if TYPE_CHECKING:
    from rosproto.node.master_client import SystemState

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
        "--format", choices=("text", "dot", "svg"), help="default: text, or by the file's name"
    )
    parser.add_argument(
        "-o", "--output", type=folder_exists, metavar="FILE", help="write there instead of standard output"
    )
    parser.add_argument("-a", "--all", action="store_true", help="with /rosout, /clock and the like")
    parser.add_argument("--node", metavar="NAME", help="only what this node is part of")


def run(arguments: argparse.Namespace) -> int:
    """Print or write the graph."""
    with master_client(arguments) as master:
        state, types = master.get_system_state(), master.get_topic_types()
    if arguments.node is not None and absolute(arguments.node) not in state.nodes:
        raise unknown("the master knows no node", arguments.node, state.nodes, "node list")
    edges = _edges(state, arguments.all, arguments.node and absolute(arguments.node))
    if arguments.json:
        print_json([edge._asdict() | {"type": types.get(edge.topic, "*")} for edge in edges])
        return 0
    form = arguments.format or _form_of(arguments.output)
    text = {"text": _text, "dot": _dot, "svg": _svg}[form](edges)
    if arguments.output is None:
        sys.stdout.write(text)
        return 0
    Path(arguments.output).write_text(text, "utf-8")
    return 0


def _form_of(file: Path | None) -> str:
    ending = file.suffix.lower() if file else ""
    return {".dot": "dot", ".gv": "dot", ".svg": "svg"}.get(ending, "text")


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
    lines += [f"  {_quoted(node)};" for node in _nodes(edges)]
    for topic in sorted({edge.topic for edge in edges if not (edge.publisher and edge.subscriber)}):
        lines.append(f"  {_quoted('topic ' + topic)} [shape=box, label={_quoted(topic)}];")
    for edge in edges:
        if edge.publisher and edge.subscriber:
            lines.append(
                f"  {_quoted(edge.publisher)} -> {_quoted(edge.subscriber)} [label={_quoted(edge.topic)}];"
            )
        elif edge.publisher:
            lines.append(f"  {_quoted(edge.publisher)} -> {_quoted('topic ' + edge.topic)};")
        else:
            lines.append(f"  {_quoted('topic ' + edge.topic)} -> {_quoted(edge.subscriber)};")
    return "\n".join([*lines, "}"]) + "\n"


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _nodes(edges: Iterable[Edge]) -> list[str]:
    return sorted({name for edge in edges for name in (edge.publisher, edge.subscriber) if name})


def _svg(edges: list[Edge]) -> str:
    """Three columns, publishers, topics, subscribers: readable without a layout program."""
    columns = [
        sorted({edge.publisher for edge in edges if edge.publisher}),
        sorted({edge.topic for edge in edges}),
        sorted({edge.subscriber for edge in edges if edge.subscriber}),
    ]
    height = 40 + 34 * max((len(column) for column in columns), default=1)
    widths = [40 + 8 * max((len(name) for name in column), default=4) for column in columns]
    lefts = [20, 20 + widths[0] + 80, 20 + widths[0] + widths[1] + 160]
    place = {
        (i, name): (lefts[i], 20 + 34 * row + (height - 40 - 34 * len(column)) // 2)
        for i, column in enumerate(columns)
        for row, name in enumerate(column)
    }
    parts = []
    for edge in edges:
        for a, b in (((0, edge.publisher), (1, edge.topic)), ((1, edge.topic), (2, edge.subscriber))):
            if a in place and b in place:
                x1, y1 = place[a][0] + widths[a[0]], place[a][1] + 13
                x2, y2 = place[b][0], place[b][1] + 13
                bend = (x1 + x2) // 2
                parts.append(f'<path d="M{x1},{y1} C{bend},{y1} {bend},{y2} {x2},{y2}"/>')
    boxes = []
    for (column, name), (x, y) in place.items():
        radius = 4 if column == 1 else 13
        boxes.append(f'<rect x="{x}" y="{y}" width="{widths[column]}" height="26" rx="{radius}"/>')
        boxes.append(f'<text x="{x + widths[column] // 2}" y="{y + 17}">{escape(name)}</text>')
    style = (
        "path{fill:none;stroke:#789}rect{fill:#eef3f8;stroke:#456}"
        "text{font:13px sans-serif;text-anchor:middle;fill:#123}"
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{lefts[2] + widths[2] + 20}" height="{height}">\n'
        f"<style>{style}</style>\n" + "\n".join(dict.fromkeys([*parts, *boxes])) + "\n</svg>\n"
    )
