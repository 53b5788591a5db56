"""`rosproto tf`: the tree of frames, as text and as a picture, who sends it, and transforms in it."""

from __future__ import annotations

import argparse
import math
import time
from typing import Any

from rosproto.errors import RosError, RosTimeout
from rosproto.text import printable

from .connection import CommandError, open_node, print_json, verbs, warn
from .option_types import count, folder_exists, positive, seconds

__all__ = ["add_arguments"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """One verb each."""
    verbs(
        parser,
        {
            "tree": (_tree_arguments, _tree, "listen for a moment and print the tree of frames"),
            "frames": (_frames_arguments, _frames, "draw the tree of frames: SVG, DOT, or PNG by Graphviz"),
            "monitor": (_monitor_arguments, _monitor, "tell who sends each frame, how often and how late"),
            "echo": (_echo_arguments, _echo, "print the transform between two frames, again and again"),
        },
    )


def _tree_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--seconds", type=seconds, default=2.0, metavar="S", help="how long to listen (default: 2)"
    )


def _echo_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("target", help="the frame that coordinates are given in: map")
    parser.add_argument("source", help="the frame whose pose is asked: base_link")
    parser.add_argument("-n", type=count, metavar="COUNT", help="stop after this many")
    parser.add_argument(
        "-r", "--rate", type=positive, default=1.0, metavar="HZ", help="this often a second (default: 1)"
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
    parser.add_argument(
        "--format", choices=("text", "dot", "svg", "png", "pdf"), help="default: by the file's name"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=folder_exists,
        metavar="FILE",
        help="where to (default: frames.svg in this folder)",
    )


def _monitor_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("frame", nargs="*", help="only these; of two frames, the way between them")
    parser.add_argument("-n", type=count, metavar="COUNT", help="stop after this many reports")
    parser.add_argument(
        "--every", type=positive, default=1.0, metavar="S", help="seconds between two reports (1)"
    )


def _frames(arguments: argparse.Namespace) -> int:
    from .tf_frames import draw

    return draw(arguments)


def _monitor(arguments: argparse.Namespace) -> int:
    from .tf_monitor import monitor

    return monitor(arguments)


def _tree(arguments: argparse.Namespace) -> int:
    from rosproto.tf import TransformListener

    with open_node(arguments) as node, TransformListener(node) as listener:
        time.sleep(arguments.seconds)
        frames = listener.buffer.frames()
    if arguments.json:
        print_json(frames)
        return 0
    children: dict[str, list[str]] = {}
    for child, facts in frames.items():
        children.setdefault(str(facts["parent"]), []).append(child)
    roots = sorted(parent for parent in children if parent not in frames)
    if not roots:
        raise CommandError(f"no transform was heard on /tf and /tf_static within {arguments.seconds:g} s")
    for root in roots:
        _print_branch(root, children, frames, "", "")
    return 0


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


def _echo(arguments: argparse.Namespace) -> int:
    from rosproto.tf import TransformListener

    with open_node(arguments) as node, TransformListener(node) as listener:
        listener.buffer.wait(arguments.target, arguments.source, timeout=arguments.timeout)
        shown = 0
        while arguments.n is None or shown < arguments.n:
            if shown:
                time.sleep(1.0 / arguments.rate)
            try:
                _print(listener.buffer.lookup(arguments.target, arguments.source), arguments.json)
            except RosTimeout:
                raise
            except RosError as error:
                warn(str(error))
            shown += 1
    return 0


def _print(transform: Any, as_json: bool) -> None:
    x, y, z = transform.translation
    rotation = [float(v) for v in transform.rotation]
    if as_json:
        print_json({"stamp": transform.stamp.to_sec(), "translation": [x, y, z], "rotation": rotation})
        return
    print(f"At time {transform.stamp.to_sec():.3f}")
    print(f"- Translation: [{x:.3f}, {y:.3f}, {z:.3f}]")
    print(f"- Rotation: in Quaternion [{', '.join(f'{v:.3f}' for v in rotation)}]")
    print(f"            yaw {transform.yaw:.3f} rad, {math.degrees(transform.yaw):.1f}°", flush=True)
