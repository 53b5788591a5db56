"""`rosproto service`: list, info, node, type, find, uri, args, call; output as of rosservice."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from rosproto.cli.console import is_terminal, warn
from rosproto.cli.exit_codes import CommandError
from rosproto.cli.graph_clients import (
    CALLER_ID,
    TIMEOUT,
    absolute,
    below,
    master_client,
    open_node,
    unknown,
    warn_if_none,
)
from rosproto.cli.graph_options import add_verbs, host_names, library_for
from rosproto.cli.options import argument, positive
from rosproto.cli.parser import near
from rosproto.cli.yaml_values import fields_of, load_documents, to_flow
from rosproto.errors import DefinitionError, MasterError, RosError, RosTimeout
from rosproto.text import printable

if TYPE_CHECKING:
    from rosproto.codec import Message
    from rosproto.node import Node
    from rosproto.node.graph.master_client import MasterClient


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verbs."""
    add_verbs(
        parser,
        {
            "list": (_list_arguments, _list, "list the services of the graph"),
            "info": (argument("service"), _info, "tell who provides a service, where, and of what type"),
            "node": (argument("service"), _node, "print the node that provides a service"),
            "type": (argument("service"), _type, "print the type of a service"),
            "find": (argument("type", help="package/Type"), _find, "list the services of a type"),
            "uri": (argument("service"), _uri, "print the address of a service"),
            "args": (argument("service"), _args, "print the fields of its request"),
            "call": (_call_arguments, _call, "call a service and print its response"),
        },
    )


def _list_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("namespace", nargs="?", default="")
    parser.add_argument("-n", "--nodes", action="store_true", help="print the node beside each")


def _call_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("service")
    parser.add_argument(
        "values",
        nargs="*",
        default=[],
        help="the request: {field: value}, or its fields in order; now and auto for times, a whole number is "
        "in nanoseconds; without any, and not on a "
        "terminal, requests are read from standard input",
    )
    parser.add_argument("--type", help="package/Type, if the service does not report it")
    parser.add_argument(
        "--timeout", type=positive, default=10.0, metavar="S", help="seconds for the call (10)"
    )
    parser.add_argument("--wait", action="store_true", help="wait for the service to come up first")


def _look_up(master: MasterClient, name: str) -> str:
    try:
        return master.lookup_service(name)
    except MasterError as error:
        services = master.get_system_state().services
        raise unknown("no node provides the service", name, services, "service list") from error


def type_of(arguments: argparse.Namespace, name: str) -> str:
    """Return the type from the provider (a probe): the master does not know it."""
    from rosproto.node.services.link import ServiceLink
    from rosproto.protocol.handshake import service_client_header
    from rosproto.protocol.wire_limits import Limits
    from rosproto.transport.deadline import Deadline
    from rosproto.transport.uri import parse_uri

    with master_client(arguments) as master:
        address = parse_uri(_look_up(master, name))
    fields = service_client_header(service=name, md5sum="*", callerid=CALLER_ID, probe=True)
    link = ServiceLink.open(
        address,
        fields,
        service=name,
        limits=Limits(),
        deadline=Deadline(TIMEOUT),
        hosts=host_names(arguments),
    )
    link.close()
    return printable(link.header.get("type", ""))


def _list(arguments: argparse.Namespace) -> None:
    with master_client(arguments) as master:
        known = master.get_system_state().services
    services = {name: known[name] for name in below(known, arguments.namespace)}
    warn_if_none(services, "service", arguments.namespace, known)
    lines = [f"{name} {','.join(nodes)}" if arguments.nodes else name for name, nodes in services.items()]
    arguments.out.answer([{"name": name, "nodes": nodes} for name, nodes in services.items()], lines)


def _info(arguments: argparse.Namespace) -> None:
    name = absolute(arguments.service)
    with master_client(arguments) as master:
        uri = _look_up(master, name)
        nodes = master.get_system_state().services.get(name, [])
    kind = type_of(arguments, name)
    try:
        fields: list[str] | None = _fields(arguments, kind)
    except (DefinitionError, ValueError):
        fields = None
    facts = {"node": ", ".join(nodes), "uri": uri, "type": kind, "args": fields}
    args = "(unknown type)" if fields is None else " ".join(fields)
    arguments.out.answer(facts, f"Node: {facts['node']}\nURI: {uri}\nType: {kind}\nArgs: {args}")


def _node(arguments: argparse.Namespace) -> None:
    name = absolute(arguments.service)
    with master_client(arguments) as master:
        services = master.get_system_state().services
    if not services.get(name):
        raise unknown("no node provides the service", name, services, "service list")
    arguments.out.answer(services[name], services[name])


def _fields(arguments: argparse.Namespace, kind: str) -> list[str]:
    from rosproto.codec import service_class

    return list(service_class(kind, library_for(arguments, kind, "srv")).Request.__slots__)


def _type(arguments: argparse.Namespace) -> None:
    kind = type_of(arguments, absolute(arguments.service))
    arguments.out.answer(kind, kind)


def _find(arguments: argparse.Namespace) -> None:
    with master_client(arguments) as master:
        names = sorted(master.get_system_state().services)
    types = {name: _safe_type(arguments, name) for name in names}
    found = [name for name, kind in types.items() if kind == arguments.type]
    if not found and not arguments.json:
        warn(f"no service is of type {arguments.type}{near(arguments.type, set(types.values()))}")
    arguments.out.answer(found, found)


def _safe_type(arguments: argparse.Namespace, name: str) -> str:
    try:
        return type_of(arguments, name)
    except RosError:
        return ""  # skip a provider that has gone


def _uri(arguments: argparse.Namespace) -> None:
    with master_client(arguments) as master:
        uri = _look_up(master, absolute(arguments.service))
    arguments.out.answer(uri, uri)


def _args(arguments: argparse.Namespace) -> None:
    fields = _fields(arguments, type_of(arguments, absolute(arguments.service)))
    arguments.out.answer(fields, " ".join(fields))


def _call(arguments: argparse.Namespace) -> None:
    from rosproto.codec import service_class
    from rosproto.codec.dicts import from_dict, to_dict

    name = absolute(arguments.service)
    with open_node(arguments) as node:
        if arguments.wait:
            _wait(node, name, arguments.timeout)
        kind = arguments.type or type_of(arguments, name)
        cls = service_class(kind, library_for(arguments, kind, "srv"))
        wanted = _requests(arguments, cls.Request)
        for values in wanted:
            from_dict(cls.Request, values, now=node.clock.now())  # refuse wrong values before the first call
        with node.service_client(name, cls) as client:
            for index, values in enumerate(wanted):
                request = from_dict(cls.Request, values, now=node.clock.now())
                response = client.call(request, timeout=arguments.timeout)
                if arguments.json:
                    arguments.out.record(to_dict(response, finite=True))
                else:
                    print(f"---\n{response}" if index else response, flush=True)


def _wait(node: Node, name: str, timeout: float) -> None:
    try:
        node.wait_for_service(name, timeout=timeout)
    except RosTimeout:
        raise CommandError(
            f"no node provided {name} within {timeout:g} s; see: rosproto service list"
        ) from None


def _requests(arguments: argparse.Namespace, cls: type[Message]) -> list[object]:
    """Return the request of the command line, or those of standard input.

    Raises:
        ValueError: The request has fields, but no values are given.
    """
    if not cls.__slots__:
        return [fields_of(arguments.values, cls)]
    if arguments.values:
        found = [fields_of(arguments.values, cls)]
    elif sys.stdin is None or is_terminal(sys.stdin):
        found = []
    else:
        found = list(load_documents(sys.stdin, "standard input"))
    if not found or None in found:
        raise ValueError(_ask_for_fields(arguments.service, cls))
    return found


def _ask_for_fields(service: str, cls: type[Message]) -> str:
    """Return the error of missing fields, with an example line for any shell."""
    from rosproto.codec.dicts import to_dict

    fields = ", ".join(f"{name} ({kind})" for name, kind in zip(cls.__slots__, cls._slot_types, strict=True))
    template = to_flow(to_dict(cls(), finite=True)).replace('"', '\\"')
    return (
        f"the request of {service} has fields, and no values were given: {fields}; nothing was called. "
        f'To copy: rosproto service call {service} "{template}"'
    )
