"""All kinds of the comparison, with the processes they need."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from rosproto.master import Master
from rosproto.node import Node
from tests.interop.compare.bags import BagCompress, BagFilter, BagFix, BagInfo, BagPlay, BagRead, BagReindex
from tests.interop.compare.comparison import Kind, Report, compare, debian, layer
from tests.interop.compare.definitions import Definition, DefinitionByLayer, FullText, FullTextByLayer
from tests.interop.compare.differences import DIFFERENCES
from tests.interop.compare.links import (
    ECHO_SECONDS,
    FromPublisher,
    FromService,
    LiveEcho,
    LivePub,
    ToPublisher,
    ToService,
)
from tests.interop.compare.parameters import RosparamCommand, RosparamFunctions
from tests.interop.compare.values import (
    PUBLISHED,
    REPLIES,
    Cloud,
    Handed,
    RosserviceCall,
    RostopicEcho,
    Values,
    ValuesByLayer,
)
from tests.support import ros

NAMES = [
    "RosparamCommand", "RosparamFunctions", "Definition", "DefinitionByLayer", "FullText", "FullTextByLayer", "Values",
    "ValuesByLayer", "RosserviceCall", "RostopicEcho", "Reply", "Publish", "Cloud",
    "BagRead", "BagInfo", "BagFilter", "BagReindex", "BagFix", "BagCompress", "BagPlay",
    "ToPublisher", "ToService", "FromService", "FromPublisher", "LiveEcho", "LivePub",
]  # fmt: skip


def run(
    *,
    seed: int,
    seconds: float,
    only: Sequence[str] | None = None,
    enough: int = 10,
    first: int = 0,
    rounds: int = 10**9,
    packages: Path | None = None,
) -> Report:
    """Compare until the rounds or the time are over; see `compare`.

    Args:
        packages: Python packages of message types for Debian's ROS, made by genpy; None makes them first.
    """
    with ExitStack() as stack:
        if packages is None:
            packages = ros.generate_python_packages(Path(stack.enter_context(tempfile.TemporaryDirectory())))
        theirs, ours, our_layers = (stack.enter_context(Master()) for _ in range(3))
        real = stack.enter_context(debian(theirs.uri, packages))
        rosparam = stack.enter_context(debian(theirs.uri, packages))
        of_layer = stack.enter_context(layer(our_layers.uri))
        services = stack.enter_context(Node("/services", master_uri=theirs.uri))
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        kinds: list[Kind] = [
            RosparamCommand(ours.uri, rosparam),
            RosparamFunctions(of_layer, rosparam),
            Definition(),
            DefinitionByLayer(of_layer),
            FullText(),
            FullTextByLayer(of_layer),
            Values(),
            ValuesByLayer(of_layer),
            RosserviceCall(services),
            RostopicEcho(folder),
            Handed(of_layer, "reply", REPLIES),
            Handed(of_layer, "publish", PUBLISHED),
            Cloud(of_layer),
            *(
                kind(folder, of_layer)
                for kind in (BagRead, BagInfo, BagFilter, BagReindex, BagFix, BagCompress)
            ),
        ]
        kinds.append(BagPlay(folder, of_layer, services))
        nodes = (
            stack.enter_context(debian(theirs.uri, packages)),
            theirs.uri,
            stack.enter_context(layer(our_layers.uri)),
            our_layers.uri,
        )
        links = [kind(*nodes) for kind in (ToPublisher, ToService, FromService, FromPublisher)]
        for link in links:
            stack.callback(link.close)
        kinds += links
        # `rostopic echo` and `pub` begin their node in different ways: each has a process.
        echo, pub = (stack.enter_context(debian(theirs.uri, packages, ECHO_SECONDS)) for _ in range(2))
        kinds += [LiveEcho(folder, services, echo), LivePub(services, pub)]
        assert [kind.name for kind in kinds] == NAMES
        chosen = [kind for kind in kinds if not only or kind.name in only]
        return compare(
            chosen, DIFFERENCES, real, seed=seed, seconds=seconds, enough=enough, first=first, rounds=rounds
        )
