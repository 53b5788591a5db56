"""One line of the chassis's interface; the lines are in `woosh_pure.interface`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Kind = Literal["topic", "service", "action"]
Flow = Literal["read", "write", "call", "act"]
Source = Literal["page", "seen", "package"]


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the interface.

    Attributes:
        name: Resolved ROS name.
        type: Message, service or action type, "package/Type".
        kind: "topic", "service" or "action".
        flow: From the user's side: "read" or "write" a topic, "call" a service, "act" through an action.
        meaning: A description, in our words.
        unit: Unit and frame of its numbers; "" without numbers.
        source: "page" (the vendor's page), "seen" (only on a real chassis), or "package" (a type of the
            vendor's message package; its name on the robot is not documented).
        feed: Name of the feed on `Chassis`; "" if it has none.
        providers: Nodes that publish or serve it (for written topics: that subscribe).
        listeners: Nodes of the chassis that subscribe to a read topic, or to the goals of an action, besides
            its providers.
        written_by: Nodes of the chassis that publish a written topic, besides us.
        on_change: True if it is published only on change.
        latched: None if unknown; handle both.
        node_assumed: True if `providers` is an assumption.
        name_assumed: True if the name is not documented: clients find the row by its type, and the simulator
            uses this name.
        definition_known: False if the type's definition is not published: it is learned from the publisher.
        aliases: Other names of the same row, seen on some chassis or on the page.
        bypasses_protection: True for velocity topics, which bypass the chassis's own safety.
        moves_base: True for actions that drive the whole robot, as opposed to a module on it.
    """

    name: str
    type: str
    kind: Kind
    flow: Flow
    meaning: str
    unit: str = ""
    source: Source = "page"
    feed: str = ""
    providers: tuple[str, ...] = ("/mobile_base_nodelet_manager",)
    listeners: tuple[str, ...] = ()
    written_by: tuple[str, ...] = ()
    on_change: bool = False
    latched: bool | None = False
    node_assumed: bool = False
    name_assumed: bool = False
    definition_known: bool = True
    aliases: tuple[str, ...] = ()
    bypasses_protection: bool = False
    moves_base: bool = False
