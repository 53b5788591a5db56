"""`Mission`: a named list of steps, and `mission_of`, which checks the values of a file or a page. Pure.

`KINDS` has a row of keys for each kind of step. The check, the editor of the page and the documentation's
table read it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from rosproto.sentence import both, hint, say
from woosh_pure.errors import ChassisError

VERSION = 1
MAX_STEPS = 200
"""Of one mission, and the same for its `on_abort` steps."""
TARGETS = ("next", "end", "stop")
"""Where a mission may go on besides a named step: the next one, its end, or its end as failed."""
Value = str | float | bool | Mapping[str, Any]
Path = tuple[str | int, ...]


class MissionError(ChassisError, ValueError):
    """A mission is faulty, or what was asked for is not possible now; nothing has moved.

    Attributes:
        path: The key that is faulty, such as ("step", 2, "mark"); empty if it is none.
        line, column: Where it is in the file, from 1; 0 if there is no file.
    """

    def __init__(self, message: str, path: Path = (), line: int = 0, column: int = 0) -> None:
        super().__init__(message)
        self.path, self.line, self.column = path, line, column


def _is_text(value: object) -> bool:
    return isinstance(value, str) and bool(value.strip())


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


_TYPES: Mapping[str, tuple[str, Callable[[object], bool]]] = {
    "version": ("mission = 1, the format", lambda value: _is_number(value) and value == VERSION),
    "text": ("a text in quotes", _is_text),
    "mark": ("the name of a mark in quotes", _is_text),
    "target": ("the name of a step, or next, end or stop, in quotes", _is_text),
    "number": ("a number", _is_number),
    "whole": ("a whole number", lambda value: _is_number(value) and isinstance(value, int)),
    "bool": ("true or false", lambda value: isinstance(value, bool)),
    "parameter": (
        "a text, a number, true or false",
        lambda value: isinstance(value, (str, bool)) or _is_number(value),
    ),
    "table": ("a table", lambda value: isinstance(value, Mapping)),
    "tables": (
        "a list of tables, one for each step",
        lambda value: isinstance(value, Sequence) and all(isinstance(each, Mapping) for each in value),
    ),
}
"""The types of keys: what is expected, in words, and whether a value is of the type."""


@dataclass(frozen=True, slots=True)
class Key:
    """One key of a table.

    Attributes:
        type: A key of `_TYPES`; a target is the name of a step or one of `TARGETS`.
        default: None if the key must be given.
        low, high: Of a number.
        names: The allowed texts; empty for any.
    """

    type: str
    default: Value | None = None
    low: float = -math.inf
    high: float = math.inf
    names: tuple[str, ...] = ()

    def accepts(self, value: object) -> bool:
        """Whether it is a value of this key."""
        if value == "" == self.default or not _TYPES[self.type][1](value):
            return value == "" == self.default
        if isinstance(value, (int, float)) and not self.low <= value <= self.high:
            return False
        return not self.names or value in self.names

    def require(self, path: Path, value: object) -> None:
        """Check a value; None if it is missing.

        Raises:
            MissionError: It is not one of this key.
        """
        if self.accepts(value):
            return
        expected = say(_TYPES[self.type][0])
        if self.names:
            expected = say("one of: {names}", names=list(self.names))
        elif self.low > -math.inf or self.high < math.inf:
            expected = say("{what} from {low} to {high}", what=expected, low=self.low, high=self.high)
        raise _wrong(path, value, expected, self.names)


_MARK, _TEXT = Key("mark"), Key("text")
_MODULE = Key("whole", 1, 0, 255)  # 1: keys of the chassis
KINDS: Mapping[str, Mapping[str, Key]] = {
    "go_to_mark": {"mark": _MARK},
    "go_to": {"x": Key("number"), "y": Key("number"), "degrees": Key("number", 0.0, -360, 360)},
    "park": {"mark": _MARK},
    "load": {"mark": _MARK},
    "unload": {"mark": _MARK},
    "charge": {"mark": _MARK, "until_percent": Key("number", 0.0, 0, 100)},
    "task_list": {"list": _TEXT},
    "move": {"metres": Key("number", low=-10, high=10), "speed": Key("number", 0.0, 0, 2)},
    "rotate": {"degrees": Key("number", low=-3600, high=3600)},
    "dock": {"tag": _TEXT},
    "lift": {"to": Key("text", names=("up", "down"))},
    "wait": {"seconds": Key("number", low=0, high=86400)},
    "wait_for_input": {"input": Key("whole", low=0, high=255), "module": _MODULE, "is": Key("bool", True)},
    "wait_for_battery": {"percent": Key("number", low=1, high=100)},
    "light": {"state": _TEXT, "color": Key("text", "")},
    "say": {"text": _TEXT},
    "picture": {"file": Key("text", "")},
    "call": {"service": _TEXT, "type": Key("text", ""), "request": Key("table", {})},
    "ask": {
        "text": _TEXT,
        "answers": Key("table"),
        "default": Key("text", ""),
        "inputs": Key("table", {}),
        "module": _MODULE,
    },
    "repeat": {"from": Key("target"), "times": Key("whole", 0, 0, 1_000_000)},
    "if": {
        "value": Key("text", names=("battery", "input", "mark", "answer")),
        "input": Key("whole", 0, 0, 255),
        "module": _MODULE,
        "below": Key("number", math.inf),
        "above": Key("number", -math.inf),
        "is": Key("text", ""),
        "then": Key("target", "next"),
        "else": Key("target", "next"),
    },
    "go_on": {"with": Key("target")},
}
"""The keys of every kind of step: m, degrees, seconds, percent. 0 of `times` repeats until it is stopped."""
MOVING = frozenset("go_to_mark go_to park load unload charge task_list move rotate dock lift".split())
"""Steps that move the robot or its lift."""
LEADING = frozenset(("ask", "repeat", "if", "go_on"))
"""Steps that lead elsewhere."""
STEP_KEYS: Mapping[str, Key] = {
    "name": Key("text", ""),
    "timeout": Key("number", 0.0, 0, 86400),
    "retries": Key("whole", 0, 0, 1000),
    "retry_pause": Key("number", 5.0, 0, 86400),
    "on_failure": Key("target", "stop"),
}
"""Keys of every step: `timeout` 0 takes the default of the verb; `on_failure` comes after the retries."""
GUARDS: Mapping[str, Key] = {
    "battery_below": Key("number", 0.0, 0, 100),
    "charger": Key("mark", ""),
    "charge_until": Key("number", 80.0, 1, 100),
    "not_known": Key("text", "wait", names=("wait", "go")),
}
"""Of the whole mission: charge when the battery is below; whether readiness "not known" waits or goes."""
MISSION_KEYS: Mapping[str, Key] = {
    "mission": Key("version"),
    "name": _TEXT,
    "description": Key("text", ""),
    "parameters": Key("table", {}),
    "guards": Key("table", {}),
    "step": Key("tables"),
    "on_abort": Key("tables", {}),
}


@dataclass(frozen=True, slots=True)
class Step:
    """One step.

    Attributes:
        do: Its kind, a name of `KINDS`.
        values: Its own keys as given; `"$name"` stands for a parameter.
        name: For `repeat`, `if`, answers and `on_failure`; "" if nothing leads to it.
        timeout: s; 0 takes the default.
        retries, retry_pause: How often it is tried again after a failure, and the s between.
        on_failure: What comes when it has failed for good: a step's name, "next", "end" or "stop".
    """

    do: str
    values: Mapping[str, Any] = field(default_factory=dict)
    name: str = ""
    timeout: float = 0.0
    retries: int = 0
    retry_pause: float = 5.0
    on_failure: str = "stop"

    @property
    def keys(self) -> Mapping[str, Key]:
        """Those of its kind."""
        return KINDS[self.do]

    def value(self, key: str, parameters: Mapping[str, Value] | None = None) -> Any:
        """One of its keys, its default if it is not given, with parameters filled in."""
        one = self.keys[key]
        given = self.values.get(key, one.default)
        if parameters is not None and not one.names and isinstance(given, str) and given.startswith("$"):
            return parameters[given[1:]]
        return given

    def data(self) -> dict[str, Any]:
        """As in the file: keys that have their defaults are left out."""
        common = {key: getattr(self, key) for key, one in STEP_KEYS.items()}
        given = {key: value for key, value in common.items() if value != STEP_KEYS[key].default}
        named = {"name": given.pop("name")} if self.name else {}
        return {**named, "do": self.do, **self.values, **given}


@dataclass(frozen=True, slots=True)
class Mission:
    """A named list of steps.

    Attributes:
        name, description: For people.
        steps: In their order.
        parameters: Name -> default; a start may give others of the same type.
        guards: As given, see `GUARDS`.
        on_abort: Steps after a failure (not after a stop by a person), each once.
    """

    name: str
    steps: tuple[Step, ...]
    description: str = ""
    parameters: Mapping[str, Value] = field(default_factory=dict)
    guards: Mapping[str, Value] = field(default_factory=dict)
    on_abort: tuple[Step, ...] = ()

    def guard(self, key: str) -> Any:
        """One of the guards, or its default."""
        return self.guards.get(key, GUARDS[key].default)

    def index(self, name: str) -> int:
        """The place of a named step, from 0."""
        return next(place for place, step in enumerate(self.steps) if step.name == name)

    def data(self) -> dict[str, Any]:
        """As in the file, for JSON; `mission_of` is the way back."""
        rest = {
            "description": self.description,
            "parameters": dict(self.parameters),
            "guards": dict(self.guards),
            "step": [step.data() for step in self.steps],
            "on_abort": [step.data() for step in self.on_abort],
        }
        return {"mission": VERSION, "name": self.name} | {key: one for key, one in rest.items() if one}

    def filled(self, given: Mapping[str, object]) -> dict[str, Value]:
        """The parameters of a start.

        Raises:
            MissionError: A parameter is not known, or has another type than its default.
        """
        filled = dict(self.parameters)
        for name, value in given.items():
            path: Path = ("parameters", name)
            if name not in filled:
                raise _unknown(path, list(filled))
            default = filled[name]
            kind = "bool" if isinstance(default, bool) else "text" if isinstance(default, str) else "number"
            Key(kind).require(path, value)
            filled[name] = value  # type: ignore[assignment]  # accepted
        _check_steps(self, filled)
        return filled


def mission_of(data: Mapping[str, Any]) -> Mission:
    """Check the values of a file, or of JSON with the same keys, and make a mission of them.

    Raises:
        MissionError: What was found, what is allowed, and the path of the key.
    """
    _check((), data, MISSION_KEYS)
    parameters, guards = data.get("parameters", {}), data.get("guards", {})
    for key, value in parameters.items():
        Key("parameter").require(("parameters", key), value)
    _check(("guards",), guards, GUARDS)
    if guards.get("battery_below") and not guards.get("charger"):
        raise MissionError(say("battery_below needs charger, the mark of the charger"), ("guards",))
    steps, on_abort = _steps(data, "step"), _steps(data, "on_abort")
    if not steps:
        raise MissionError(say("there is no step; write [[step]] and below it do = ..."))
    names: set[str] = set()
    for place, step in enumerate(steps):
        if step.name in names or step.name in TARGETS:
            expected = say("a name that no other step has, and not one of: {names}", names=list(TARGETS))
            raise _wrong(("step", place, "name"), step.name, expected)
        names.update(filter(None, (step.name,)))
    mission = Mission(data["name"], steps, data.get("description", ""), parameters, guards, on_abort)
    _check_steps(mission, parameters)
    return mission


def _steps(data: Mapping[str, Any], table: str) -> tuple[Step, ...]:
    found = data.get(table, [])
    if len(found) > MAX_STEPS:
        text = "{count} steps; expected at most {max_steps}"
        raise MissionError(say(text, count=len(found), max_steps=MAX_STEPS))
    return tuple(_step((table, place), each) for place, each in enumerate(found))


def _step(path: Path, given: Mapping[str, Any]) -> Step:
    do = given.get("do")
    Key("text", names=tuple(KINDS)).require((*path, "do"), do)
    keys, common = KINDS[str(do)], {key: given[key] for key in STEP_KEYS if key in given}
    _check(path, given, {"do": _TEXT, **keys, **STEP_KEYS}, values=False)
    _check(path, common, STEP_KEYS)
    return Step(str(do), {key: given[key] for key in given if key in keys}, **common)


def _check_steps(mission: Mission, parameters: Mapping[str, Value]) -> None:
    """Check the values of all steps with these parameters filled in, and that every target exists."""
    targets = (*TARGETS, *(step.name for step in mission.steps if step.name))
    for table, steps in (("step", mission.steps), ("on_abort", mission.on_abort)):
        for place, step in enumerate(steps):
            path: Path = (table, place)
            if table == "on_abort" and step.do in LEADING:
                raise _wrong((*path, "do"), step.do, say("a step that asks nothing and leads nowhere else"))
            for key, given in step.values.items():
                if isinstance(given, str) and given.startswith("$") and given[1:] not in parameters:
                    raise _unknown((*path, key), list(parameters), given[1:])
                step.keys[key].require((*path, key), step.value(key, parameters))
            _check_step(path, step, targets)


def _check_step(path: Path, step: Step, targets: tuple[str, ...]) -> None:
    leads: list[tuple[str, object]] = [("on_failure", step.on_failure)]
    leads += [(key, step.value(key)) for key, one in step.keys.items() if one.type == "target"]
    if step.do == "ask":
        answers = step.value("answers")
        if not 2 <= len(answers) <= 5:
            raise _wrong((*path, "answers"), list(answers), say("two to five answers, each with a target"))
        leads += [("answers", target) for target in answers.values()]
        Key("text", "", names=tuple(answers)).require((*path, "default"), step.value("default"))
        _check((*path, "inputs"), step.value("inputs"), dict.fromkeys(answers, Key("whole", 0, 0, 255)))
        if len({*step.value("inputs").values()}) < len(step.value("inputs")):
            raise _wrong((*path, "inputs"), step.value("inputs"), say("another input for each answer"))
        if bool(step.value("default")) != bool(step.timeout):
            raise MissionError(say("ask: timeout and default belong together; give both or none"), path)
    if step.do == "if":
        numeric = step.value("value") == "battery"
        compared = [key for key in ("below", "above", "is") if key in step.values]
        if len(compared) != 1 or (compared == ["is"]) is numeric:
            expected = say("one of below and above for battery, is for the others")
            raise _wrong((*path, compared[0]) if compared else path, compared, expected)
    for key, target in leads:
        Key("text", names=targets).require((*path, key), target)


def _check(path: Path, given: Mapping[str, Any], keys: Mapping[str, Key], *, values: bool = True) -> None:
    """Check that all keys are known, none is missing, and their values."""
    for key in given:
        if key not in keys:
            raise _unknown((*path, key), list(keys))
    for key, one in keys.items():
        if (values and key in given) or (key not in given and one.default is None):
            one.require((*path, key), given.get(key))


def _unknown(path: Path, known: list[str], name: str = "") -> MissionError:
    name = name or str(path[-1])
    text = say("{name} is not known; expected one of: {known}", name=name, known=known)
    return MissionError(both(text, *hint(name, known)), path)


def _wrong(path: Path, value: object, expected: str, names: Sequence[str] = ()) -> MissionError:
    found = say("nothing") if value is None else repr(value)[:80]
    text = say("{key}: found {found}; expected {expected}", key=path[-1], found=found, expected=expected)
    return MissionError(both(text, *hint(str(value), names)), path)
