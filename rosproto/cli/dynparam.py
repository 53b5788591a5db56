"""`rosproto dynparam`: reconfigure running nodes; the verbs of dynamic_reconfigure's dynparam.

Source: wiki.ros.org/dynamic_reconfigure: a node NAME latches NAME/parameter_descriptions and
NAME/parameter_updates, and serves NAME/set_parameters.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from rosproto.cli.exit_codes import CommandError
from rosproto.cli.graph_clients import absolute, master_client, open_node, unknown
from rosproto.cli.graph_options import add_verbs
from rosproto.cli.options import folder_exists, positive
from rosproto.cli.yaml_values import load_text, to_text, value_of
from rosproto.errors import RosTimeout
from rosproto.files import read_text, write_file
from rosproto.text import printable

if TYPE_CHECKING:
    from rosproto.codec import DynamicMessage
    from rosproto.node import Node

SERVICE = "/set_parameters"
SERVICE_TYPE = "dynamic_reconfigure/Reconfigure"
KINDS = {"bool": bool, "int": int, "str": str, "double": float}
LISTS = {f"{kind}s": cast for kind, cast in KINDS.items()}
"""Lists of dynamic_reconfigure/Config, and what is in them."""
TRUE, FALSE = ("true", "yes", "on", "1", "t"), ("false", "no", "off", "0", "f")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verbs."""
    add_verbs(
        parser,
        {
            "list": (None, _list, "list the nodes that can be reconfigured"),
            "get": (_get_arguments, _get, "print the parameters of a node, or one"),
            "describe": (_node_arguments, _describe, "tell type, range and meaning of its parameters"),
            "set": (_set_arguments, _set, "set a parameter, or several as {name: value}"),
            "dump": (_file_arguments, _dump, "write the parameters of a node to a YAML file"),
            "load": (_file_arguments, _load, "set the parameters of a node from a YAML file"),
        },
    )


def _node_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("node", help="as `rosproto dynparam list` names it")
    parser.add_argument(
        "--timeout", type=positive, default=5.0, metavar="S", help="seconds to wait for its answer (5)"
    )


def _get_arguments(parser: argparse.ArgumentParser) -> None:
    _node_arguments(parser)
    parser.add_argument("parameter", nargs="?", help="only this one")


def _set_arguments(parser: argparse.ArgumentParser) -> None:
    _node_arguments(parser)
    parser.add_argument("values", nargs="+", help="NAME VALUE, or {name: value, ...}")


def _file_arguments(parser: argparse.ArgumentParser) -> None:
    _node_arguments(parser)
    parser.add_argument("file", type=folder_exists, metavar="FILE")


# -- reading ------------------------------------------------------------------------------------------------


def _known(arguments: argparse.Namespace) -> list[str]:
    """Return the names of reconfigurable nodes: those with the service and the descriptions."""
    with master_client(arguments) as master:
        state = master.get_system_state()
    return sorted(
        name.removesuffix(SERVICE)
        for name in state.services
        if name.endswith(SERVICE)
        and name.removesuffix(SERVICE) + "/parameter_descriptions" in state.publishers
    )


def _heard(arguments: argparse.Namespace, node: Node, topic: str, kind: str) -> DynamicMessage:
    """Receive a latched message of the node."""
    from rosproto.codec import message_class

    name = absolute(arguments.node)
    with node.subscriber(f"{name}/{topic}", message_class(f"dynamic_reconfigure/{kind}")) as messages:
        try:
            message: DynamicMessage = messages.next(timeout=arguments.timeout)
            return message
        except RosTimeout as error:
            known = _known(arguments)
            if name in known:
                raise
            raise unknown("nothing can be reconfigured at", name, known, "dynparam list") from error


def values_of(config: DynamicMessage) -> dict[str, object]:
    """Return the values of a dynamic_reconfigure/Config by name, sorted."""
    found = {one.name: cast(one.value) for field, cast in LISTS.items() for one in getattr(config, field)}
    return dict(sorted(found.items()))


def _parameters(description: DynamicMessage) -> Iterator[DynamicMessage]:
    for group in description.groups:
        yield from group.parameters


# -- verbs ---------------------------------------------------------------------------------------------------


def _list(arguments: argparse.Namespace) -> None:
    found = _known(arguments)
    arguments.out.answer(found, map(printable, found))


def _get(arguments: argparse.Namespace) -> None:
    with open_node(arguments) as node:
        values = values_of(_heard(arguments, node, "parameter_updates", "Config"))
    asked: object = values
    if arguments.parameter is not None:
        if arguments.parameter not in values:
            raise unknown(
                "no parameter is called", arguments.parameter, values, f"dynparam get {arguments.node}"
            )
        asked = values[arguments.parameter]
    arguments.out.answer(asked, to_text(asked).rstrip("\n"))


def _describe(arguments: argparse.Namespace) -> None:
    with open_node(arguments) as node:
        description = _heard(arguments, node, "parameter_descriptions", "ConfigDescription")
    low, high, usual = (values_of(part) for part in (description.min, description.max, description.dflt))
    facts = [
        {
            "name": one.name, "type": one.type, "min": low.get(one.name), "max": high.get(one.name),
            "default": usual.get(one.name), "description": one.description, "level": one.level,
        }
        for one in _parameters(description)
    ]  # fmt: skip
    lines = []
    for fact in facts:
        bounds = f", {fact['min']} to {fact['max']}" if fact["type"] in ("int", "double") else ""
        kind = f"{fact['type']}{bounds}, default {fact['default']!r}"
        lines.append(printable(f"{fact['name']} ({kind}): {fact['description']}"))
    arguments.out.answer(facts, lines)


def _set(arguments: argparse.Namespace) -> None:
    words = arguments.values
    if len(words) == 2:
        changes: object = {words[0]: words[1]}
    else:
        changes = value_of(words[0]) if len(words) == 1 else None
    if not isinstance(changes, dict):
        raise ValueError(f"{' '.join(words)!r}: write NAME VALUE, or '{{name: value, ...}}'")
    _change(arguments, changes)


def _change(arguments: argparse.Namespace, changes: Mapping[str, object]) -> None:
    """Set the values and print the result: the node may limit values to their range."""
    from rosproto.codec import message_class, service_class
    from rosproto.codec.dicts import from_dict

    name = absolute(arguments.node)
    with open_node(arguments) as node:
        description = _heard(arguments, node, "parameter_descriptions", "ConfigDescription")
        kinds = {one.name: one.type for one in _parameters(description)}
        request = _config(changes, kinds, arguments.node)
        with node.service_client(name + SERVICE, service_class(SERVICE_TYPE)) as client:
            config = from_dict(message_class("dynamic_reconfigure/Config"), request)
            reply = client.call(config=config, timeout=arguments.timeout)
    after = values_of(reply.config)
    if arguments.json:
        arguments.out.record(after)
        return
    for key, value in changes.items():
        print(f"{key}: {to_text(after.get(key)).rstrip()}")
        if after.get(key) != _cast(kinds[key], value, key):
            print(f"  (instead of {value!r}: the node brings values into its range)")


def _config(
    changes: Mapping[str, object], kinds: Mapping[str, str], node: str
) -> dict[str, list[dict[str, object]]]:
    """Return a dynamic_reconfigure/Config as a dict, with each value in the node's type."""
    config: dict[str, list[dict[str, object]]] = {field: [] for field in LISTS}
    for name, value in changes.items():
        if name not in kinds:
            raise unknown("no parameter is called", name, kinds, f"dynparam describe {node}")
        config[f"{kinds[name]}s"].append({"name": name, "value": _cast(kinds[name], value, name)})
    return config


def _cast(kind: str, value: object, name: str) -> object:
    """Convert a value to the parameter's type.

    Raises:
        ValueError: The value has another type.
    """
    try:
        if kind == "bool":
            word = str(value).lower()
            if word not in (*TRUE, *FALSE):
                raise ValueError
            return word in TRUE
        if kind == "int" and isinstance(value, float) and not value.is_integer():
            raise ValueError
        if kind == "str":
            return str(value)
        return KINDS[kind](value)
    except (ValueError, TypeError, KeyError):
        raise ValueError(f"{name}: {value!r} is not a valid {kind}") from None


def _dump(arguments: argparse.Namespace) -> None:
    with open_node(arguments) as node:
        values = values_of(_heard(arguments, node, "parameter_updates", "Config"))
    write_file(arguments.file, to_text(values).encode())


def _load(arguments: argparse.Namespace) -> None:
    values = load_text(read_text(arguments.file), str(arguments.file))
    if not isinstance(values, dict):
        raise CommandError(
            f"{arguments.file}: expected name: value on each line, as `dynparam dump` writes it"
        )
    values.pop("groups", None)  # group states in dumps of dynamic_reconfigure
    _change(arguments, values)
