"""Actions of the user's own: functions, programs, and what cannot be one."""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from woosh_pure.errors import ChassisError
from woosh_pure.fleet.action_handlers.custom_actions import Triggers
from woosh_pure.fleet.action_handlers.predefined_actions import supported_actions
from woosh_pure.fleet.action_handlers.running_action import Task
from woosh_pure.fleet.config import VehicleConfig
from woosh_pure.fleet.messages.elements import Action
from woosh_pure.fleet.order.action_states import Scope, objection
from woosh_pure.fleet.state_file import Journal


def config(**actions: str) -> VehicleConfig:
    return VehicleConfig(manufacturer="W", serial="1", actions=actions)


def task(**parameters: Any) -> Task:
    return Task(Action("a", "x", "NONE", parameters), cast(Any, None), [])


def turn(given: Task) -> str:
    """Turn it."""
    return f"turned {given.parameters['by']}"


turn.moves, turn.scopes = True, (Scope.NODE,)  # type: ignore[attr-defined]


def test_a_function_says_what_it_is_like() -> None:
    """By attributes, and its first line."""
    supported, doing = supported_actions(config(turn=f"{__name__}:turn"))["turn"]
    assert (supported.moves, supported.scopes, supported.description) == (True, (Scope.NODE,), "Turn it.")
    assert doing(task(by=3)) == "turned 3"


@pytest.mark.parametrize("target", ["nowhere", "no.such.module:f", "os:nothing", "os:sep", "!"])
def test_what_is_no_function_is_said_at_the_start(target: str) -> None:
    """And not when the fleet manager asks for it."""
    with pytest.raises(ValueError, match="action"):
        supported_actions(config(x=target))


def test_the_standards_own_are_not_replaced() -> None:
    """cancelOrder stays what it is."""
    with pytest.raises(ValueError, match="cancelOrder"):
        supported_actions(config(cancelOrder="!true"))


def program(script: str) -> str:
    """A Python program as an action, quoted as this system's own command line is."""
    words = [sys.executable, "-c", script]
    return "!" + (subprocess.list2cmdline(words) if sys.platform == "win32" else shlex.join(words))


@pytest.mark.promise("get their parameters on standard input, without a shell")
def test_a_program_gets_the_parameters_and_gives_the_result() -> None:
    """As JSON on its standard input; no shell looks at anything."""
    script = 'import json, sys; print(json.load(sys.stdin)["parameters"]["by"] * 2)'
    _, doing = supported_actions(config(x=program(script)))["x"]
    assert doing(task(by="$(id);")) == "$(id);$(id);"


def test_a_program_speaks_utf8() -> None:
    """Whatever the locale is; a byte that is none is shown, not raised."""
    script = 'import sys; sys.stdout.buffer.write("\\u5230\\u8fbe".encode() + bytes([0xFF]))'
    _, doing = supported_actions(config(x=program(script)))["x"]
    assert doing(task()) == "\u5230\u8fbe\ufffd"


def test_a_program_that_fails_says_why() -> None:
    """Its exit code and its last words."""
    _, doing = supported_actions(config(x=program('import sys; sys.exit("no load")')))["x"]
    with pytest.raises(ChassisError, match="ended with 1: no load"):
        doing(task())


def test_a_program_is_ended_with_its_action() -> None:
    """It is asked to end, and FAILED."""
    _, doing = supported_actions(config(x=program("import time; time.sleep(60)")))["x"]
    given = task()
    given.cancelled.set()
    with pytest.raises(ChassisError, match=f"ended with {1 if sys.platform == 'win32' else -15}"):
        doing(given)


def test_what_is_not_configured_is_not_offered() -> None:
    """Charging wants a charger, pick and drop want marks."""
    assert set(supported_actions(config())) == {"initPosition"}
    full = VehicleConfig(manufacturer="W", serial="1", marks=True, charger="C1")
    assert set(supported_actions(full)) == {"initPosition", "startCharging", "pick", "drop"}


def test_actions_of_the_standard_have_its_scopes_and_parameters() -> None:
    """Where a user maps one of its names to a function or program of theirs."""
    supported, _ = supported_actions(config(finePositioning="!true"))["finePositioning"]
    assert (supported.scopes, supported.moves) == ((Scope.NODE, Scope.EDGE), True)
    assert [parameter.key for parameter in supported.parameters] == ["stationType", "stationName"]
    supported, _ = supported_actions(config(detectObject="!true"))["detectObject"]
    assert (supported.scopes, supported.moves) == ((Scope.NODE, Scope.EDGE), False)


def wait_for(kind: str, triggers: Triggers, **given: str) -> tuple[Any, Task]:
    """waitForTrigger of a type, in a thread."""
    full = VehicleConfig(manufacturer="W", serial="1", triggers=given)
    waiting = task(triggerType=kind)
    _, doing = supported_actions(full, triggers=triggers)["waitForTrigger"]
    return ThreadPoolExecutor(1).submit(doing, waiting), waiting


def test_a_trigger_lets_go_what_waits_for_it() -> None:
    """And nothing else; one that was pulled before does not count."""
    triggers = Triggers()
    assert triggers.fire("button") == 0
    future, _ = wait_for("button", triggers, button="", door="")
    assert triggers.fire("door") == 0
    deadline = time.monotonic() + 5.0
    while not triggers.fire("button"):
        assert time.monotonic() < deadline
    assert future.result(5.0) is None


def test_a_cancel_ends_the_wait_for_a_trigger() -> None:
    """6.8.2: it has failed, if the order was cancelled."""
    future, waiting = wait_for("button", Triggers(), button="")
    waiting.cancelled.set()
    with pytest.raises(ChassisError, match="cancelled"):
        future.result(5.0)


def test_a_program_is_a_trigger_when_it_ends() -> None:
    """What it says is the result."""
    future, _ = wait_for("door", Triggers(), door=program("print('open')"))
    assert future.result(10.0) == "open"


def test_a_trigger_that_is_not_known_is_rejected_with_the_order() -> None:
    """Nobody would ever pull it."""
    full = VehicleConfig(manufacturer="W", serial="1", triggers={"button": ""})
    supported, _ = supported_actions(full)["waitForTrigger"]
    found = objection(Action("a", "waitForTrigger", "HARD", {"triggerType": "bell"}), Scope.NODE, supported)
    assert found == ("actionParameters.triggerType", "waitForTrigger: triggerType 'bell'; expected button")


class Docked:
    """Of a chassis what stopCharging uses."""

    def __init__(self, charging: bool) -> None:
        self.charging, self.moved = charging, [0.0]

    @property
    def battery(self) -> Docked:
        return self

    def wait(self, timeout: float, new: bool = True) -> Docked:
        return self

    def wait_for(self, accept: Any, timeout: float) -> Docked:
        assert accept(self)
        return self

    def move(self, distance: float, **options: Any) -> Any:
        self.moved.append(distance)
        self.charging = False
        return SimpleNamespace(done=True, wait=lambda timeout: SimpleNamespace(text=""))


def test_charging_is_stopped_by_driving_off() -> None:
    """As far as was said; where nothing charges, nothing moves."""
    full = VehicleConfig(manufacturer="W", serial="1", undock=-0.5)
    supported, doing = supported_actions(full)["stopCharging"]
    assert (supported.moves, supported.scopes) == (True, (Scope.INSTANT, Scope.NODE))
    robot: Any = Docked(True)
    given = Task(Action("a", "stopCharging"), robot, [])
    assert doing(given) == "off the charger"
    assert doing(given) == "it was not charging"
    assert robot.moved == [0.0, -0.5]


def test_reports_are_stored_and_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The name is the result; the oldest makes room."""
    monkeypatch.setattr("woosh_pure.fleet.state_file.MAX_REPORTS", 2)
    journal = Journal(tmp_path / "logs", "W-1")
    journal.note("< order\n\x1b[0m")
    name = journal.write("why", {"order": {"orderId": "o"}})
    stored = json.loads((tmp_path / "logs" / name).read_text("utf-8"))
    assert (stored["reason"], stored["order"], len(stored["lately"])) == ("why", {"orderId": "o"}, 1)
    assert "\x1b" not in stored["lately"][0]
    for n in range(4):
        (tmp_path / "logs" / f"W-1-2020{n}.json").write_text("{}")
    journal.write("again", {})
    assert len(list((tmp_path / "logs").iterdir())) == 2
