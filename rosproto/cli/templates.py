"""What a message of a type looks like on a command line, for completion: every field with its default."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from typing import Any

from rosproto.errors import RosError

__all__ = ["template", "template_of"]


def template(cls: Any) -> str:
    """`{header: {seq: 0, stamp: now, frame_id: ""}, x: 0.0}`: YAML in one line, without single quotes.

    Args:
        cls: A message class.
    """
    from rosproto.codec.dicts import to_dict

    return _flow(to_dict(cls()), cls)


def _flow(value: Any, cls: Any = None) -> str:
    if isinstance(value, dict):
        kinds = dict(zip(cls.__slots__, cls._slot_types, strict=True)) if cls else {}
        stamped = getattr(cls, "_type", "") == "std_msgs/Header"
        parts = []
        for name, item in value.items():
            if stamped and name == "stamp":
                parts.append("stamp: now")
            else:
                parts.append(f"{name}: {_flow(item, _class_of(kinds.get(name, '')))}")
        return "{" + ", ".join(parts) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_flow(item) for item in value) + "]"
    return json.dumps(value)


def _class_of(kind: str) -> Any:
    from rosproto.codec import message_class

    if kind == "Header":
        kind = "std_msgs/Header"
    return message_class(kind) if "/" in kind and "[" not in kind else None


def template_of(words: Sequence[str], given: Mapping[str, Sequence[str]]) -> list[str]:
    """For `topic pub TOPIC TYPE` and `service call NAME`: the template, or nothing.

    Args:
        words: The command line so far.
        given: Its positional arguments.
    """
    from rosproto.codec import message_class, service_class

    from .connection import absolute, add_graph_options, library_for
    from .service import type_of

    parser = argparse.ArgumentParser(add_help=False)
    add_graph_options(parser)
    options = parser.parse_known_args(list(words))[0]
    try:
        if "type" in given:
            kind = given["type"][0]
            return [template(message_class(kind, library_for(options, kind)))]
        if "service" in given:
            kind = type_of(options, absolute(given["service"][0]))
            request = service_class(kind, library_for(options, kind, "srv")).Request
            return [template(request)] if request.__slots__ else []
    except (RosError, ValueError):
        pass  # nobody knows the type, or nobody answers: nothing to offer
    return []
