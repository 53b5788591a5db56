"""`Mission`: a named list of steps, and `mission_of`, which checks the values of a file or a page. Pure.

`KINDS` has a row for each kind of step: its keys, and whether it moves the robot. The editor of the page, the
documentation's table and the check read it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
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


@dataclass(frozen=True, slots=True)
class Key:
    """One key of a table.

    Attributes:
        type: A key of `_WORDS`; a target is the name of a step or one of `TARGETS`.
        default: None if the key must be given.
        low, high: Of a number.
        names: The allowed texts; empty for any.
    """

    type: str
    default: Value | None = None
    low: float = -math.inf
    high: float = math.inf
    names: tuple[str, ...] = ()

    @property
    def expected(self) -> str:
        """What is allowed, in words."""
        if self.names:
            return say("one of: {names}", names=list(self.names))
        text = say(_WORDS[self.type])
        if self.low > -math.inf or self.high < math.inf:
            return say("{what} from {low} to {high}", what=text, low=self.low, high=self.high)
        return text

    def accepts(self, value: object) -> bool:
        """Whether it is a value of this key."""
        if isinstance(value, bool) or self.type == "bool":
            return isinstance(value, bool) and self.type == "bool"
        if self.type in ("number", "whole"):
            kind = (int, float) if self.type == "number" else int
            return isinstance(value, kind) and math.isfinite(value) and self.low <= value <= self.high
        if self.type == "table":
            return isinstance(value, Mapping)
        return isinstance(value, str) and bool(value.strip()) and (not self.names or value in self.names)


_WORDS = {
    "text": "a text in quotes",
    "mark": "the name of a mark in quotes",
    "target": "the name of a step, or next, end or stop, in quotes",
    "number": "a number",
    "whole": "a whole number",
    "bool": "true or false",
    "table": "a table in braces",
}


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of step.

    Attributes:
        keys: Its own keys; every step has those of `STEP_KEYS`, too.
        moves: Whether it moves the robot or its lift.
        flow: Whether it only decides which step comes next.
    """

    keys: Mapping[str, Key]
    moves: bool = False
    flow: bool = False


_MARK, _TEXT = Key("mark"), Key("text")
_INPUT, _MODULE = Key("whole", low=0, high=255), Key("whole", 1, 0, 255)  # 1: keys of the chassis
_PERCENT = Key("number", low=1, high=100)
KINDS: Mapping[str, Kind] = {
    "go_to_mark": Kind({"mark": _MARK}, moves=True),
    "go_to": Kind(
        {"x": Key("number"), "y": Key("number"), "degrees": Key("number", 0.0, -360, 360)}, moves=True
    ),
    "park": Kind({"mark": _MARK}, moves=True),
    "load": Kind({"mark": _MARK}, moves=True),
    "unload": Kind({"mark": _MARK}, moves=True),
    "charge": Kind({"mark": _MARK, "until_percent": Key("number", 0.0, 0, 100)}, moves=True),
    "move": Kind({"metres": Key("number", low=-10, high=10), "speed": Key("number", 0.0, 0, 2)}, moves=True),
    "rotate": Kind({"degrees": Key("number", low=-3600, high=3600)}, moves=True),
    "dock": Kind({"tag": _TEXT}, moves=True),
    "lift": Kind({"to": Key("text", names=("up", "down"))}, moves=True),
    "wait": Kind({"seconds": Key("number", low=0, high=86400)}),
    "wait_for_input": Kind({"input": _INPUT, "module": _MODULE, "is": Key("bool", True)}),
    "wait_for_battery": Kind({"percent": _PERCENT}),
    "light": Kind({"state": _TEXT, "color": Key("text", "")}),
    "say": Kind({"text": _TEXT}),
    "picture": Kind({"file": Key("text", "")}),
    "call": Kind({"service": _TEXT, "type": Key("text", ""), "request": Key("table", {})}),
    "ask": Kind({"text": _TEXT, "answers": Key("table"), "default": Key("text", "")}),
    "repeat": Kind({"from": Key("target"), "times": Key("whole", 0, 0, 1_000_000)}, flow=True),
    "if": Kind(
        {
            "value": Key("text", names=("battery", "input", "mark", "answer")),
            "input": Key("whole", 0, 0, 255),
            "module": _MODULE,
            "below": Key("number", math.inf),
            "above": Key("number", -math.inf),
            "is": Key("text", ""),
            "then": Key("target", "next"),
            "else": Key("target", "next"),
        },
        flow=True,
    ),
    "go_on": Kind({"with": Key("target")}, flow=True),
}
"""Every kind of step: m, degrees, seconds, percent. 0 of `times` repeats until the mission is stopped."""
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
MISSION_KEYS = ("mission", "name", "description", "parameters", "guards", "step", "on_abort")


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
    def kind(self) -> Kind:
        """The row of its kind."""
        return KINDS[self.do]

    def value(self, key: str, parameters: Mapping[str, Value] | None = None) -> Any:
        """One of its keys, its default if it is not given, with parameters filled in."""
        one = self.kind.keys[key]
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
                raise _unknown(path, name, list(filled))
            if not _parameter_key(filled[name]).accepts(value):
                raise _wrong(path, value, _parameter_key(filled[name]).expected)
            filled[name] = value  # type: ignore[assignment]  # accepted
        _check_steps(self, filled)
        return filled


def mission_of(data: Mapping[str, Any]) -> Mission:
    """Check the values of a file, or of JSON with the same keys, and make a mission of them.

    Raises:
        MissionError: What was found, what is allowed, and the path of the key.
    """
    _require_known((), data, MISSION_KEYS)
    if data.get("mission") != VERSION:
        raise _wrong(
            ("mission",), data.get("mission"), say("mission = {version}, the format", version=VERSION)
        )
    name = data.get("name")
    if not Key("text").accepts(name):
        raise _wrong(("name",), name, Key("text").expected)
    description = data.get("description", "")
    if not isinstance(description, str):
        raise _wrong(("description",), description, Key("text").expected)
    parameters = _table(data, "parameters")
    for key, value in parameters.items():
        if not isinstance(value, (str, bool, int, float)) or (isinstance(value, float) and value != value):
            raise _wrong(("parameters", key), value, say("a text, a number, true or false"))
    guards = _table(data, "guards")
    _check_table(("guards",), guards, GUARDS)
    if guards.get("battery_below") and not guards.get("charger"):
        raise MissionError(say("battery_below needs charger, the mark of the charger"), ("guards",))
    mission = Mission(
        str(name), _steps(data, "step"), description, parameters, guards, _steps(data, "on_abort")
    )
    if not mission.steps:
        raise MissionError(say("there is no step; write [[step]] and below it do = ..."))
    names: set[str] = set()
    for place, step in enumerate(mission.steps):
        if step.name in names or step.name in TARGETS:
            expected = say("a name that no other step has, and not one of: {names}", names=list(TARGETS))
            raise _wrong(("step", place, "name"), step.name, expected)
        names.update(filter(None, (step.name,)))
    _check_steps(mission, mission.parameters)
    return mission


def _steps(data: Mapping[str, Any], table: str) -> tuple[Step, ...]:
    found = data.get(table, [])
    if not (isinstance(found, Sequence) and all(isinstance(each, Mapping) for each in found)):
        raise _wrong((table,), found, say("tables, one [[{table}]] for each step", table=table))
    if len(found) > MAX_STEPS:
        raise MissionError(
            say("{count} steps; expected at most {max_steps}", count=len(found), max_steps=MAX_STEPS)
        )
    return tuple(_step((table, place), each) for place, each in enumerate(found))


def _step(path: Path, given: Mapping[str, Any]) -> Step:
    do = given.get("do")
    if not isinstance(do, str) or do not in KINDS:
        wrong = _wrong(
            (*path, "do") if "do" in given else path, do, say("one of: {names}", names=list(KINDS))
        )
        raise MissionError(both(str(wrong), *hint(str(do), KINDS)), wrong.path)
    keys = {"do": Key("text"), **KINDS[do].keys, **STEP_KEYS}
    common = {key: given[key] for key in STEP_KEYS if key in given}
    _require_known(path, given, keys)
    _check_table(path, common, STEP_KEYS)
    for key, one in KINDS[do].keys.items():
        if key not in given and one.default is None:
            raise MissionError(
                say("{do} needs {key}: {expected}", do=do, key=key, expected=one.expected), path
            )
    return Step(do, {key: given[key] for key in given if key in KINDS[do].keys}, **common)


def _check_steps(mission: Mission, parameters: Mapping[str, Value]) -> None:
    """Check the values of all steps with these parameters filled in, and that every target exists."""
    targets = (*TARGETS, *(step.name for step in mission.steps if step.name))
    for table, steps in (("step", mission.steps), ("on_abort", mission.on_abort)):
        for place, step in enumerate(steps):
            path: Path = (table, place)
            if table == "on_abort" and (step.kind.flow or step.do == "ask"):
                raise _wrong((*path, "do"), step.do, say("a step that asks nothing and leads nowhere else"))
            for key, given in step.values.items():
                if isinstance(given, str) and given.startswith("$") and given[1:] not in parameters:
                    raise _unknown((*path, key), given[1:], list(parameters))
                value = step.value(key, parameters)
                if not step.kind.keys[key].accepts(value):
                    raise _wrong((*path, key), value, step.kind.keys[key].expected)
            _check_step(path, step, targets)


def _check_step(path: Path, step: Step, targets: Sequence[str]) -> None:
    leads: list[tuple[str, object]] = [("on_failure", step.on_failure)]
    leads += [(key, step.value(key)) for key, one in step.kind.keys.items() if one.type == "target"]
    if step.do == "ask":
        answers = step.value("answers")
        if not 2 <= len(answers) <= 5:
            raise _wrong((*path, "answers"), list(answers), say("two to five answers, each with a target"))
        leads += [("answers", target) for target in answers.values()]
        default = step.value("default")
        if default and default not in answers:
            raise _wrong((*path, "default"), default, say("one of: {names}", names=list(answers)))
        if bool(default) != bool(step.timeout):
            raise MissionError(say("ask: timeout and default belong together; give both or none"), path)
    if step.do == "if":
        numeric = step.value("value") == "battery"
        compared = [key for key in ("below", "above", "is") if key in step.values]
        if len(compared) != 1 or (compared == ["is"]) is numeric:
            expected = say("one of below and above for battery, is for the others")
            raise _wrong((*path, compared[0]) if compared else path, compared, expected)
    for key, target in leads:
        if target not in targets:
            raise _wrong((*path, key), target, say("one of: {names}", names=list(targets)))


def _check_table(path: Path, given: Mapping[str, Any], keys: Mapping[str, Key]) -> None:
    _require_known(path, given, keys)
    for key, value in given.items():
        if not keys[key].accepts(value):
            raise _wrong((*path, key), value, keys[key].expected)


def _require_known(path: Path, given: Mapping[str, Any], keys: Sequence[str] | Mapping[str, Key]) -> None:
    for key in given:
        if key not in keys:
            raise _unknown((*path, key), key, list(keys))


def _table(data: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    found = data.get(key, {})
    if not isinstance(found, Mapping):
        raise _wrong((key,), found, say("a table, [{key}]", key=key))
    return found


def _parameter_key(default: object) -> Key:
    return Key("bool" if isinstance(default, bool) else "text" if isinstance(default, str) else "number")


def _unknown(path: Path, name: str, known: list[str]) -> MissionError:
    text = say("{name} is not known; expected one of: {known}", name=name, known=known)
    return MissionError(both(text, *hint(name, known)), path)


def _wrong(path: Path, value: object, expected: str) -> MissionError:
    found = say("nothing") if value is None else repr(value)[:80]
    key = str(path[-1]) if path else "mission"
    return MissionError(
        say("{key}: found {found}; expected {expected}", key=key, found=found, expected=expected), path
    )
