"""The tools of `woosh mcp` in memory, by the SDK's own client: reading, and a motion inside one call."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import AsyncIterator, Callable, Coroutine, Iterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.support.extras import needs
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.geometry import Pose2D

needs("mcp")

from mcp import Client  # noqa: E402 (after the skip)
from mcp_types import ElicitResult  # noqa: E402

from woosh_pure.mcp import Limits, robots  # noqa: E402
from woosh_pure.mcp.door import Door  # noqa: E402

BOTH = pytest.mark.parametrize("mode", ["auto", "legacy"])
SPEED = 4.0
READING = (
    "state where look_at_map free_way camera marks faults history bags missions mission_status stop "
    "stop_mission say lights"
).split()
MOVING = "go_to_mark go_to_pose move turn charge park start_mission answer_mission".split()


@pytest.fixture(scope="module")
def sim() -> Iterator[SimulatedChassis]:
    with SimulatedChassis(full_graph=False, speed=SPEED) as chassis:
        yield chassis


@pytest.fixture
def chassis(sim: SimulatedChassis, tmp_path: Path) -> Iterator[Chassis]:
    sim.reset()
    with Chassis(sim.master_uri, robot_api=False, missions_state=tmp_path / "state") as one:
        one.missions.files = tmp_path
        yield one


def door(
    chassis: Chassis, limits: Limits | None = None, confirm: Any = "always", motion: bool = True
) -> Door:
    return Door(robots({"robot": chassis}), limits or Limits(), allow_motion=motion, confirm=confirm)


class Person:
    """Who is asked, and what was asked."""

    def __init__(self, *, allow: bool = True, action: str = "accept") -> None:
        self.asked: list[str] = []
        self._allow, self._action = allow, action

    async def __call__(self, ctx: Any, params: Any) -> ElicitResult:
        self.asked.append(params.message)
        content = {"allow": self._allow} if self._action == "accept" else None
        return ElicitResult(action=self._action, content=content)  # type: ignore[arg-type]


@asynccontextmanager
async def client(made: Door, person: Person | None = None, mode: str = "auto") -> AsyncIterator[Client]:
    async with Client(made.mcp, mode=mode, elicitation_callback=person) as one:  # type: ignore[arg-type]
        yield one


def run(work: Callable[[], Coroutine[Any, Any, None]]) -> None:
    asyncio.run(asyncio.wait_for(work(), 60.0))


async def until(accept: Callable[[], object]) -> None:
    end = time.monotonic() + 20.0
    while not accept():
        assert time.monotonic() < end
        await asyncio.sleep(0.02)


def moves(chassis: Chassis) -> bool:
    velocity = chassis.measured_velocity.latest
    return velocity is not None and not velocity.is_standing()


@BOTH
def test_reading_is_open_and_moving_is_not_listed(mode: str, chassis: Chassis) -> None:
    """Every tool has a description, a schema and annotations; those that read say so."""

    async def work() -> None:
        made = door(chassis, motion=False)
        async with client(made, mode=mode) as one:
            tools = {tool.name: tool for tool in (await one.list_tools()).tools}
            assert sorted(tools) == sorted(READING)
            assert all(tool.description and tool.annotations for tool in tools.values())
            reads = [
                name for name, tool in tools.items() if tool.annotations and tool.annotations.read_only_hint
            ]
            assert sorted(reads) == sorted(set(READING) - {"stop", "stop_mission", "say", "lights"})
            for name in reads:
                result = await one.call_tool(name, {})
                assert not result.is_error, (name, result.content)
                pictures = [part.type for part in result.content if part.type == "image"]
                assert pictures == (["image"] if name in ("look_at_map", "camera") else [])
                assert pictures or result.structured_content, name
            free = (await one.call_tool("free_way", {})).structured_content
            assert free is not None
            assert 1.0 < free["behind_m"] < 2.0, "the wall behind the start"
            assert {str(each.uri) for each in (await one.list_resources()).resources} == {
                "woosh://interface", "woosh://safety",
            }  # fmt: skip
            assert "/odom" in str(await one.read_resource("woosh://interface"))
            assert len((await one.list_prompts()).prompts) == 2
            assert (await one.call_tool("move", {"distance_m": 1.0})).is_error
            assert not chassis.moved

    run(work)


@BOTH
def test_a_motion_is_asked_for_told_and_written_down(mode: str, chassis: Chassis) -> None:
    """One call: the question, the progress, the outcome, the lease and the journal."""

    async def work() -> None:
        person, made, told = Person(), door(chassis), []
        holders: set[str | None] = set()

        async def progress(done: float, total: float | None, message: str | None) -> None:
            told.append(message)
            holders.add(chassis.lease.holder)

        async with client(made, person, mode) as one:
            assert set(MOVING) <= {tool.name for tool in (await one.list_tools()).tools}
            result = await one.call_tool("go_to_mark", {"mark": "A1"}, progress_callback=progress)
            moved = result.structured_content
            assert moved is not None
            assert moved["outcome"] == "reached", moved
            assert moved["metres"] > 1.0
            assert moved["pose"]["x_m"] != 0.0
            history = (await one.call_tool("history", {})).structured_content
        assert person.asked == ["Let the robot drive to the mark A1?"]
        assert told
        assert "assistant" in holders
        assert chassis.lease.holder is None
        assert history is not None
        calls = [(one["what"], one["state"]) for one in history["items"]]
        assert calls == [("go_to_mark(mark=A1)", "reached"), ("history(count=20)", "under way")]

    run(work)


@BOTH
@pytest.mark.parametrize(
    ("person", "confirm", "said"),
    [
        (None, "always", "cannot ask"),
        (Person(action="decline"), "always", "not agreed"),
        (Person(allow=False), "when-possible", "not agreed"),
        (None, "when-possible", ""),
        (Person(allow=False), "never", ""),
    ],
    ids=["cannot ask", "declines", "says no", "cannot ask, when possible", "never asked"],
)
def test_who_does_not_agree_is_not_overruled(
    mode: str, person: Person | None, confirm: str, said: str, chassis: Chassis
) -> None:
    async def work() -> None:
        async with client(door(chassis, confirm=confirm), person, mode) as one:
            result = (await one.call_tool("turn", {"angle_deg": 5})).structured_content
        assert result is not None
        assert result["outcome"] == ("refused" if said else "reached"), result
        assert said in result["sentence"]
        assert chassis.moved == (not said)

    run(work)


AREA = ((-1.0, -1.0), (1.5, -1.0), (1.5, 1.0), (-1.0, 1.0))


@pytest.mark.parametrize(
    ("limits", "tool", "arguments", "said"),
    [
        (Limits(area=AREA), "go_to_pose", {"x_m": 2.0, "y_m": 0.0}, "outside"),
        (Limits(area=AREA), "go_to_mark", {"mark": "nowhere"}, "no mark of that name"),
        (Limits(area=AREA), "move", {"distance_m": 2.0}, "area"),
        (Limits(max_distance=1.0), "move", {"distance_m": -1.2}, "1.20 m"),
        (Limits(max_distance=1.0), "start_mission", {"mission": "drives"}, "no known mark"),
        (Limits(), "start_mission", {"mission": "calls"}, "calls a service"),
    ],
)
def test_what_is_beyond_the_limits_is_refused(
    limits: Limits, tool: str, arguments: dict[str, Any], said: str, chassis: Chassis, tmp_path: Path
) -> None:
    mission = 'mission = 1\nname = "m"\n[[step]]\n'
    (tmp_path / "drives.mission.toml").write_text(mission + 'do = "move"\nmetres = 0.2\n')
    (tmp_path / "calls.mission.toml").write_text(mission + 'do = "call"\nservice = "/x"\n')

    async def work() -> None:
        async with client(door(chassis, limits), Person()) as one:
            result = (await one.call_tool(tool, arguments)).structured_content
        assert result is not None
        assert result["outcome"] == "refused", result
        assert said in result["sentence"]
        assert not chassis.moved

    run(work)


def test_arguments_beyond_reason_and_a_robot_that_is_not_ready(
    sim: SimulatedChassis, chassis: Chassis
) -> None:
    async def work() -> None:
        async with client(door(chassis, Limits(max_speed=0.3)), Person()) as one:
            for tool, arguments in (
                ("move", {"distance_m": 1e9}), ("move", {"distance_m": float("nan")}), ("turn", {"angle_deg": "x"}),
                ("move", {"distance_m": 0.5, "speed_m_per_s": 0.5}), ("go_to_mark", {"mark": ""}), ("go_to_mark", {}),
            ):  # fmt: skip
                assert (await one.call_tool(tool, arguments)).is_error, (tool, arguments)
            sim.press_emergency_stop()
            await until(lambda: not chassis.readiness().ready)
            result = (await one.call_tool("move", {"distance_m": 0.5})).structured_content
            assert result
            assert result["outcome"] == "refused"
            assert "emergency" in result["sentence"]
            assert not (await one.call_tool("stop", {})).is_error
            state = (await one.call_tool("state", {})).structured_content
            assert state
            assert state["ready"] == "no"
            assert state["reasons"]
        assert not chassis.moved

    run(work)


def test_after_a_motion_that_failed_another_is_tried(sim: SimulatedChassis, chassis: Chassis) -> None:
    """Something stands in the way, and is taken away: no person has to begin a motion in between."""

    async def work() -> None:
        async with client(door(chassis), Person()) as one:
            for outcome in ("failed", "reached"):
                if outcome == "failed":
                    sim.add_obstacle(0.7, 0.0)
                else:
                    sim.remove_obstacles()
                result = (await one.call_tool("move", {"distance_m": 0.5})).structured_content
                assert result is not None
                assert result["outcome"] == outcome, result

    run(work)


def test_only_marks_leaves_only_marks(chassis: Chassis) -> None:
    async def work() -> None:
        async with client(door(chassis, Limits(only_marks=True)), Person()) as one:
            names = {tool.name for tool in (await one.list_tools()).tools}
            assert {"go_to_mark", "stop"} <= names
            assert not {"move", "turn", "go_to_pose"} & names

    run(work)


@pytest.mark.parametrize(
    "limits", [Limits(only_marks=True), Limits(max_distance=50.0)], ids=["only", "place"]
)
def test_an_unknown_mark_is_refused_where_a_limit_needs_its_place(limits: Limits, chassis: Chassis) -> None:
    async def work() -> None:
        async with client(door(chassis, limits), Person()) as one:
            result = (await one.call_tool("go_to_mark", {"mark": "nowhere"})).structured_content
        assert result
        assert result["outcome"] == "refused"
        assert "the tool 'marks' lists them" in result["sentence"]
        assert not chassis.moved

    run(work)


@BOTH
@pytest.mark.parametrize("how", ["cancelled", "stopped", "taken over", "too long", "beyond", "path"])
def test_a_motion_ends_with_its_call_and_its_limits(how: str, mode: str, chassis: Chassis) -> None:
    """By a cancel, STOP, a person, the time; by a pose or a planned path that leaves the area."""
    limits = Limits(
        max_seconds=1.0 if how == "too long" else 120.0,
        max_speed=0.3 if how == "beyond" else None,
        area=((-1, -1), (9, -1), (9, 9), (5.2, 9), (5.2, 0.2), (4.8, 0.2), (4.8, 9), (-1, 9))
        if how == "path"
        else (),
    )
    target = ("go_to_pose", {"x_m": 6.0, "y_m": 2.5}) if how == "path" else ("go_to_mark", {"mark": "A2"})

    async def work() -> None:
        async with client(door(chassis, limits), Person(), mode) as one:
            call = asyncio.ensure_future(one.call_tool(*target))
            if how in ("cancelled", "stopped", "taken over"):
                await until(lambda: moves(chassis))
                second = (await one.call_tool("turn", {"angle_deg": 5})).structured_content
                assert second
                assert second["outcome"] == "refused"
                assert "another call" in second["sentence"]
            if how == "cancelled":
                call.cancel()
                await asyncio.gather(call, return_exceptions=True)
            elif how == "stopped":
                await asyncio.to_thread(chassis.stop)
            elif how == "taken over":
                assert chassis.lease.request("a person")
                assert chassis.lease.take_over("a person", "assistant")
            if how != "cancelled":
                result = (await call).structured_content
                assert result is not None
                assert result["outcome"] == "stopped", result
            await until(lambda: not chassis.under_way and not moves(chassis))
            await until(lambda: chassis.lease.holder == ("a person" if how == "taken over" else None))
        assert chassis.pose.wait().distance_to(Pose2D(5.5, 2.5)) > 0.3, "it has not arrived"

    run(work)


def test_a_mission_lives_in_its_call(
    chassis: Chassis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It asks, is answered, and ends; another ends with its cancelled call, also with one that is just beginning."""
    text = 'mission = 1\nname = "m"\n[[step]]\ndo = "ask"\ntext = "Go?"\n[step.answers]\nyes = "next"\nno = "end"\n'
    (tmp_path / "m.mission.toml").write_text(text + '[[step]]\ndo = "move"\nmetres = 0.3\n')
    run_it, cancelled = chassis.missions.run, threading.Event()

    def slow_run(*given: Any, **more: Any) -> Any:
        """It has begun, and this is heard of only after the call was cancelled."""
        cancelled.clear()
        handle = run_it(*given, **more)
        assert cancelled.wait(20.0)
        time.sleep(0.3)  # for the cancel to arrive
        return handle

    async def work() -> None:
        for end in ("answered", "cancelled", "cancelled at once"):
            if end == "cancelled at once":
                monkeypatch.setattr(chassis.missions, "run", slow_run)
            async with client(door(chassis), Person()) as one:
                call = asyncio.ensure_future(one.call_tool("start_mission", {"mission": "m"}))
                await until(lambda: chassis.missions.state.run and chassis.missions.state.run.question)
                if end == "answered":
                    assert not (await one.call_tool("answer_mission", {"answer": "yes"})).is_error
                    result = (await call).structured_content
                    assert result is not None
                    assert result["outcome"] == "reached", result
                else:
                    call.cancel()
                    cancelled.set()
                    await until(lambda: chassis.missions.state.active is None)
                await until(lambda: chassis.lease.holder is None)

    run(work)


def test_several_robots_are_called_by_name(sim: SimulatedChassis, chassis: Chassis) -> None:
    async def work() -> None:
        made = Door(
            robots({"north": chassis, "south": chassis}), Limits(), allow_motion=True, confirm="always"
        )
        person = Person()
        async with client(made, person) as one:
            for tool in (await one.list_tools()).tools:
                assert tool.input_schema["properties"]["robot"]["enum"] == ["north", "south"], tool.name
            moved = (await one.call_tool("turn", {"angle_deg": 5, "robot": "south"})).structured_content
            assert moved
            assert moved["outcome"] == "reached"
            assert person.asked[0].startswith("south: ")
            assert (await one.call_tool("state", {"robot": "east"})).is_error
            assert (await one.call_tool("state", {})).is_error

    run(work)
