"""Look up topics, services and actions of the chassis in the one table that everything else reads.

The rows, with their sources, are in `rows`; here they are looked up.
"""

from __future__ import annotations

from rosproto.sentence import say
from rosproto.text import near_names
from woosh_pure.interface.rows import ROWS
from woosh_pure.interface.schema import Flow, Row

PAGE_ALIASES: dict[str, dict[str, str]] = {
    "woosh_msgs/ExecTask": {"task_exec": "task_exect", "statuscode": "statusCode"},
    "woosh_msgs/StepControlGoal": {"StepControl": "stepControl"},
}
"""Field names as the vendor's page spells them -> as they are on the wire."""

ROBOT_NODES = frozenset(
    node for each in ROWS for node in (*each.providers, *each.listeners, *each.written_by)
)
"""Names of the chassis's own nodes, as far as they are known: what they do is the robot's own doing."""

_BY_NAME = {name: r for r in ROWS for name in (r.name, *r.aliases)}
_BY_FEED = {r.feed: r for r in ROWS if r.feed}


def row(name: str) -> Row:
    """The row of a topic, service or action (or an alias of it).

    Raises:
        KeyError: It is not part of the interface; the message lists near names.
    """
    try:
        return _BY_NAME["/" + name.lstrip("/")]
    except KeyError:
        near = ", ".join(near_names("/" + name.lstrip("/"), _BY_NAME)) or say("none is near")
        raise KeyError(
            say("{name} is not in the chassis's interface; near names: {near}", name=name, near=near)
        ) from None


def find(feed: str) -> Row:
    """The row behind a feed of `Chassis`.

    Raises:
        KeyError: There is no such feed; the message lists near names.
    """
    try:
        return _BY_FEED[feed]
    except KeyError:
        topic = _BY_NAME.get("/" + feed)
        if topic is not None and topic.flow == "read":
            wrong = "{feed} is not a feed of the chassis, but {name} is a topic of it: add the slash"
            raise KeyError(say(wrong, feed=feed, name=topic.name)) from None
        readable = [name for name, one in _BY_NAME.items() if one.flow == "read"]
        near = [*near_names(feed, _BY_FEED), *near_names("/" + feed, readable)]
        wrong = "{feed} is not a feed of the chassis; near names: {near}"
        raise KeyError(say(wrong, feed=feed, near=near or say("none is near"))) from None


def topics(flow: Flow | None = None) -> tuple[Row, ...]:
    """Topic rows, all or of one flow."""
    return tuple(r for r in ROWS if r.kind == "topic" and flow in (None, r.flow))


def services() -> tuple[Row, ...]:
    """Service rows."""
    return tuple(r for r in ROWS if r.kind == "service")


def actions() -> tuple[Row, ...]:
    """Action rows."""
    return tuple(r for r in ROWS if r.kind == "action")


def driving_patterns() -> tuple[str, ...]:
    """What drives the robot, as patterns for a gateway (`rosproto.gateway.Access(write=...)`): the topics of
    velocities, and the actions that move the whole robot.
    """
    rows = [r for r in ROWS if r.bypasses_protection or r.moves_base]
    return tuple(f"{r.kind}:{name}" for r in rows for name in (r.name, *r.aliases))


def feeds() -> tuple[Row, ...]:
    """Rows that are a feed of `Chassis`."""
    return tuple(_BY_FEED.values())
