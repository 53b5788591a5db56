"""Wrong guesses of names and arguments name the right call, and nothing else sees that."""

from __future__ import annotations

import asyncio
import copy
import inspect
import math
import pickle
import re
from collections.abc import Callable
from functools import partial
from unittest import mock

import numpy as np
import pytest

import woosh_pure.chassis as chassis_module
from rosproto.errors import ConnectionLost
from woosh_pure import Chassis, Outcome, OutcomeKind, Pose2D, SimulatedChassis, aio, hints
from woosh_pure.faults import Faults
from woosh_pure.feed.feed import Feed
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.motion import verbs
from woosh_pure.motion.action_goal import ActionMotion
from woosh_pure.motion.motion import GoalHandle
from woosh_pure.motion.progress import Progress
from woosh_pure.stopping.report import StopReport

CHASSIS = Chassis("127.0.0.1:9")
HANDLE = GoalHandle(ActionMotion(None, "/a", "a goal"), None)  # type: ignore[arg-type]
OUTCOME = Outcome(OutcomeKind.FAILED, "a goal")
POSE, SIMULATED = Pose2D(1.0, 2.0), SimulatedChassis()
GUESSES = [
    # turtle
    *[(CHASSIS, name) for name in ("fd", "bk", "back", "lt", "rt", "goto", "setpos", "setheading", "xcor", "pencolor")],
    # rospy and MoveBaseAction programs
    *[(CHASSIS, name) for name in ("cmd_vel", "publish", "send_goal", "odom", "move_base", "wait_for_server")],
    # spot-sdk
    *[(CHASSIS, name) for name in ("estop", "go_home", "dock", "trajectory_command", "get_state")],
    # MiR, pyrobot
    *[(CHASSIS, name) for name in ("mission", "positions", "get_status", "go_to_pose", "get_velocity")],
    *[(CHASSIS, name) for name in ("set_velocity", "errors", "state", "battery_percentage")],
    # Thymio
    *[(CHASSIS, name) for name in ("motors", "motor_left_target", "prox", "leds_top", "sound")],
    # anybody
    *[(CHASSIS, name) for name in ("drive", "turn", "position", "x", "is_moving", "marks", "cancel", "set_speed")],
    *[(CHASSIS, name) for name in ("get_pose", "get_battery", "wait", "halt", "connect", "image", "led", "speak")],
    *[(CHASSIS.battery, name) for name in ("percent", "charging", "value", "get", "subscribe")],
    *[(CHASSIS.pose, name) for name in ("x", "y", "yaw", "theta", "read")],
    *[(HANDLE, name) for name in ("cancelled", "result", "is_done", "status", "join", "then", "stop", "feedback")],
    *[(OUTCOME, name) for name in ("success", "message", "ok", "status", "error")],
    *[(CHASSIS.aio, name) for name in ("goto", "turn", "x")],
    # a class that saw the pages alone
    *[(CHASSIS, name) for name in ("go", "turnRight", "get_position", "getPosition", "distance", "sensor", "obstacle")],
    *[(CHASSIS, name) for name in ("reset", "distance_to", "on_disconnect", "on_lost", "on_connected", "subscribe", "on")],
    *[(CHASSIS, name) for name in ("pause", "on_battery", "get_marks", "timeout")],
    *[(CHASSIS.battery, "percentage"), (CHASSIS.battery, "level"), (HANDLE, "on_failed")],
    *[(Progress(None, None, 0.0, None), "percentage"), (StopReport(), "stopped"), (StopReport(), "ok")],
    *[(GridMap(np.zeros((1, 1), np.int8), 1.0), "to_image"), (Faults(), "latest")],
    *[(POSE, name) for name in ("angle", "heading", "position", "distance")],
    *[(SIMULATED, name) for name in ("estop", "move", "forward", "obstacle", "setPose", "restart", "uri", "battery_level")],
]  # fmt: skip


@pytest.mark.parametrize(("thing", "name"), GUESSES, ids=[f"{type(t).__name__}.{n}" for t, n in GUESSES])
def test_a_guess_names_what_there_is(thing: object, name: str) -> None:
    with pytest.raises(AttributeError, match=f"no attribute '{name}'; use ") as caught:
        getattr(thing, name)
    assert (caught.value.name, caught.value.obj) == (name, thing)


TABLES = [(hints.CHASSIS, Chassis), (hints.HANDLE, GoalHandle), (hints.OUTCOME, Outcome), (hints.FEED, Feed)]
TABLES += [(hints.PROGRESS, Progress), (hints.STOP, StopReport), (hints.MAP, GridMap), (hints.FAULTS, Faults)]
TABLES += [(hints.POSE, Pose2D), (hints.SIMULATED, SimulatedChassis)]


@pytest.mark.parametrize(("table", "cls"), TABLES, ids=[cls.__name__ for _, cls in TABLES])
def test_a_table_names_members_and_hides_none(table: str, cls: type) -> None:
    lines = [line.rpartition(": ") for line in table.strip().splitlines()]
    names = [name for _, _, guesses in lines for name in guesses.split()]
    assert len(names) == len(set(names)), "a guess has one answer"
    assert not [name for name in names if name in dir(cls)]
    for right, _, _ in lines:
        assert re.match(r"\w+", right).group() in [*dir(cls), cls.__name__]


def test_a_value_is_waited_for_where_a_hint_names_a_feed() -> None:
    """`.latest` is None before the first value, and a hint to it alone led to the next error."""
    rows = [line.rpartition(": ")[0] for line in f"{hints.CHASSIS}{hints.FEED}".splitlines()]
    assert [right for right in rows if "latest" in right and "wait(timeout=5)" not in right] == []


def test_there_are_many() -> None:
    assert len(GUESSES) > 60


@pytest.mark.parametrize("thing", [CHASSIS, HANDLE, OUTCOME, CHASSIS.battery], ids=lambda t: type(t).__name__)
def test_what_is_not_there_is_not_there(thing: object) -> None:
    assert not hasattr(thing, "goto")
    assert getattr(thing, "percent_", None) is None
    assert "goto" not in dir(thing)
    with pytest.raises(AttributeError, match=r"no attribute 'nobody_guesses_this'$"):
        thing.nobody_guesses_this  # type: ignore[attr-defined]  # noqa: B018


def test_copies_pickles_and_mocks_are_as_before() -> None:
    assert pickle.loads(pickle.dumps(OUTCOME)) == OUTCOME == copy.deepcopy(OUTCOME)
    assert copy.copy(HANDLE).description == "a goal"
    robot = mock.create_autospec(Chassis, instance=True)
    robot.go_to_mark("A1")
    with pytest.raises(AttributeError):
        robot.goto  # noqa: B018
    assert callable(robot.forward)


def test_a_class_of_a_program_may_have_another_metaclass() -> None:
    """As of a graphical library; Chassis has that of object."""

    class Meta(type):
        pass

    class Robot(Chassis, metaclass=Meta):
        pass

    assert isinstance(Robot, Meta)
    assert type(Chassis) is type


def test_a_property_that_fails_says_its_own_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not that there is no such attribute."""
    monkeypatch.setattr(Chassis, "scan", property(lambda self: self.lease.nothing_like_it))
    with pytest.raises(AttributeError, match="nothing_like_it"):
        CHASSIS.scan  # noqa: B018


@pytest.mark.parametrize(
    ("call", "right"),
    [
        (lambda c: c.go_to("A1"), "go_to_mark"),
        (lambda c: c.go_to(), "go_to_mark"),
        (lambda c: c.go_to_mark(), r"go_to_mark\(name\)"),
        (lambda c: c.go_to_mark(1, 2), r"go_to\(x, y, yaw\)"),
        (lambda c: c.rotate(degrees=90), r"rotate\(angle, degrees=True\)"),
        (lambda c: c.forward(0, 5), r"forward\(metres\), with a decimal point"),
        (lambda c: c.left(90, 0.5), r"left\(degrees, speed=number\)"),
        (lambda c: c.strafe(0, 5), r"strafe\(metres\)"),
        (lambda c: c.right(wait=True), r"right\(degrees\)"),
        (lambda c: c.rotate(), r"left\(degrees\)"),
        (lambda c: c.move(0.2, 0.1), "rotate"),
        (lambda c: c.move(x=0.5), r"move\(metres\)"),
        (lambda c: c.velocity(0.2, 0.1), "bypasses_protection=True"),
        (lambda c: c.velocity(vx=0.2), "drive.hold"),
    ],
)
def test_wrong_arguments_name_the_right_call(call, right: str) -> None:
    with pytest.raises(TypeError, match=right):
        call(CHASSIS)


@pytest.mark.parametrize("name", ["charge", "say", "set_pose", "go_to_mark", "readiness", "wait_until"])
def test_an_error_of_arguments_names_the_class_of_the_user(name: str) -> None:
    """Not a part of it: MotionVerbs.charge() is not in the documentation."""
    with pytest.raises(TypeError, match=rf"^Chassis\.{name}\(\)"):
        getattr(CHASSIS, name)(no_such_argument=1)


@pytest.mark.parametrize("cls", [Chassis, aio.Chassis])
def test_a_port_of_its_own_is_answered_by_the_form_of_an_address(cls: type) -> None:
    with pytest.raises(TypeError, match=r'Chassis\("192.168.1.20:11311"\) with the port of its master'):
        cls("127.0.0.1", port=9)


def test_a_pose_names_its_parts_when_it_is_taken_for_a_list() -> None:
    for take in (lambda: POSE[0], lambda: list(POSE), lambda: 1.0 in POSE):  # type: ignore[index,arg-type,operator,call-overload]
        with pytest.raises(TypeError, match=r"^'Pose2D' object is not subscriptable; use x, y and yaw$"):
            take()
    assert np.array([POSE]).dtype == object


ROUNDED = [1.57, -3.14, 6.28, 0.785, 0.78, 0.79, 0.52, 1.05, 2.09, 2.36, 4.71, 0.26, 1.571, 3.142]


def degrees_said(caplog: pytest.LogCaptureFixture, turn: Callable[..., object], angle: float) -> list[str]:
    caplog.clear()
    with pytest.raises(ConnectionLost):
        turn(angle)
    return [record.message for record in caplog.records if "rotate(angle) rad" in record.message]


@pytest.mark.parametrize("angle", [math.pi / 2, 1.5708, -math.pi, math.radians(30), 2 * math.pi, *ROUNDED])
def test_a_turn_in_degrees_that_is_meant_in_rad_is_logged(
    caplog: pytest.LogCaptureFixture, angle: float
) -> None:
    """It is carried out as it stands: 1.5708 degrees are legal."""
    for turn in (CHASSIS.left, CHASSIS.right, partial(CHASSIS.rotate, degrees=True)):
        said = degrees_said(caplog, turn, angle)
        assert [f"{math.degrees(abs(angle)):.0f}° was meant:" in text for text in said] == [True]


@pytest.mark.parametrize(
    "angle", [1, 2, 3, 90, 0.5, 1.5, 2.5, 5, -3.0, 5.5, 6.5, 0.01, 0.25, 1.25, 360, 4 * math.pi, 1.567241]
)
def test_other_turns_are_not_commented_on(caplog: pytest.LogCaptureFixture, angle: float) -> None:
    assert degrees_said(caplog, CHASSIS.left, angle) == []


def test_no_hint_to_copy_moves_the_robot_as_it_stands() -> None:
    """Its way is a placeholder: who pastes it is asked for a number, or for a mark."""
    rows = [
        line.rpartition(": ")[0] for table in (hints.COMMANDS, hints.CHASSIS) for line in table.split("\n")
    ]
    used = "".join(inspect.getsource(module) for module in (verbs, chassis_module))
    for right in [*rows, *re.findall(r"@usage\(.*", used)]:
        moving = r"woosh (move|rotate) -?\d|\b(forward|move|left|right|rotate|strafe|go_to|hold)\(-?\d|(A|C)1"
        assert not re.search(moving, right), right


@pytest.mark.parametrize("cls", [Chassis, aio.Chassis])
@pytest.mark.parametrize("name", ["go_to", "go_to_mark", "move", "rotate", "velocity"])
def test_editors_see_the_arguments(cls: type, name: str) -> None:
    signature = inspect.signature(getattr(cls, name))
    assert "args" not in signature.parameters
    assert inspect.getdoc(getattr(cls, name))


@pytest.mark.parametrize("name", ["Robot", "Chasis", "Simulator"])
def test_a_wrong_class_is_answered_by_the_right_one(name: str) -> None:
    with pytest.raises(
        ImportError, match=f"cannot import name '{name}' from 'woosh_pure'; use (Simulated)?Chassis$"
    ):
        exec(f"from woosh_pure import {name}", {})


def test_a_guess_that_is_set_is_refused_and_another_name_is_the_programs_own() -> None:
    for chassis in (Chassis("127.0.0.1:9"), aio.Chassis("127.0.0.1:9")):
        with pytest.raises(
            AttributeError, match=r"no attribute 'speed' to set; .*forward\(metres, speed=number\)"
        ):
            chassis.speed = 0.5  # type: ignore[union-attr]
        chassis.number = 3  # type: ignore[union-attr]
        assert chassis.number == 3  # type: ignore[union-attr]


def test_a_feed_names_its_value_when_it_is_printed_or_called() -> None:
    assert repr(CHASSIS.battery).endswith("; see .wait(timeout=5) and .latest>")
    for feed in (CHASSIS.battery, CHASSIS.aio.battery):
        with pytest.raises(TypeError, match=r"not callable; use \.wait\(timeout=5\), or \.latest"):
            feed()  # type: ignore[operator]


@pytest.mark.parametrize("callback", [5, None], ids=repr)
@pytest.mark.parametrize(
    "register",
    [CHASSIS.battery.on, CHASSIS.on_connection, CHASSIS.lease.on, HANDLE.on_done, HANDLE.on_progress],
    ids=lambda method: method.__qualname__,
)
def test_what_is_not_a_function_is_refused_where_it_is_given(register, callback: object) -> None:
    """Before a thread or a link is made for it: `on(show())` gives None."""
    with pytest.raises(
        TypeError, match=f"the callback must be a function, not {callback}; give its name with"
    ):
        register(callback)


def test_asyncio_refuses_what_is_not_a_function() -> None:
    async def register(on) -> None:
        await on(5)

    for on in (CHASSIS.aio.battery.on, CHASSIS.aio.on_connection):
        with pytest.raises(TypeError, match="must be a function, not 5"):
            asyncio.run(register(on))


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: CHASSIS.move(None), "distance"),
        (lambda: CHASSIS.forward(None), "distance"),
        (lambda: CHASSIS.rotate(None), "angle"),
        (lambda: CHASSIS.left(None), "angle"),
        (lambda: CHASSIS.right(None), "degrees"),
        (lambda: CHASSIS.move(0.5, speed=None), "speed"),
        (lambda: CHASSIS.move_diagonal(0.5, None, degrees=True), "angle"),
    ],
)
def test_none_is_not_a_number_and_the_parameter_is_named(call, name: str) -> None:
    with pytest.raises(TypeError, match=f"^{name}=None is not a number; expected one, such as 0.5$"):
        call()


@pytest.mark.parametrize("mode", ["avoid", None, 1.5], ids=repr)
def test_a_wrong_mode_is_answered_by_the_modes_there_are(mode: object) -> None:
    with pytest.raises(ValueError, match=r"is not a valid NavigationMode; one of: NavigationMode\.\w+, Nav"):
        CHASSIS.set_navigation_mode(mode)  # type: ignore[arg-type]


def test_a_command_that_is_meant_is_there() -> None:
    from woosh_pure.cli.commands import COMMANDS

    lines = [line.rpartition(": ") for line in hints.COMMANDS.strip().splitlines()]
    guesses = [guess for _, _, words in lines for guess in words.split()]
    assert len(guesses) == len(set(guesses))
    assert not set(guesses) & set(COMMANDS)
    for right, _, guesses in lines:
        program, *words = hints.meant(hints.COMMANDS, guesses.split()[0]).split()
        assert "GUESS" not in words, right
        word = next((word for word in words if not word.startswith("-")), "")
        assert program == "rosproto" or not word or word in COMMANDS
    for (
        guess
    ) in "version simulate simulator browser show gui view open page list distance reset help exit".split():
        assert hints.meant(hints.COMMANDS, guess)
