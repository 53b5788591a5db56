"""`python -m tools.interface_page` prints docs/interface.md: verbs and rows of the interface as tables.

The rows are those of `woosh_pure.interface`, the texts of the verbs are the first sentences of their
docstrings; a test compares the committed page with what this makes.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from woosh_pure.chassis import Chassis
from woosh_pure.interface.listed import LISTED
from woosh_pure.interface.rows import ROWS
from woosh_pure.interface.schema import Row
from woosh_pure.interface.table import row

__all__ = ["VERBS", "Verb", "how", "page"]


class Verb(NamedTuple):
    """One method of `Chassis` that commands or queries the robot.

    Attributes:
        name: The method.
        rows: Names of the rows of the interface behind it.
        units: Units and frames of its arguments and of what it returns.
    """

    name: str
    rows: tuple[str, ...]
    units: str = ""


_VELOCITY = ("/smooth_cmd_vel", "/base_cmd_vel", "/odom_twist")
_FOOTPRINTS = ("/move_base/local_costmap/set_footprint", "/move_base/global_costmap/set_footprint")
_TASK = ("/exec_task", "/robot_status")
_STEP_UNITS = "m, forward positive; m/s; base_link"

VERBS: tuple[Verb, ...] = (
    Verb("go_to_mark", _TASK, "s"),
    Verb("task", _TASK, "poses: m, rad; map"),
    Verb("park", _TASK),
    Verb("charge", _TASK),
    Verb("carry", _TASK),
    Verb("go_to", ("/move_base",), "m, m, rad; map"),
    Verb("follow", ("/move_base",), "m, m, rad; map"),
    Verb("move", ("/cmd_vel_control",), _STEP_UNITS),
    Verb("rotate", ("/cmd_vel_control",), "rad (or degrees=True), left positive; rad/s"),
    Verb("strafe", ("/cmd_vel_control",), "m, left positive; m/s; base_link"),
    Verb("move_diagonal", ("/cmd_vel_control",), "m, rad left of forward; m/s; base_link"),
    Verb("steps", ("/cmd_vel_control",), "m, rad, m/s, rad/s; base_link"),
    Verb("velocity", _VELOCITY, "m/s, rad/s; base_link"),
    Verb("stop", (*_VELOCITY, "/move_base", "/cmd_vel_control", "/exec_task"), "s"),
    Verb("plan", ("/move_base/make_plan",), "m, rad; map"),
    Verb("set_navigation_mode", ("/navigation_mode",), "s, m/s"),
    Verb("set_pose", ("/initialpose", "/init_pose"), "m, rad; map"),
    Verb("initialise", ("/woosh_init",)),
    Verb("start_localization", ("/start_localization",)),
    Verb("enable_costmaps", ("/move_base/enable_costmaps",)),
    Verb("clear_costmaps", ("/move_base/clear_costmaps",)),
    Verb("get_map", ("/aic_map_server/get_map",), "m per cell; map"),
    Verb("set_map", ("/set_map",), "m per cell; map"),
    Verb("set_footprint", _FOOTPRINTS, "m; base_link"),
    Verb("light", ("/rgbled", "/rgbled_shelf")),
    Verb("say", ("/voice_synthesis",)),
    Verb("action", (), "as the goal message says"),
    Verb("send", (), "as the row says"),
)

_ANY = {"action": "any action row", "send": "any topic to write, velocities apart"}
_FEED_OF_ANOTHER_NAME = {"velocity": "measured_velocity"}

_HEAD = """\
# The interface, row by row

This page is made by `python -m tools.interface_page`, from the table that also drives the API, the
simulator and `woosh doctor`. Frames follow REP 103 and 105: x forward, y left, angles counter-clockwise;
metres, radians and seconds.
"""

_BEHIND = """\

## What the chassis publishes and takes

"page" rows are on the vendor's interface page; "seen" rows were seen on a real chassis only, so yours may not
have them; "package" rows are types of the vendor's message package whose names are not documented: they are
found by their type, and the name here is the simulator's. Rows marked ⚠ pass by the chassis's own obstacle
avoidance, collision detection and limits.
"""

_NOTES = """\

`/robot_status` and `/status_code` are sent on change only: a program that has just started may hear
nothing for a long time. Whether `/robot_status` is latched is not documented. Whether the chassis
stops by itself when velocity messages end is not documented either: assume that it does not.
"""


_LISTED = """\

### Names of which no more is known

Each of these names is in the output of `rostopic list | head` on the vendor's page ("screenshot"), or in the
graph of a real chassis without another node that has to do with it ("seen"). A type of a screenshot's name is
what the vendor's package has that fits. `feed("/IO_output")` learns the type from the robot.
"""

_FIELDS = """\

## Fields of the vendor's types

These are the fields, values and limits of the woosh_msgs types that the vendor's page describes, in the order
and the spelling of the wire. The definitions in `msgdefs/woosh_msgs` say the same, and how the page differs.
"""

DEFINITIONS = Path(__file__).resolve().parent.parent / "msgdefs"
_FIELD = re.compile(
    r"^(?P<type>[\w/]+(?:\[\d*\])?)\s+(?P<name>\w+)(?:\s*=\s*(?P<value>\S+))?\s*(?:#\s*(?P<comment>.*))?$"
)


def how(found: Row) -> str:
    """How a program reaches a row: the feed, the verbs, or the generic way."""
    if found.feed:
        name = _FEED_OF_ANOTHER_NAME.get(found.feed, found.feed)
        return f"`{name}`" if hasattr(Chassis, name) else f'`feed("{found.feed}")`'
    verbs = [verb.name for verb in VERBS if found.name in verb.rows]
    if verbs:
        return ", ".join(f"`{name}`" for name in verbs)
    if found.kind == "action":
        return f'`action("{found.name}", goal)`'
    if found.flow == "read":
        return f'`feed("{found.name}")`'
    return "on purpose by no verb" if found.bypasses_protection else f'`send("{found.name}", message)`'


def _sentence(verb: Verb) -> str:
    """The beginning of its docstring, on one line."""
    text = inspect.getdoc(getattr(Chassis, verb.name)) or ""
    return " ".join(text.split("\n\n")[0].split())


def _call(verb: Verb) -> str:
    """The call with its required arguments."""
    parameters = list(inspect.signature(getattr(Chassis, verb.name)).parameters.values())[1:]
    needed = [
        f"{p.name}=" if p.kind is p.KEYWORD_ONLY else p.name
        for p in parameters
        if p.default is p.empty and p.kind is not p.VAR_KEYWORD
    ]
    return f"`{verb.name}({', '.join(needed)})`"


def _table(titles: Iterable[str], lines: Iterable[Iterable[str]]) -> Iterator[str]:
    titles = list(titles)
    yield ""
    yield f"| {' | '.join(titles)} |"
    yield "|" + "---|" * len(titles)
    for cells in lines:
        yield f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def _verb_lines() -> Iterator[list[str]]:
    for verb in VERBS:
        behind = ", ".join(f"`{row(name).name}`" for name in verb.rows) or _ANY[verb.name]
        yield [_call(verb), _sentence(verb), verb.units, behind]


def _row_lines(flow: str) -> Iterator[list[str]]:
    for found in ROWS:
        if found.flow == flow:
            mark = " ⚠" if found.bypasses_protection else ""
            change = "; on change only" if found.on_change else ""
            if found.name_assumed:
                change += "; **the name is our assumption**: it is found by its type"
            name = ", ".join(f"`{n}`" for n in (found.name, *found.aliases)) + mark
            yield [name, f"`{found.type}`", how(found), found.meaning + change, found.unit, found.source]


def _field_tables() -> Iterator[str]:
    """One table for each woosh_msgs type of the vendor's page, and for the nested steps."""
    types = [found.type for found in ROWS if found.source == "page" and found.type.startswith("woosh_msgs/")]
    for type_ in dict.fromkeys([*types, "woosh_msgs/StepControl.msg"]):
        package, _, name = type_.partition("/")
        files = sorted((DEFINITIONS / package).glob(f"*/{name}" if "." in name else f"*/{name}.*"))
        file = max(files, key=lambda path: path.suffix in (".srv", ".action"))
        title = f"One step of it, `{type_.removesuffix('.msg')}`" if "." in name else f"`{type_}`"
        yield f"\n### {title}"
        yield from _table(("field", "type", "meaning"), _field_lines(file.read_text("utf-8"), file.suffix))


def _field_lines(definition: str, suffix: str) -> Iterator[list[str]]:
    """Fields and constants with the comment behind or directly above them."""
    parts = iter({".msg": ("",), ".srv": ("", "answer: "), ".action": ("", "result: ", "feedback: ")}[suffix])
    part, above = next(parts), ""
    for line in definition.splitlines():
        found = _FIELD.match(line)
        if line.startswith("#"):
            above = f"{above} {line[1:].strip()}".strip()
        elif line == "---":
            part, above = next(parts), ""
        elif found is None:
            above = ""
        elif found["value"]:
            yield [
                f"{part}`{found['name']}` = {found['value']}",
                f"`{found['type']}`",
                found["comment"] or "",
            ]
        else:
            yield [f"{part}`{found['name']}`", f"`{found['type']}`", found["comment"] or above]
            above = ""


def page() -> str:
    """The text of docs/interface.md."""
    lines = [_HEAD, "## Verbs of `Chassis`"]
    lines += _table(("verb", "what it does", "units and frame", "behind it"), _verb_lines())
    lines.append(_BEHIND.rstrip())
    for flow, title in (
        ("read", "Topics to read"),
        ("write", "Topics to write"),
        ("call", "Services"),
        ("act", "Actions"),
    ):
        lines += ["", f"### {title}"]
        titles = ("name", "type", "in `Chassis`", "meaning", "unit; frame", "source")
        lines += _table(titles, _row_lines(flow))
    lines.append(_LISTED.rstrip())
    named = (
        [f"`{n.name}`", f"`{n.likely_type}`" if n.likely_type else "not known", n.meaning, n.source]
        for n in LISTED
    )
    lines += _table(("name", "type that fits", "meaning", "source"), named)
    lines.append(_NOTES.rstrip())
    lines.append(_FIELDS.rstrip())
    lines += _field_tables()
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.stdout.reconfigure(encoding="utf-8", newline="\n")  # type: ignore[union-attr]
    sys.stdout.write(page())
