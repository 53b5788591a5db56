"""`rosproto tf monitor`: who sends each frame, how often, and how late it comes (tf's tf_monitor)."""

from __future__ import annotations

import argparse
import threading
import time
from dataclasses import dataclass, field
from typing import Any

from rosproto.text import printable

from .connection import CommandError, open_node, print_json, warn
from .parser import near

__all__ = ["Arrivals", "monitor"]

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
    """What has come of each frame. Any thread adds; delays are kept for the last `keep` transforms."""

    def __init__(self, keep: int = 1000) -> None:
        self._keep = keep
        self._lock = threading.Lock()
        self._frames: dict[str, _Frame] = {}

    def add(self, message: Any, received: float, *, static: bool) -> None:
        """Take a tf2_msgs/TFMessage that came at this time, s since 1970 (or simulated)."""
        sender = (message._connection_header or {}).get("callerid", "")
        with self._lock:
            for transform in message.transforms:
                child = transform.child_frame_id.lstrip("/")
                parent = transform.header.frame_id.lstrip("/")
                one = self._frames.setdefault(child, _Frame(parent, sender, static, first=received))
                one.parent, one.sender, one.static = parent, sender, static
                one.count, one.last = one.count + 1, received
                one.delays.append(received - transform.header.stamp.to_sec())
                del one.delays[: -self._keep]

    def facts(self, asked: list[str]) -> list[dict[str, Any]]:
        """A row for each frame, sorted; of two frames that were asked for, those on the way between them.

        Raises:
            CommandError: A frame is not known.
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
                raise CommandError(f"no transform of frame {name!r} has come{near(frame, known)}")
            while frame in frames and frame not in way:
                way.add(frame)
                frame = frames[frame].parent
            ways.append(way)
        shared = set.intersection(*ways) if len(ways) > 1 else set()
        return set.union(*ways) - shared if len(ways) > 1 else ways[0]


def monitor(arguments: argparse.Namespace) -> int:
    """A report every second until interrupted, or -n of them."""
    from rosproto.codec import message_class

    arrivals = Arrivals()
    with open_node(arguments) as node:
        clock = node.clock

        def take(static: bool) -> Any:
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
                        raise CommandError(
                            f"no transform was heard on /tf and /tf_static within {silent:g} s"
                        )
                    warn("nothing comes on /tf and /tf_static; still listening, Ctrl-C ends it")
                    silent = float("-inf")
                continue
            facts = arrivals.facts(arguments.frame)
            reports += 1
            print_json(facts) if arguments.json else print(report(facts), flush=True)
    return 0


def report(facts: list[dict[str, Any]]) -> str:
    """A table of the frames, and one of the nodes that send them."""
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
