"""`rosproto tf`: the tree of frames as text and picture, its senders and its transforms.

`frames` corresponds to tf's view_frames, `monitor` to tf_monitor.
"""

from __future__ import annotations

import argparse
import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosproto.cli.console import warn
from rosproto.cli.exit_codes import CommandError
from rosproto.cli.graph_clients import open_node
from rosproto.cli.graph_options import add_verbs
from rosproto.cli.options import count, positive, seconds
from rosproto.cli.output import Output
from rosproto.cli.parser import near
from rosproto.cli.pictures import add_picture_options, form_of, quoted, svg_page, write_picture
from rosproto.errors import RosError, RosTimeout
from rosproto.text import printable

if TYPE_CHECKING:
    from rosproto.codec import DynamicMessage
    from rosproto.tf import Transform


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verbs."""
    add_verbs(
        parser,
        {
            "tree": (_tree_arguments, _tree, "listen for a moment and print the tree of frames"),
            "frames": (_frames_arguments, draw, "draw the tree of frames: SVG, DOT, or PNG by Graphviz"),
            "monitor": (_monitor_arguments, monitor, "tell who sends each frame, how often and how late"),
            "echo": (_echo_arguments, _echo, "print the transform between two frames, again and again"),
        },
    )


def _tree_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--seconds", type=seconds, default=2.0, metavar="S", help="how long to listen (default: 2)"
    )


def _echo_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("target", help="the frame that coordinates are given in: map")
    parser.add_argument("source", help="the frame whose pose is wanted: base_link")
    parser.add_argument("-n", type=count, metavar="COUNT", help="stop after this many")
    parser.add_argument(
        "-r", "--rate", type=positive, default=1.0, metavar="HZ", help="reports per second (default: 1)"
    )
    parser.add_argument(
        "--timeout",
        type=positive,
        default=5.0,
        metavar="S",
        help="seconds to wait for the first (default: 5)",
    )


def _frames_arguments(parser: argparse.ArgumentParser) -> None:
    _tree_arguments(parser)
    add_picture_options(parser, "by the file's name", "where to (default: frames.svg in this folder)")


def _monitor_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("frame", nargs="*", help="only these; with two frames, the path between them")
    parser.add_argument("-n", type=count, metavar="COUNT", help="stop after this many reports")
    parser.add_argument(
        "--every", type=positive, default=1.0, metavar="S", help="seconds between two reports (1)"
    )


def _tree(arguments: argparse.Namespace) -> None:
    frames, _ = _heard(arguments)
    if arguments.json:
        arguments.out.record(frames)
        return
    roots, children = _children(frames)
    if not roots:
        raise _silence(arguments.seconds)
    for root in roots:
        _print_branch(root, children, frames, "", "")


def _heard(arguments: argparse.Namespace) -> tuple[Frames, float]:
    """Listen for --seconds; return the frames and the time, s."""
    from rosproto.tf import TransformListener

    with open_node(arguments) as node, TransformListener(node) as listener:
        time.sleep(arguments.seconds)
        return listener.buffer.frames(), node.clock.now().to_sec()


def _silence(seconds: float) -> CommandError:
    return CommandError(f"no transform was heard on /tf and /tf_static within {seconds:g} s")


def _print_branch(
    frame: str, children: dict[str, list[str]], frames: dict[str, dict[str, Any]], head: str, indent: str
) -> None:
    facts = frames.get(frame, {})
    words = ", ".join(f"{key} {_short(value)}" for key, value in facts.items() if key != "parent" and value)
    print(printable(f"{head}{frame}" + (f"  ({words})" if words else "")))
    below = sorted(children.get(frame, []))
    for i, child in enumerate(below):
        last = i == len(below) - 1
        _print_branch(
            child, children, frames, indent + ("└─ " if last else "├─ "), indent + ("   " if last else "│  ")
        )


def _short(value: object) -> str:
    if not isinstance(value, float):
        return str(value)
    return f"{value:.3f}" if abs(value) >= 1000.0 else f"{value:.3g}"


def _echo(arguments: argparse.Namespace) -> None:
    from rosproto.tf import TransformListener

    with open_node(arguments) as node, TransformListener(node) as listener:
        listener.buffer.wait(arguments.target, arguments.source, timeout=arguments.timeout)
        shown = 0
        while arguments.n is None or shown < arguments.n:
            if shown:
                time.sleep(1.0 / arguments.rate)
            try:
                _print(listener.buffer.lookup(arguments.target, arguments.source), arguments.out)
            except RosTimeout:
                raise
            except RosError as error:
                warn(str(error))
            shown += 1


def _print(transform: Transform, out: Output) -> None:
    x, y, z = transform.translation
    rotation = [float(v) for v in transform.rotation]
    if out.as_json:
        out.record({"stamp": transform.stamp.to_sec(), "translation": [x, y, z], "rotation": rotation})
        return
    print(f"At time {transform.stamp.to_sec():.3f}")
    print(f"- Translation: [{x:.3f}, {y:.3f}, {z:.3f}]")
    print(f"- Rotation: in Quaternion [{', '.join(f'{v:.3f}' for v in rotation)}]")
    print(f"            yaw {transform.yaw:.3f} rad, {math.degrees(transform.yaw):.1f}°", flush=True)


Frames = dict[str, dict[str, Any]]
"""As `TransformBuffer.frames()` gives them: child -> facts."""
LETTER, HIGH, APART, BETWEEN = 7, 44, 14, 46
"""Pixels: of a letter, a box, between two boxes above each other, between two generations."""
STYLE = (
    "path{fill:none;stroke:#789;stroke-width:1.5}rect{fill:#eef3f8;stroke:#456}.root{fill:#dfeadf}"
    ".static{stroke-dasharray:5 3}text{font:12px sans-serif;fill:#456}"
    ".name{font-size:13px;font-weight:bold;fill:#123}"
)


def draw(arguments: argparse.Namespace) -> None:
    """Receive transforms, and write the picture."""
    file, asked = arguments.output, arguments.format
    if file is None and asked != "text":
        file = Path(f"frames.{asked or 'svg'}")
    form = form_of(file, asked)
    frames, now = _heard(arguments)
    if not frames:
        raise _silence(arguments.seconds)
    if arguments.json:
        arguments.out.record(frames)
        return
    shown = shown_frames(frames)
    writers = {
        "text": lambda: text_of(shown, now),
        "dot": lambda: dot_of(shown, now),
        "svg": lambda: svg_of(shown, now),
    }
    print(write_picture(file, form, writers) or f"wrote {file}", end="\n" if file else "")


def shown_frames(frames: Frames) -> Frames:
    """Escape names for a terminal, XML and Graphviz."""
    return {
        printable(child): facts
        | {name: printable(str(facts[name])) for name in ("parent", "authority") if facts[name]}
        for child, facts in frames.items()
    }


def facts_of(facts: dict[str, Any], now: float) -> str:
    """Return sender, rate and age of a frame; "fixed" for a static one."""
    sender = facts["authority"] or "an unknown node"
    if facts["static"]:
        return f"{sender}, fixed"
    span = facts["latest"] - facts["earliest"]
    rate = (facts["samples"] - 1) / span if span > 0.0 else 0.0
    often = f"{rate:.1f} Hz" if rate else "once"
    return f"{sender}, {often}, {now - facts['latest']:.2f} s old"


def _children(frames: Frames) -> tuple[list[str], dict[str, list[str]]]:
    children: dict[str, list[str]] = {}
    for child, facts in sorted(frames.items()):
        children.setdefault(str(facts["parent"]), []).append(child)
    return sorted(parent for parent in children if parent not in frames), children


def text_of(frames: Frames, now: float) -> str:
    """Return a line for each frame."""
    lines = [
        f"{child}: in {facts['parent']}; {facts_of(facts, now)}\n" for child, facts in sorted(frames.items())
    ]
    return "".join(lines)


def dot_of(frames: Frames, now: float) -> str:
    """Return DOT with the labels of view_frames."""
    lines = ["digraph G {"]
    for child, facts in sorted(frames.items()):
        label = quoted(facts_of(facts, now)).replace(", ", "\\n")
        lines.append(f"  {quoted(str(facts['parent']))} -> {quoted(child)} [label={label}];")
    return "\n".join([*lines, "}"]) + "\n"


def svg_of(frames: Frames, now: float) -> str:
    """Draw the tree from left to right: a column per level, a box per frame, dashed lines for static ones."""
    roots, children = _children(frames)
    rows: dict[str, float] = {}
    depths: dict[str, int] = {}
    free = 0

    def place(frame: str, depth: int) -> None:
        nonlocal free
        depths[frame] = depth
        for child in children.get(frame, []):
            if child not in depths:  # a loop
                place(child, depth + 1)
        below = [rows[child] for child in children.get(frame, []) if child in rows]
        if below:
            rows[frame] = (min(below) + max(below)) / 2.0
        else:
            rows[frame], free = float(free), free + 1

    for root in roots or sorted(children)[:1]:  # a loop has no root: begin with any frame
        place(root, 0)
    texts = {frame: facts_of(frames[frame], now) if frame in frames else "root" for frame in depths}
    widths = [0] * (max(depths.values()) + 1)
    for frame, depth in depths.items():
        longest = max(len(frame) * 1.15, len(texts[frame]))
        widths[depth] = max(widths[depth], round(24 + LETTER * longest))
    lefts = [16 + sum(widths[:i]) + BETWEEN * i for i in range(len(widths))]
    parts = []
    for frame, depth in depths.items():
        y = 16 + rows[frame] * (HIGH + APART)
        for child in children.get(frame, []):
            x1, x2 = lefts[depth] + widths[depth], lefts[depths[child]]
            y1, y2 = y + HIGH / 2, 16 + rows[child] * (HIGH + APART) + HIGH / 2
            static = ' class="static"' if frames[child]["static"] else ""
            bend = (x1 + x2) / 2
            parts.append(f'<path{static} d="M{x1},{y1:g} C{bend:g},{y1:g} {bend:g},{y2:g} {x2},{y2:g}"/>')
    for frame, depth in depths.items():
        x, y = lefts[depth], 16 + rows[frame] * (HIGH + APART)
        root = ' class="root"' if frame not in frames else ""
        parts.append(f'<rect{root} x="{x}" y="{y:g}" width="{widths[depth]}" height="{HIGH}" rx="6"/>')
        parts.append(f'<text class="name" x="{x + 10}" y="{y + 18:g}">{escape(frame)}</text>')
        parts.append(f'<text x="{x + 10}" y="{y + 35:g}">{escape(texts[frame])}</text>')
    width, height = lefts[-1] + widths[-1] + 16, 32 + free * (HIGH + APART) - APART
    return svg_page(width, height, STYLE, parts)


FIRST = 3.0
"""Seconds of silence after which a warning says so."""


@dataclass
class _Frame:
    parent: str
    sender: str
    static: bool
    count: int = 0
    delays: list[float] = field(default_factory=list)
    first: float = 0.0
    last: float = 0.0


class Arrivals:
    """Statistics of the transforms of each frame. Thread-safe; keeps the last 1000 delays."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._frames: dict[str, _Frame] = {}

    def add(self, message: DynamicMessage, received: float, *, static: bool) -> None:
        """Add a tf2_msgs/TFMessage received at this time, s since 1970 (or simulated)."""
        sender = (message._connection_header or {}).get("callerid", "")
        with self._lock:
            for transform in message.transforms:
                child = transform.child_frame_id.lstrip("/")
                parent = transform.header.frame_id.lstrip("/")
                one = self._frames.setdefault(child, _Frame(parent, sender, static, first=received))
                one.parent, one.sender, one.static = parent, sender, static
                one.count, one.last = one.count + 1, received
                one.delays.append(received - transform.header.stamp.to_sec())
                del one.delays[:-1000]

    def facts(self, asked: list[str]) -> list[dict[str, Any]]:
        """Return a row per frame, sorted; for two given frames, those between them.

        Raises:
            CommandError: A frame is unknown.
        """
        with self._lock:
            frames = dict(self._frames)
            wanted = self._wanted(asked, frames)
            return [
                {
                    "frame": child,
                    "parent": one.parent,
                    "sender": one.sender,
                    "static": one.static,
                    "count": one.count,
                    "rate": (one.count - 1) / (one.last - one.first) if one.last > one.first else None,
                    "average_delay": None if one.static else sum(one.delays) / len(one.delays),
                    "max_delay": None if one.static else max(one.delays),
                }
                for child, one in sorted(frames.items())
                if child in wanted
            ]

    @staticmethod
    def _wanted(asked: list[str], frames: dict[str, _Frame]) -> set[str]:
        if not asked:
            return set(frames)
        ways = []
        for name in asked:
            frame, way = name.lstrip("/"), set()
            known = {*frames, *(one.parent for one in frames.values())}
            if frame not in known:
                raise CommandError(f"no transform of frame {name!r} has been received{near(frame, known)}")
            while frame in frames and frame not in way:
                way.add(frame)
                frame = frames[frame].parent
            ways.append(way)
        shared = set.intersection(*ways) if len(ways) > 1 else set()
        return set.union(*ways) - shared if len(ways) > 1 else ways[0]


def monitor(arguments: argparse.Namespace) -> None:
    """Print a report every second until interrupted, or -n reports."""
    from rosproto.codec import message_class

    arrivals = Arrivals()
    with open_node(arguments) as node:
        clock = node.clock

        def take(static: bool) -> Callable[[DynamicMessage], None]:
            return lambda message: arrivals.add(message, clock.now().to_sec(), static=static)

        ours = message_class("tf2_msgs/TFMessage")
        node.subscriber("/tf", ours, take(False), queue_size=1000)
        node.subscriber("/tf_static", ours, take(True), queue_size=1000)
        reports, silent = 0, 0.0
        while arguments.n is None or reports < arguments.n:
            time.sleep(arguments.every)
            facts = arrivals.facts([])
            if not facts:
                silent += arguments.every
                if silent >= FIRST:
                    if arguments.n is not None:
                        raise _silence(silent)
                    warn("nothing is received on /tf and /tf_static; still listening, Ctrl-C ends it")
                    silent = float("-inf")
                continue
            facts = arrivals.facts(arguments.frame)
            reports += 1
            arguments.out.answer(facts, report(facts))


def report(facts: list[dict[str, Any]]) -> str:
    """Return a table of the frames and one of their sending nodes."""
    rows: list[tuple[str, ...]] = [("frame", "parent", "sent by", "rate", "average delay", "max delay")]
    for one in facts:
        rate = "fixed" if one["static"] else "once" if one["rate"] is None else f"{one['rate']:.2f} Hz"
        delays = ["" if one[key] is None else f"{one[key]:.4f} s" for key in ("average_delay", "max_delay")]
        frame, parent, sender = (printable(str(one[key])) for key in ("frame", "parent", "sender"))
        rows.append((frame, parent, sender or "?", rate, *delays))
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    lines = [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    ]
    for sender in sorted({one["sender"] for one in facts if not one["static"]}):
        sent = [one for one in facts if one["sender"] == sender and not one["static"]]
        together = sum(one["rate"] or 0.0 for one in sent)
        late = max(one["max_delay"] for one in sent)
        lines.append(f"{printable(sender) or '?'}: {together:.2f} transforms/s, at most {late:.4f} s late")
    return "\n".join(lines) + "\n"
