"""Printing, places of files, PNG, pictures and the screen of `woosh watch`."""

from __future__ import annotations

import io
import json
import logging
import math
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from rosproto import profile as config
from rosproto.errors import ConnectionLost
from rosproto.json_values import plain
from rosproto.logs import PeerLog
from rosproto.numeric import encode_png
from rosproto.sentence import say
from rosproto.text import width
from rosproto.time import Time
from tests.support.png import read_png
from tests.support.waiting import until
from woosh_pure.cli import main
from woosh_pure.cli.commands import watch
from woosh_pure.cli.commands.devices import image_png
from woosh_pure.cli.output import LogLines, Output
from woosh_pure.cli.screen import Scene, Screen
from woosh_pure.enums import RobotState
from woosh_pure.errors import GoalFailed, MotionRefused
from woosh_pure.faults import decode_status_code
from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.maps.picture import BOTTOM, LEFT, RIGHT, ROBOT, SCAN, TOP, blank_around, chart_of
from woosh_pure.outcome import Outcome, OutcomeKind
from woosh_pure.readings import scan_in_base, scan_in_map
from woosh_pure.reasons import Readiness, Reason
from woosh_pure.values.state import Image, LaserScan

# -- printing ------------------------------------------------------------------------------------------------


def test_everything_becomes_json_without_nan() -> None:
    value = {
        "pose": Pose2D(1.0, math.nan),
        "state": RobotState.IDLE,
        "array": np.array([1.0, math.inf], np.float32),
        1: (True, None, "x", 2**64),
        "other": {3},
    }
    text = json.dumps(plain(value), allow_nan=False)
    assert json.loads(text) == {
        "pose": {"x": 1.0, "y": None, "yaw": 0.0, "frame": "map", "child": "base_link"},
        "state": "IDLE",
        "array": [1.0, None],
        "1": [True, None, "x", 2**64],
        "other": [3],
    }


def test_a_line_of_the_log_is_in_the_language_of_the_command() -> None:
    """Where a sentence or an error of one is in it; other handlers see what was said."""
    error = ValueError(say("mark {mark!r} is not in the demo's hall; it has {names}", mark="x", names="A1"))
    record = logging.LogRecord("woosh", 30, "", 1, "! %s: %s %d", (say("no answer"), error, 3), None)
    assert LogLines("zh").format(record).startswith("! 没有应答: ")
    assert LogLines("en").format(record) == record.getMessage()
    assert record.getMessage().startswith("! no answer: mark 'x' is not in")


def test_the_words_of_a_line_of_the_log_are_in_the_language_of_the_command(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """Also where one kind of event was limited: what was left out is counted in that language, too."""
    seconds = 0.0
    log = PeerLog("woosh", lambda: seconds)
    for number in range(12):
        log.warning("/a", "! %s: publisher %s: %s", "/a", f"/n{number}", "closed")
    seconds = 100.0
    log.warning("/a", "! %s: publisher %s: %s", "/a", "/n", "closed")
    said = [LogLines("zh").format(record) for record in caplog.records]
    assert said[0] == "! /a：发布者 /n0：closed"
    assert said[-1] == "! /a：发布者 /n：closed；另有 2 条类似的消息已省略"


def test_an_error_comes_after_no_document_only() -> None:
    stream = io.StringIO()
    out = Output(as_json=True, stream=stream)
    out.line("not this")
    out.record({"a": 1})
    out.failure("too late", 1)
    assert stream.getvalue() == '{"a": 1}\n'


def test_no_colours_where_nobody_looks() -> None:
    out = Output(stream=io.StringIO())
    assert out.colour("x", "red") == "x"


@pytest.mark.skipif(sys.platform == "win32", reason="needs a console there")
def test_colours_on_a_terminal_unless_told_not_to(monkeypatch) -> None:
    terminal = io.StringIO()
    terminal.isatty = lambda: True  # type: ignore[method-assign]
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    out = Output(stream=terminal)
    out.line(out.colour("x", "red"))
    assert terminal.getvalue() == "\x1b[31mx\x1b[0m\n"
    assert Output(stream=terminal, as_json=True).colour("x", "red") == "x"
    monkeypatch.setenv("NO_COLOR", "1")
    assert Output(stream=terminal).colour("x", "red") == "x"
    monkeypatch.delenv("NO_COLOR")
    monkeypatch.setenv("TERM", "dumb")
    assert Output(stream=terminal).colour("x", "red") == "x"


def test_a_sign_of_life_after_a_second(monkeypatch) -> None:
    monkeypatch.setattr("rosproto.cli.bag_progress.FIRST_AFTER", 0.01)
    seen = io.StringIO()
    monkeypatch.setattr(sys, "stderr", seen)
    out = Output(stream=io.StringIO())
    with out.working("thinking"):
        until(lambda: seen.getvalue().endswith("\n"), what="the first sign")
    assert seen.getvalue() == "thinking ...\n"
    monkeypatch.setattr("rosproto.cli.bag_progress.FIRST_AFTER", 60.0)
    with out.working("quick"):
        pass
    assert seen.getvalue() == "thinking ...\n"


# -- files ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("platform", "environment", "tail"),
    [
        ("linux", {"XDG_CONFIG_HOME": "/x/conf"}, ("x", "conf", "woosh")),
        ("linux", {"HOME": "/home/me", "USERPROFILE": "/home/me"}, ("me", ".config", "woosh")),
        (
            "darwin",
            {"HOME": "/Users/me", "USERPROFILE": "/Users/me"},
            ("Library", "Application Support", "woosh"),
        ),
        ("win32", {"APPDATA": "/C/Roaming"}, ("C", "Roaming", "woosh")),
        ("linux", {"WOOSH_CONFIG_DIR": "/else/where"}, ("else", "where")),
    ],
)
def test_files_are_where_each_system_keeps_them(platform, environment, tail, monkeypatch) -> None:
    for name in ("XDG_CONFIG_HOME", "APPDATA", "WOOSH_CONFIG_DIR"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(config.sys, "platform", platform)
    assert config.directory().parts[-len(tail) :] == tail


def test_a_user_without_a_home_has_no_profile(monkeypatch: pytest.MonkeyPatch) -> None:
    """A container with an arbitrary user id and no HOME; only what has to be written says what to set."""

    def no_home() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", no_home)
    for name in ("WOOSH_CONFIG_DIR", "XDG_CONFIG_HOME", "APPDATA"):
        monkeypatch.delenv(name, raising=False)
    assert config.load() is None
    with pytest.raises(FileNotFoundError, match="WOOSH_CONFIG_DIR"):
        config.save(config.Profile("10.0.0.7"))


# -- pictures ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(3, 5), (3, 5, 3), (3, 5, 4), (1, 1)])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_png_of_every_kind_is_what_a_reader_reads(shape, dtype) -> None:
    pixels = (np.arange(math.prod(shape)) * 997 % np.iinfo(dtype).max).astype(dtype).reshape(shape)
    read = read_png(encode_png(pixels))
    assert (read.reshape(shape) == pixels).all()
    assert (read_png(encode_png(np.asfortranarray(pixels)[::-1])).reshape(shape) == pixels[::-1]).all()


@pytest.mark.parametrize(
    "bad", [np.zeros((2, 2), np.float32), np.zeros((0, 2), np.uint8), np.zeros((2, 2, 2), np.uint8)]
)
def test_png_refuses_what_it_cannot_hold(bad) -> None:
    with pytest.raises(ValueError, match="cannot make a PNG of shape"):
        encode_png(bad)


def test_cameras_of_other_encodings() -> None:
    blue_first = np.array([[[255, 128, 0]]], np.uint8)
    assert image_png(Image(blue_first, "bgr8", "c")) == encode_png(blue_first[..., ::-1])
    with_alpha = np.array([[[1, 2, 3, 4]]], np.uint8)
    assert image_png(Image(with_alpha, "bgra8", "c")) == encode_png(np.array([[[3, 2, 1, 4]]], np.uint8))
    metres = np.array([[1.5, math.nan, 1e9]], np.float32)
    as_data = image_png(Image(metres, "32FC1", "c"), millimetres=True)
    assert as_data == encode_png(np.array([[1500, 0, 65535]], np.uint16))
    near_and_far = Image(np.array([[500, 0, 2500]], np.uint16), "16UC1", "c")
    assert image_png(near_and_far) == encode_png(np.array([[255, 0, 40]], np.uint8))


def test_the_robot_is_drawn_where_it_is_on_a_turned_map() -> None:
    """The map's corner is at (1, 2) and its x axis looks along the map frame's y."""
    grid = GridMap(np.zeros((20, 40), np.int8), 0.5, Pose2D(1.0, 2.0, math.pi / 2))
    pytest.importorskip("PIL", reason="needs the extra `cli`")
    pixels = chart_of(grid, scan=np.array([[-3.9, 6.1]]))[0][TOP:-BOTTOM, LEFT:-RIGHT]
    rows, columns = np.nonzero((pixels == SCAN).all(axis=2))
    scale = pixels.shape[1] / 40
    assert columns.mean() / scale == pytest.approx(4.1 / 0.5, abs=0.3)  # y - 2 along the columns
    assert 20 - rows.mean() / scale == pytest.approx(4.9 / 0.5, abs=0.3)  # 1 - x up the rows
    assert not (pixels == ROBOT).all(axis=2).any()


def test_points_off_the_map_are_left_out_and_a_huge_map_is_thinned() -> None:
    grid = GridMap(np.zeros((4, 9000), np.int8), 0.05)
    pytest.importorskip("PIL", reason="needs the extra `cli`")
    pixels, _ = chart_of(grid, pose=Pose2D(1e6, 1e6), scan=np.array([[-1e9, 0.0], [np.float64(1e9), 5.0]]))
    assert pixels.shape[1] <= 4000 + LEFT + RIGHT
    around = blank_around(np.array([[3.0, -2.0]]))
    assert around.contains(3.0, -2.0)
    assert around.contains(0.0, 0.0)
    assert blank_around(np.zeros((0, 2))).contains(0.0, 0.0)


# -- scans ---------------------------------------------------------------------------------------------------


class Fixed:
    """A chassis of which only /tf_static is known."""

    def __init__(self, *links: tuple[str, str, tuple[float, float, float], tuple[float, ...]]) -> None:
        self._links = [
            SimpleNamespace(
                header=SimpleNamespace(frame_id=parent, stamp=Time()),
                child_frame_id=child,
                transform=SimpleNamespace(
                    translation=SimpleNamespace(x=t[0], y=t[1], z=t[2]),
                    rotation=SimpleNamespace(x=q[0], y=q[1], z=q[2], w=q[3]),
                ),
            )
            for parent, child, t, q in links
        ]

    def feed(self, name: str) -> object:
        assert name == "tf_static"
        message = SimpleNamespace(transforms=self._links)
        return SimpleNamespace(history=[SimpleNamespace(message=message)])


def one_ray(angle: float, distance: float) -> LaserScan:
    ranges = np.array([distance], np.float32)
    return LaserScan(ranges, ranges[:0], angle, 0.1, 0.1, 30.0, "laser")


def test_a_scan_is_where_the_lidar_is_mounted() -> None:
    quarter = math.sqrt(0.5)
    mast = ("base_link", "mast", (1.0, 0.0, 0.5), (0.0, 0.0, quarter, quarter))  # turned left by 90°
    laser = ("/mast", "laser", (0.5, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))  # upside down
    chassis = Fixed(mast, laser)
    assert scan_in_base(chassis, one_ray(0.0, 2.0)) == pytest.approx(np.array([[1.0, 2.5]]))  # type: ignore[arg-type]
    left = scan_in_base(chassis, one_ray(math.pi / 2, 2.0))  # type: ignore[arg-type]
    assert left == pytest.approx(np.array([[3.0, 0.5]]), abs=1e-6)
    there = scan_in_map(chassis, one_ray(0.0, 2.0), Pose2D(10.0, 0.0, math.pi / 2))  # type: ignore[arg-type]
    assert there == pytest.approx(np.array([[7.5, 1.0]]), abs=1e-6)


def test_a_scan_without_transforms_or_with_a_loop_of_them_is_still_shown() -> None:
    assert scan_in_base(Fixed(), one_ray(0.0, 2.0)) == pytest.approx(np.array([[2.0, 0.0]]))  # type: ignore[arg-type]
    still = (0.0, 0.0, 0.0, 1.0)
    loop = Fixed(("a", "laser", (0.0, 0.0, 0.0), still), ("laser", "a", (0.0, 0.0, 0.0), still))
    assert scan_in_base(loop, one_ray(0.0, 2.0)) == pytest.approx(np.array([[2.0, 0.0]]))  # type: ignore[arg-type]


# -- the screen ----------------------------------------------------------------------------------------------


def full_scene() -> Scene:
    cells = np.zeros((40, 60), np.int8)
    cells[[0, -1], :] = cells[:, [0, -1]] = 100
    cells[10:12, 10:12] = -1
    return Scene(
        master_uri="http://10.0.0.7:11311",
        pose=Pose2D(1.0, 1.0, math.pi),
        velocity=Velocity(0.1, 0.0, -0.2),
        readiness=Readiness((Reason("fault", "a fault with a long explanation " * 4),)),
        faults=(decode_status_code(110201000013),),
        scan=np.array([[2.0, 1.0]]),
        nearest=0.7,
        path=[Pose2D(1.0, 1.0), Pose2D(2.5, 1.0)],
        grid=GridMap(cells, 0.05),
        rates={"pose": 10.0},
        ages={"pose": 3.0, "velocity": 0.1},
    )


@pytest.mark.parametrize(
    ("columns", "lines"), [(20, 3), (40, 10), (71, 24), (72, 24), (80, 24), (200, 60), (3, 1), (1, 9)]
)
@pytest.mark.parametrize("ascii_only", [False, True])
def test_a_picture_fits_whatever_the_terminal_is(columns, lines, ascii_only) -> None:
    for scene in (full_scene(), Scene("http://127.0.0.1:11311")):
        picture = Screen(ascii_only=ascii_only, coloured=False).render(scene, columns, lines)
        assert len(picture) <= lines
        assert max(map(len, picture)) <= columns
        assert "\x1b" not in "".join(picture)
        assert "".join(picture).isascii() or not ascii_only


def test_the_screen_says_what_matters() -> None:
    text = "\n".join(Screen(coloured=False).render(full_scene(), 100, 30))
    for words in (
        "NOT READY",
        "3 s old",
        "emergency stop",
        "nearest 0.70 m",
        "+0.10 m/s -11°/s",
        "pose           10.0",
    ):
        assert words in text
    robot = next(line for line in text.splitlines() if "←" in line)
    assert robot.index("←") < robot.index("•")
    assert "not heard" in text  # the battery
    assert "\x1b[31" in "\n".join(Screen().render(full_scene(), 100, 30))


def test_a_long_reason_is_shown_whole_where_there_is_room() -> None:
    """At the side and below the map; on a small screen three lines of it, and where the rest is."""
    words = [f"word{number:02}" for number in range(40)]
    scene = replace(full_scene(), readiness=Readiness((Reason("fault", " ".join(words)),)))

    def shown(columns: int, lines: int) -> str:
        picture = Screen(coloured=False).render(scene, columns, lines)
        assert len(picture) <= lines
        return "\n".join(picture)

    for columns, lines in ((120, 40), (120, 26), (60, 60)):
        assert all(word in shown(columns, lines) for word in words)
        assert "woosh ready" not in shown(columns, lines)
    small = shown(120, 18)
    assert "word11" in small
    assert "word39" not in small
    assert "more is in: woosh ready" in small
    assert all(fact in small for fact in ("pose", "battery", "state"))


def test_a_chinese_destination_does_not_break_the_lines() -> None:
    """A character of two columns counts as two: a line that is too long would push the picture away."""
    scene = full_scene()
    destination = "三号仓库东门卸货平台" * 4
    scene.status = SimpleNamespace(
        robot_state="idle", robot_mode="auto", task_id=1, task_type="pick", task_state="ready",
        destination=destination,
    )  # fmt: skip
    for columns in (100, 41):
        lines = Screen(coloured=False).render(scene, columns, 60)
        assert any("三号仓库" in line for line in lines)
        assert max(map(width, lines)) <= columns


def test_a_silent_chassis_is_told() -> None:
    scene = full_scene()
    scene.ages = {"pose": 9.0}
    assert "SILENT for 9 s" in "\n".join(Screen(coloured=False).render(scene, 100, 30))
    assert "not known" in "\n".join(Screen(coloured=False).render(scene, 100, 30))  # and not `ready`
    _, silent, pose, *_ = watch.one_line(scene)
    assert silent == "SILENT for 9 s, before that:"
    assert pose.startswith("x ")
    assert "SILENT" not in "".join(watch.one_line(full_scene()))


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (MotionRefused("no"), 3),
        (GoalFailed(Outcome(OutcomeKind.CONNECTION_LOST, "to A1")), 4),
        (GoalFailed(Outcome(OutcomeKind.FAILED, "to A1")), 1),
        (ConnectionLost("gone"), 4),
        (ValueError("nan"), 2),
    ],
)
def test_how_a_motion_ends_is_the_exit_code(
    error: Exception, code: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A chassis that vanishes on the way is as one that is not there to begin with."""

    def run(*_: object) -> int:
        raise error

    monkeypatch.setattr("woosh_pure.cli.commands.driving.run_goto", run)
    assert main(["goto", "A1"]) == code
