"""Actions of the user's own: functions, programs, and what cannot be one."""

from __future__ import annotations

import shlex
import subprocess
import sys
from typing import Any, cast

import pytest

from woosh_pure.errors import ChassisError
from woosh_pure.fleet.abilities import Task, abilities_of
from woosh_pure.fleet.actions import Scope
from woosh_pure.fleet.config import VehicleConfig
from woosh_pure.fleet.messages import Action


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
    ability, doing = abilities_of(config(turn=f"{__name__}:turn"))["turn"]
    assert (ability.moves, ability.scopes, ability.description) == (True, (Scope.NODE,), "Turn it.")
    assert doing(task(by=3)) == "turned 3"


@pytest.mark.parametrize("target", ["nowhere", "no.such.module:f", "os:nothing", "os:sep", "!"])
def test_what_is_no_function_is_said_at_the_start(target: str) -> None:
    """And not when the fleet manager asks for it."""
    with pytest.raises(ValueError, match="action"):
        abilities_of(config(x=target))


def test_the_standards_own_are_not_replaced() -> None:
    """cancelOrder stays what it is."""
    with pytest.raises(ValueError, match="cancelOrder"):
        abilities_of(config(cancelOrder="!true"))


def program(script: str) -> str:
    """A Python program as an action, quoted as this system's own command line is."""
    words = [sys.executable, "-c", script]
    return "!" + (subprocess.list2cmdline(words) if sys.platform == "win32" else shlex.join(words))


def test_a_program_gets_the_parameters_and_gives_the_result() -> None:
    """As JSON on its standard input; no shell looks at anything."""
    script = 'import json, sys; print(json.load(sys.stdin)["parameters"]["by"] * 2)'
    _, doing = abilities_of(config(x=program(script)))["x"]
    assert doing(task(by="$(id);")) == "$(id);$(id);"


def test_a_program_speaks_utf8() -> None:
    """Whatever the locale is; a byte that is none is shown, not raised."""
    script = 'import sys; sys.stdout.buffer.write("\\u5230\\u8fbe".encode() + bytes([0xFF]))'
    _, doing = abilities_of(config(x=program(script)))["x"]
    assert doing(task()) == "\u5230\u8fbe\ufffd"


def test_a_program_that_fails_says_why() -> None:
    """Its exit code and its last words."""
    _, doing = abilities_of(config(x=program('import sys; sys.exit("no load")')))["x"]
    with pytest.raises(ChassisError, match="ended with 1: no load"):
        doing(task())


def test_a_program_is_ended_with_its_action() -> None:
    """It is asked to end, and FAILED."""
    _, doing = abilities_of(config(x=program("import time; time.sleep(60)")))["x"]
    given = task()
    given.cancelled.set()
    with pytest.raises(ChassisError, match=f"ended with {1 if sys.platform == 'win32' else -15}"):
        doing(given)


def test_what_is_not_configured_is_not_offered() -> None:
    """Charging wants a charger, pick and drop want marks."""
    assert set(abilities_of(config())) == {"initPosition"}
    full = VehicleConfig(manufacturer="W", serial="1", marks=True, charger="C1")
    assert set(abilities_of(full)) == {"initPosition", "startCharging", "pick", "drop"}
