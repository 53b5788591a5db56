"""Names of nodes, topics, services and parameters: checking, resolving, remapping.

Source: wiki.ros.org/Names and wiki.ros.org/Remapping%20Arguments; rosgraph/names.py where they are silent.
Unlike rosgraph's expressions, which accept Unicode letters and a line feed at the end, legal names are ASCII.

Graphs contain illegal names as well: rosmaster accepts nearly everything, rospy warns (`/camera-1/image`),
and only roscpp refuses. The rule is: a program's own name must be legal, so that a mistake is seen where it
is made; names of others (topics, services, parameters, namespaces) need only be usable, so that everything in
a graph can be reached. `resolve` accepts what a master accepts. Only the rospy layer gives a node any name,
as rospy does (`Node(any_name=True)`).
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from rosproto.sentence import both, led, say

__all__ = [
    "Arguments",
    "anonymous_name",
    "canonicalize",
    "is_legal_base_name",
    "is_legal_name",
    "is_usable_name",
    "join",
    "namespace",
    "package_resource",
    "parse_arguments",
    "resolve",
    "resolve_remappings",
]

ASSIGN = ":="


def is_legal_base_name(name: str) -> bool:
    """True for a name without namespace: an ASCII letter, then letters, digits, `_`; as a node's name."""
    return name.isidentifier() and name.isascii() and name[0] != "_"


def is_legal_name(name: str) -> bool:
    """True for a global ("/a/b"), relative ("a/b") or private ("~a") name; "" and "/" are legal (rosgraph).

    The first character is a letter, `/` or `~`; the others are letters, digits, `_` and `/`, never `//`.
    """
    if not name:
        return True
    rest = name[1:].replace("/", "").replace("_", "")
    return (
        name.isascii()
        and (name[0] in "~/" or name[0].isalpha())
        and (not rest or rest.isalnum())
        and "//" not in name
    )


def is_usable_name(name: str) -> bool:
    """True for a name that a master accepts, legal or not: not empty, without space, `:` and control
    characters.
    """
    return bool(name) and name.isprintable() and " " not in name and ":" not in name


def canonicalize(name: str) -> str:
    """The name with `//` collapsed and without a slash at its end; "/" stays."""
    if "//" not in name and (name == "/" or not name.endswith("/")):
        return name
    parts = [part for part in name.split("/") if part]
    return ("/" if name.startswith("/") else "") + "/".join(parts)


def namespace(name: str) -> str:
    """The namespace that a name is in, with a slash at its end: "/ns/" of "/ns/node", "/" of "/node"."""
    name = name.removesuffix("/")
    return name[: name.rfind("/") + 1] or "/"


def join(ns: str, name: str) -> str:
    """The name in a namespace; a global or private name is left as it is."""
    if not ns or name.startswith(("/", "~")):
        return name
    if ns == "~" or ns.endswith("/"):
        return ns + name
    return f"{ns}/{name}"


def resolve(name: str, node_name: str, remappings: Mapping[str, str] | None = None) -> str:
    """The global name that `name` means for a node.

    Args:
        name: "/global", "relative" (to the node's namespace) or "~private" (below the node's own name).
        node_name: Global name of the node, "/ns/node".
        remappings: Resolved name -> resolved name, from `resolve_remappings`; applied once, to the result.

    Raises:
        ValueError: No master would take the name (`is_usable_name`), or the node's name is not global.
    """
    if not is_usable_name(name):
        expected = "expected an ASCII letter, `/` or `~`, then letters, digits, `_` or `/`"
        raise ValueError(both(say("{name!r} is not a ROS name", name=name), expected))
    if not node_name.startswith("/"):
        raise ValueError(f"node name {node_name!r} is not global; expected it resolved, as in '/ns/node'")
    if name[0] == "/":
        resolved = name
    elif name[0] == "~":
        resolved = f"{node_name}/{name[1:]}"
    else:
        resolved = namespace(canonicalize(node_name)) + name
    resolved = canonicalize(resolved)
    return remappings.get(resolved, resolved) if remappings else resolved


def resolve_remappings(remappings: Mapping[str, str], node_name: str) -> dict[str, str]:
    """Resolve both sides of `name:=other` for a node, for use with `resolve`.

    Raises:
        ValueError: One side is not a legal name.
    """
    return {resolve(name, node_name): resolve(other, node_name) for name, other in remappings.items()}


def anonymous_name(prefix: str) -> str:
    """A unique name: prefix, host, process and a random number, as rospy and roscpp make them.

    A master shuts down the older of two nodes with the same name.
    """
    import random
    from platform import node as host_name

    host = "".join(c if c.isascii() and (c.isalnum() or c == "_") else "_" for c in host_name())
    return f"{prefix}_{host or 'host'}_{os.getpid()}_{random.SystemRandom().randrange(1 << 53)}"


def package_resource(name: str) -> tuple[str, str]:
    """Package and name: ("std_msgs", "String") of "std_msgs/String", ("", "String") of "String".

    Raises:
        ValueError: There is more than one slash.
    """
    package, slash, base = name.partition("/")
    if not slash:
        return "", name
    if "/" in base:
        raise ValueError(f"{name!r} is not a resource name; expected 'package/Name' with one slash")
    return package, base


class Arguments(NamedTuple):
    """A parsed command line.

    Attributes:
        remappings: `name:=other`, both as written; make them global with `resolve_remappings`.
        parameters: `_name:=value`, keyed as the private name they set ("~name"), the value typed as YAML.
        specials: `__name:=...`, `__ns`, `__log`, `__master`, `__hostname`, `__ip`, keyed as written.
        rest: Everything else, in order.
    """

    remappings: dict[str, str]
    parameters: dict[str, object]
    specials: dict[str, str]
    rest: list[str]


def parse_arguments(argv: Iterable[str]) -> Arguments:
    """Sort a command line into remappings, private parameters, special keys and the rest.

    An argument with `:=` but an empty name stays in the rest, so that the program's own parser reports it.
    The same holds for a remapping to nothing. A parameter may be empty: it is the empty text.

    Raises:
        ValueError: A parameter's value is not closed, as in `_gains:=[1, 2`.
    """
    found = Arguments({}, {}, {}, [])
    for argument in argv:
        name, assign, value = (part.strip() for part in argument.partition(ASSIGN))
        if name.startswith("__") and len(name) > 2 and assign:
            found.specials[name] = value
        elif name.startswith("_") and len(name) > 1 and assign:
            found.parameters["~" + name[1:]] = _parameter(argument, value)
        elif name and assign and value:
            found.remappings[name] = value
        else:
            found.rest.append(argument)
    return found


def _parameter(argument: str, value: str) -> object:
    from rosproto.typed_values import parse_value

    try:
        return parse_value(value) if value else ""
    except ValueError as error:
        raise ValueError(led(say("argument {text!r}", text=argument[:80]), str(error))) from None
