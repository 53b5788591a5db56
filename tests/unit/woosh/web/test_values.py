"""Frames, parts of the state, the journal, people and problems: values in, values out."""

from __future__ import annotations

import json
import math
import struct
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("pydantic", reason="needs the extra `web`")

from rosproto.errors import ConnectionLost, RosTimeout, ServiceError
from rosproto.sentence import say
from woosh_pure.errors import ChassisError, FirmwareLimit, MotionRefused, StaleState
from woosh_pure.faults import decode_status_code
from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.lease import LeaseState
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.maps.marks import UserMark
from woosh_pure.readiness.readiness_state import assess
from woosh_pure.reasons import Readiness, Reason
from woosh_pure.stopping.report import StopReport
from woosh_pure.web.access import Clients
from woosh_pure.web.goals import Journal, command
from woosh_pure.web.http_errors import Problem, problem_of, worded
from woosh_pure.web.live.frames import MAX_CELLS, MAX_RANGES, PART, camera_frame, costmap_frames, scan_frame
from woosh_pure.web.maps import MapCache
from woosh_pure.web.marks import mark_part
from woosh_pure.web.snapshot import (
    lease_part,
    plain,
    points_part,
    pose_part,
    readiness_part,
    said_part,
    state_parts,
    stop_part,
    text_of,
)


def test_a_scan_says_where_the_laser_is_and_what_it_saw_in_centimetres() -> None:
    ranges = np.array([1.0, 0.01, math.inf, math.nan, 12.345, 30.0], np.float32)
    frame = scan_frame(ranges, (0.05, 25.0), (-1.5, 0.5), Pose2D(1.0, -2.0, 0.25))
    kind, _, count, *place = struct.unpack_from("<BBH5f", frame)
    assert (kind, count) == (1, 6)
    assert place == [1.0, -2.0, 0.25, -1.5, 0.5]
    assert np.frombuffer(frame, "<u2", offset=24).tolist() == [100, 0, 0, 0, 1234, 0]


def test_a_scan_with_more_points_than_a_screen_shows_is_thinned() -> None:
    frame = scan_frame(np.ones(2 * MAX_RANGES + 1, np.float32), (0.0, 9.0), (0.0, 0.001), Pose2D(0.0, 0.0))
    _, _, count, *place = struct.unpack_from("<BBH5f", frame)
    assert count <= MAX_RANGES
    assert place[4] == pytest.approx(0.003)
    assert len(frame) == 24 + 2 * count


def test_a_scan_without_points_is_a_frame() -> None:
    assert len(scan_frame(np.zeros(0, np.float32), (0.0, 9.0), (0.0, 0.1), Pose2D(0.0, 0.0))) == 24


def test_a_camera_frame_names_its_source() -> None:
    assert camera_frame("color", b"jpeg") == b"\x02\x00jpeg"
    assert camera_frame("depth", b"jpeg") == b"\x02\x01jpeg"


def test_a_costmap_keeps_its_rows_and_what_is_not_known() -> None:
    (frame,) = costmap_frames(np.array([[0, 100, -1], [5, 6, 7]], np.int8), 0.05, Pose2D(1.0, 2.0, 0.5))
    assert struct.unpack_from("<BBHHH4f", frame)[:5] == (3, 0, 3, 2, 0)
    assert list(frame[24:]) == [0, 100, 255, 5, 6, 7]


def test_a_costmap_beyond_its_header_is_refused() -> None:
    for shape in ((1, 70000), (0, 5)):
        with pytest.raises(ValueError, match="cannot be shown"):
            costmap_frames(np.zeros(shape, np.int8), 0.05, Pose2D(0.0, 0.0))


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
def test_a_costmap_whose_place_is_no_number_is_refused(number: float) -> None:
    cells = np.zeros((2, 2), np.int8)
    for resolution, origin in ((number, Pose2D(0.0, 0.0)), (0.05, Pose2D(0.0, number))):
        with pytest.raises(ValueError, match="not a number"):
            costmap_frames(cells, resolution, origin)


def test_a_large_costmap_is_scaled_and_comes_in_small_parts() -> None:
    """5000 x 5000 cells were one frame of 25 MB. No cost is lost: a wall of one cell is still there."""
    cells = np.zeros((5000, 5000), np.int8)
    cells[1234, 4321], cells[4999], cells[:20, :20] = 100, 50, -1
    frames = costmap_frames(cells, 0.05, Pose2D(0.0, 0.0))
    assert sum(map(len, frames)) <= MAX_CELLS + 24 * len(frames)
    assert max(map(len, frames)) <= PART + 24
    width, height = struct.unpack_from("<HH", frames[0], 2)
    resolution = struct.unpack_from("<f", frames[0], 8)[0]
    assert width * resolution == pytest.approx(250.0)
    rows = [struct.unpack_from("<H", frame, 6)[0] for frame in frames]
    assert rows == sorted(rows)
    small = np.frombuffer(b"".join(frame[24:] for frame in frames), np.uint8).reshape(height, width)
    step = 5000 // width
    assert small[1234 // step, 4321 // step] == 100
    assert (small[-1] == 50).all()
    assert small[0, 0] == 255


def test_parts_are_null_where_nothing_was_heard() -> None:
    assert state_parts({}) == {"status": None, "battery": None, "velocity": None, "odometer": None}


@pytest.mark.parametrize(
    "value",
    [
        math.nan,
        [math.inf],
        {"a": np.array([1.0, math.nan])},
        Pose2D(1.0, 2.0),
        b"\x00\xff",
        "line\nbreak\x1b",
        (1, None, True),
    ],
)
def test_every_value_is_json(value: object) -> None:
    json.dumps(plain(value), allow_nan=False)


def test_readiness_is_three_valued() -> None:
    assert readiness_part(Readiness())["answer"] == "yes"
    part = readiness_part(Readiness((Reason("bumper", "the bumper is pressed"),)))
    assert part["answer"] == "no"
    assert part["reasons"] == [
        {"key": "bumper", "text": "the bumper is pressed", "values": {}, "blocking": True, "doubt": False}
    ]
    part = readiness_part(assess(None, [decode_status_code(110201000013)]))
    words = part["reasons"][0]["values"]["words"]
    assert words == {"english": "emergency stop 1 pressed", "chinese": "急停按钮1被按下"}


def test_what_the_robot_said_is_told_in_both_languages() -> None:
    assert said_part("") is None
    assert said_part("货架不在") == {"text": "货架不在", "text_zh": "货架不在"}
    assert said_part("status code 110201000013") == {
        "text": "emergency stop 1 pressed",
        "text_zh": "急停按钮1被按下",
    }
    assert said_part("the robot is in fault")["text_zh"] != "the robot is in fault"  # type: ignore[index]
    late = said_part(say("not finished within {seconds:.1f} s", seconds=1.0))
    assert worded(late, {"accept-language": "zh"}) == {
        "text": "not finished within 1.0 s",
        "text_zh": "时限是 1.0 秒",
    }


def test_the_text_of_a_stop_without_a_master_tells_the_cause_once() -> None:
    """Each step fails for the same reason; all of them are in `problems`."""
    failed = [
        say("cancelling {goal} ({error})", goal=f"task {n}", error="connection refused") for n in range(8)
    ]
    part = stop_part(StopReport(problems=list(failed)))
    assert part["problems"] == failed
    assert str(part["text"]).endswith("not done: cancelling task 0 (connection refused); 7 more problems")
    assert str(stop_part(StopReport(problems=failed[:1]))["text"]).endswith("task 0 (connection refused)")


def test_a_command_has_a_key_and_values_beside_its_words() -> None:
    journal = Journal()
    journal.note("anna", command("rotate", angle=0.36, speed=0.0))
    entry = journal.entries()[0].model_dump()
    assert (entry["what"], entry["key"]) == ("rotate 0.36 rad", "rotate")
    assert entry["values"] == {"angle": 0.36, "speed": 0.0}
    json.dumps(entry, allow_nan=False)


def test_a_lease_says_whose_it_is() -> None:
    state = LeaseState("anna", 12.34, ("bert",))
    assert lease_part(state) == {"holder": "anna", "seconds": 12.3, "asking": ["bert"]}
    assert lease_part(state, mine="anna")["yours"] is True
    assert lease_part(state, mine="bert")["yours"] is False


@pytest.mark.promise("200 goals and 20 bags are kept")
def test_the_journal_keeps_its_last_entries_and_how_they_ended() -> None:
    journal = Journal(3)
    numbers = [journal.begin("anna", f"act {i}") for i in range(5)]
    journal.end(numbers[0], "done")  # has gone: nothing is kept of it
    journal.end(numbers[4], "arrived", "at A1")
    assert [(e.id, e.state) for e in journal.entries()] == [
        (3, "under way"),
        (4, "under way"),
        (5, "arrived"),
    ]


def test_the_journal_tells_what_changed_since() -> None:
    journal = Journal()
    first = journal.begin("anna", "go to A1")
    version = journal.version
    assert journal.since(version) == []
    journal.note("bert", "stop")
    journal.end(first, "cancelled")
    assert {e.what: e.state for e in journal.since(version)} == {"go to A1": "cancelled", "stop": "done"}


def test_what_somebody_puts_into_the_journal_is_one_short_line() -> None:
    journal = Journal()
    journal.note("anna\n\x1b[31m", "x" * 5000, text="y" * 5000)
    entry = journal.entries()[0]
    assert "\n" not in entry.who
    assert "\x1b" not in entry.who
    assert len(entry.what) == 200
    assert len(entry.text) == 1000


def test_sessions_are_secret_different_and_can_be_taken_up_again() -> None:
    clients = Clients(256)
    anna, bert = clients.connect("10.0.0.1"), clients.connect("10.0.0.1")
    assert anna is not None
    assert bert is not None
    assert anna.name != bert.name
    assert anna.session not in bert.name
    clients.disconnect(anna)
    assert clients.connect("10.0.0.9", anna.session) is anna


def test_who_resumes_a_session_replaces_its_connection() -> None:
    """Once: the next one replaces the second connection, and a connection that has ended needs no replacing."""
    clients, replaced = Clients(256), []
    anna = clients.connect("10.0.0.1")
    assert anna is not None
    for number in (1, 2):
        anna.replaced = partial(replaced.append, number)
        assert clients.connect("10.0.0.1", anna.session) is anna
        assert replaced == [1, 2][:number]
    anna.replaced = partial(replaced.append, 3)
    clients.disconnect(anna)
    assert clients.connect("10.0.0.1", anna.session) is anna
    assert replaced == [1, 2]


@pytest.mark.promise("200 goals and 20 bags are kept")
def test_sessions_have_a_bound_and_those_that_went_first_make_room() -> None:
    clients = Clients(256)
    here = [clients.connect("a") for _ in range(256)]
    assert clients.connect("a") is None
    assert here[5] is not None
    clients.disconnect(here[5])
    assert clients.connect("a") is not None
    assert clients.by_session(here[5].session) is None


@pytest.mark.parametrize(
    ("error", "status", "kind"),
    [
        (MotionRefused("not now"), 409, "motion-refused"),
        (StaleState("old", topic="/pose", age=2.0), 503, "stale-state"),
        (FirmwareLimit("no", name="/x", fields=["a"], firmware="page", md5sum="0"), 501, "firmware-limit"),
        (RosTimeout("slow", what="/x", seconds=1.0), 504, "timeout"),
        (ConnectionLost("gone"), 503, "connection-lost"),
        (ServiceError("/x", "no"), 502, "service-error"),
        (ChassisError("no"), 502, "chassis-error"),
        (KeyError("x is not a feed"), 404, "not-there"),
        (ValueError("not finite"), 422, "value"),
    ],
)
def test_errors_of_the_library_are_problems_with_their_sentence(
    error: Exception, status: int, kind: str
) -> None:
    document = problem_of(error).document("/api/v1/goals")
    assert document["status"] == status
    assert document["type"] == f"urn:woosh:{kind}"
    assert document["detail"] == (error.args[0] if isinstance(error, KeyError) else str(error))
    assert document["instance"] == "/api/v1/goals"
    json.dumps(document, allow_nan=False)


def test_what_nobody_foresaw_tells_no_details(caplog: pytest.LogCaptureFixture) -> None:
    problem = problem_of(ZeroDivisionError("/home/anna/secret"))
    assert problem.status == 500
    assert "secret" not in problem.text
    assert "secret" in caplog.text


def test_a_refusal_carries_its_reasons() -> None:
    error = MotionRefused("no", readiness=Readiness((Reason("bumper", "pressed"),)))
    told = problem_of(error).facts
    assert [(one["key"], one["text"]) for one in told["reasons"]] == [("bumper", "pressed")]
    assert told["said"] is None
    assert problem_of(MotionRefused("no", robot_text="货架不在")).facts["said"]["text"] == "货架不在"


def test_a_problem_is_one_line() -> None:
    assert "\n" not in Problem(400, "two\nlines").document("/")["detail"]


def test_the_map_of_a_robot_that_was_started_again_is_fetched_at_once() -> None:
    """It may have another one; before, the old one was shown for up to half a minute."""
    asked, sources = [], [frozenset({"robot:4000"})]

    def get_map() -> GridMap:
        asked.append(len(asked))
        return GridMap(np.full((2, 2), len(asked), np.int8), 0.05, Pose2D(0.0, 0.0))

    chassis: Any = SimpleNamespace(get_map=get_map, feed=lambda _: SimpleNamespace(sources=sources[0]))
    cache = MapCache(chassis)
    first = cache.get().version
    assert cache.get().version == first
    sources[0] = frozenset({"robot:5000"})
    assert cache.get().version != first
    assert len(asked) == 2


NONE = (math.nan, math.inf, -math.inf)


@pytest.mark.parametrize("number", NONE)
def test_what_is_no_number_is_not_known(number: float) -> None:
    """A peer's NaN in one topic took the poses of the page along."""
    readings: Any = {
        "odometer": SimpleNamespace(value=number),
        "velocity": SimpleNamespace(value=Velocity(0.1, 0.0, number)),
    }
    parts = state_parts(readings)
    assert (parts["odometer"], parts["velocity"]) == (None, None)
    assert pose_part(Pose2D(1.0, number)) is None
    assert points_part([(0.0, number), (1.0, 2.0)]) == [[1.0, 2.0]]
    assert mark_part(UserMark("A1", Pose2D(number, 0.0)))["x"] is None
    assert json.loads(text_of({"deep": [{"one": number, "other": np.float32(number)}]})) == {
        "deep": [{"one": None, "other": None}]
    }
