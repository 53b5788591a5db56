"""`rosproto graph`: nodes and topics as text, Graphviz DOT or a picture.

The picture has curves between three columns if that fits a screen, else a card per node.
"""

from __future__ import annotations

import argparse
import heapq
import sys
from bisect import bisect_left
from collections.abc import Iterable, Sequence
from html import escape
from itertools import accumulate
from typing import TYPE_CHECKING, NamedTuple

from rosproto.cli.graph_clients import absolute, master_client, unknown
from rosproto.cli.graph_options import add_graph_options
from rosproto.cli.pictures import add_picture_options, form_of, quoted, svg_page, write_picture
from rosproto.text import printable

if TYPE_CHECKING:
    from rosproto.node.graph.master_client import SystemState


QUIET = frozenset(("/rosout", "/rosout_agg", "/clock", "/statistics"))


class Edge(NamedTuple):
    """A topic between two nodes; "" for a missing side."""

    publisher: str
    topic: str
    subscriber: str


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options for format, file and omissions."""
    add_graph_options(parser)
    file = "write .svg, .dot or .txt; .png, .pdf by Graphviz"
    add_picture_options(parser, "text, or by the file's name", file)
    parser.add_argument("-a", "--all", action="store_true", help="with /rosout, /clock and the like")
    parser.add_argument("--node", metavar="NAME", help="only what this node is part of")


def run(arguments: argparse.Namespace) -> None:
    """Print or write the graph."""
    form = form_of(arguments.output, arguments.format)
    with master_client(arguments) as master:
        state, types = master.get_system_state(), master.get_topic_types()
    if arguments.node is not None and absolute(arguments.node) not in state.nodes:
        raise unknown("the master knows no node", arguments.node, state.nodes, "node list")
    edges = _edges(state, arguments.all, arguments.node and absolute(arguments.node))
    if arguments.json:
        arguments.out.record([edge._asdict() | {"type": types.get(edge.topic, "*")} for edge in edges])
        return
    shown = _shown(edges)
    writers = {"text": lambda: _text(shown), "dot": lambda: _dot(shown), "svg": lambda: svg(shown)}
    sys.stdout.write(write_picture(arguments.output, form, writers))


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
    """Escape names for a terminal, XML and Graphviz; JSON keeps them unchanged."""
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


def _nodes(edges: Iterable[Edge]) -> list[str]:
    return sorted({name for edge in edges for name in (edge.publisher, edge.subscriber) if name})


TALLEST = 900
"""Pixels; a picture of three columns may be as high, and no higher than it is wide."""
SHAPE = 1.5
"""Width to height that the cards are arranged for: a screen's."""
STYLE = (
    "path{fill:none;stroke:#789}rect{fill:#eef3f8;stroke:#456}"
    "text{font:13px sans-serif;text-anchor:middle;fill:#123}"
    ".card text{font-size:12px;text-anchor:start}.card .head{font-weight:bold}.card .to{fill:#567}"
)
LETTER, ROW, GAP = 7, 17, 16
"""Pixels: of a letter, a row of a card, between two cards."""


def svg(edges: Sequence[Edge]) -> str:
    """Return the picture as SVG."""
    width, height, parts = _columns(edges)
    if height > max(TALLEST, 0) or height > max(width, 400):
        width, height, parts = _cards(edges)
    return svg_page(width, height, STYLE, dict.fromkeys(parts))


def _columns(edges: Sequence[Edge]) -> tuple[int, int, list[str]]:
    """Draw publishers, topics and subscribers in columns, with curves between them."""
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
    return lefts[2] + widths[2] + 20, height, [*parts, *boxes]


class _Card:
    """A publishing node, its topics and their subscribers.

    Attributes:
        lines: (text, style) from the top.
        width, height: Pixels.
    """

    def __init__(self, publisher: str, edges: Sequence[Edge]) -> None:
        topics: dict[str, list[str]] = {}
        for edge in edges:
            topics.setdefault(edge.topic, []).append(edge.subscriber or "(nobody)")
        self.lines = [(publisher or "(nobody publishes)", "head")]
        for subscribers, names in _alike(topics):
            self.lines += [(name, "topic") for name in names]
            self.lines += [(f"    → {subscriber}", "to") for subscriber in subscribers]
        self.width = 24 + LETTER * max(len(text) for text, _ in self.lines)
        self.height = 12 + ROW * len(self.lines)

    def draw(self, x: int, y: int, width: int) -> str:
        rows = [
            f'<text class="{kind}" x="{x + 10}" y="{y + 18 + ROW * i}" xml:space="preserve">'
            f"{escape(text)}</text>"
            for i, (text, kind) in enumerate(self.lines)
        ]
        box = f'<rect x="{x}" y="{y}" width="{width}" height="{self.height}" rx="6"/>'
        return f'<g class="card">{box}{"".join(rows)}</g>'


def _alike(topics: dict[str, list[str]]) -> list[tuple[list[str], list[str]]]:
    """Group topics by subscribers, those without any last: (subscribers, topics)."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for topic, subscribers in sorted(topics.items()):
        groups.setdefault(tuple(sorted(set(subscribers))), []).append(topic)
    found = [(list(subscribers), names) for subscribers, names in groups.items()]
    return sorted(found, key=lambda group: (group[0] == ["(nobody)"], group[1]))


def _cards(edges: Sequence[Edge]) -> tuple[int, int, list[str]]:
    """Arrange cards in columns of a screen shape; the highest first, each in the shortest column."""
    by_node: dict[str, list[Edge]] = {}
    for edge in edges:
        by_node.setdefault(edge.publisher, []).append(edge)
    cards = sorted(
        (_Card(node, found) for node, found in by_node.items()), key=lambda card: (-card.height, card.lines)
    )
    # More columns make it wider: the best number is near the first that makes it wide enough.
    counts = range(1, len(cards) + 1)
    near = bisect_left(counts, SHAPE, key=lambda count: _shape(_arranged(cards, count)))
    tried = counts[max(0, near - _NEAR) : near + _NEAR + 1]
    lefts, widths, tops, places = min((_arranged(cards, count) for count in tried), key=_badness)
    parts = [card.draw(lefts[column], y, widths[column]) for card, column, y in places]
    return lefts[-1] + widths[-1] + GAP, max(tops), parts


_NEAR = 4  # numbers of columns that are tried on both sides
_Arranged = tuple[list[int], list[int], list[int], list[tuple[_Card, int, int]]]


def _arranged(cards: Sequence[_Card], count: int) -> _Arranged:
    """Return left edges, widths and ends of the columns, and (card, column, top)."""
    columns, widths = [(GAP, column) for column in range(count)], [0] * count
    places = []
    for card in cards:
        top, column = columns[0]
        places.append((card, column, top))
        heapq.heapreplace(columns, (top + card.height + GAP, column))
        widths[column] = max(widths[column], card.width)
    lefts = [*accumulate(widths[:-1], lambda left, width: left + width + GAP, initial=GAP)]
    return lefts, widths, [top for top, _ in columns], places


def _shape(arranged: _Arranged) -> float:
    lefts, widths, tops, _ = arranged
    return (lefts[-1] + widths[-1] + GAP) / max(tops)


def _badness(arranged: _Arranged) -> float:
    shape = _shape(arranged)
    return max(shape / SHAPE, SHAPE / shape)
