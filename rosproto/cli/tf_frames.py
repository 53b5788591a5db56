"""`rosproto tf frames`: the tree of frames as a picture, with who sends each, how often, and how old it is.

What tf's view_frames shows, without a PDF reader: the SVG is laid out here.
"""

from __future__ import annotations

import argparse
import time
from html import escape
from pathlib import Path
from typing import Any

from rosproto.text import printable

from .connection import CommandError, open_node, print_json
from .pictures import form_of, write_picture

__all__ = ["draw"]

Frames = dict[str, dict[str, Any]]
"""As `TransformBuffer.frames()` gives them: child -> facts."""
LETTER, HIGH, APART, BETWEEN = 7, 44, 14, 46
"""Pixels: of a letter, a box, between two boxes above each other, between two generations."""
STYLE = (
    "path{fill:none;stroke:#789;stroke-width:1.5}rect{fill:#eef3f8;stroke:#456}.root{fill:#dfeadf}"
    ".static{stroke-dasharray:5 3}.page{fill:#fff;stroke:none}text{font:12px sans-serif;fill:#456}"
    ".name{font-size:13px;font-weight:bold;fill:#123}"
)


def draw(arguments: argparse.Namespace) -> int:
    """Listen, and write the picture."""
    from rosproto.tf import TransformListener

    file, asked = arguments.output, arguments.format
    if file is None and asked != "text":
        file = Path(f"frames.{asked or 'svg'}")
    form = form_of(file, asked)
    with open_node(arguments) as node, TransformListener(node) as listener:
        time.sleep(arguments.seconds)
        frames, now = listener.buffer.frames(), node.clock.now().to_sec()
    if not frames:
        raise CommandError(f"no transform was heard on /tf and /tf_static within {arguments.seconds:g} s")
    if arguments.json:
        print_json(frames)
        return 0
    shown = shown_frames(frames)
    writers = {
        "text": lambda: text_of(shown, now),
        "dot": lambda: dot_of(shown, now),
        "svg": lambda: svg_of(shown, now),
    }
    print(write_picture(file, form, writers) or f"wrote {file}", end="\n" if file else "")
    return 0


def shown_frames(frames: Frames) -> Frames:
    """With names as a terminal, an XML reader and Graphviz can take them: who sends frames names them."""
    return {
        printable(child): facts
        | {name: printable(str(facts[name])) for name in ("parent", "authority") if facts[name]}
        for child, facts in frames.items()
    }


def facts_of(facts: dict[str, Any], now: float) -> str:
    """Who sends a frame, how often, how old the newest is; "fixed" for one that holds for ever."""
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
    roots = sorted(parent for parent in children if parent not in frames)
    return roots or sorted(children)[:1], children  # a loop has no root: begin anywhere


def text_of(frames: Frames, now: float) -> str:
    """A line for each frame."""
    lines = [
        f"{child}: in {facts['parent']}; {facts_of(facts, now)}\n" for child, facts in sorted(frames.items())
    ]
    return "".join(lines)


def dot_of(frames: Frames, now: float) -> str:
    """For Graphviz, with the labels of view_frames."""
    from .graph import quoted

    lines = ["digraph G {"]
    for child, facts in sorted(frames.items()):
        label = quoted(facts_of(facts, now)).replace(", ", "\\n")
        lines.append(f"  {quoted(str(facts['parent']))} -> {quoted(child)} [label={label}];")
    return "\n".join([*lines, "}"]) + "\n"


def svg_of(frames: Frames, now: float) -> str:
    """The tree from left to right: a generation a column, a frame a box, fixed ones with a dashed line."""
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

    for root in roots:
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
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        f'viewBox="0 0 {width} {height}">\n<style>{STYLE}</style>\n'
        f'<rect class="page" width="{width}" height="{height}"/>\n' + "\n".join(parts) + "\n</svg>\n"
    )
