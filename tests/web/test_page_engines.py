"""The page in Firefox and in WebKit, against `woosh_pure.web` and the simulated chassis: what moves, and what ends it.

Every control once is Chromium's (`test_page_robot.py`); here is what engines do differently: modules, canvas,
WebSockets, pointers that are held, tabs that are closed. $WOOSH_PICTURES names a folder for the pictures.
"""

from __future__ import annotations

import os
import struct
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.support.browser import DESKTOP, PHONE
from tests.support.engines import ENGINES, Engine, Window
from tests.support.web import Velocities

if TYPE_CHECKING:
    from tests.web.conftest import Robot

pytestmark = pytest.mark.slow
PROMISED = 0.5
"""Seconds from letting go to the zero."""


@pytest.fixture(scope="module", params=list(ENGINES))
def engine(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Engine]:
    """One browser of each kind for the whole file."""
    with ENGINES[request.param](tmp_path_factory.mktemp("engine") / request.param) as running:
        yield running


@pytest.fixture
def witness(robot: Robot) -> Iterator[Velocities]:
    """Hears what is sent to the robot."""
    with Velocities(robot.sim.master_uri) as heard:
        yield heard


@contextmanager
def window(
    engine: Engine, robot: Robot, size: tuple[int, int] = DESKTOP, *, closes: bool = True
) -> Iterator[Window]:
    """Somebody who opens the page; at the end no script of it has failed."""
    opened = engine.open(robot.url)
    try:
        opened.resize(*size)
        opened.shows(".markrow")
        yield opened
    finally:
        if closes:
            opened.close()
    assert engine.errors() == []


def until(condition: Callable[[], bool], seconds: float = 20.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "it did not come true"
        time.sleep(0.03)


def kept(opened: Window, name: str, size: tuple[int, int]) -> None:
    """A picture of just this size; kept where somebody wants to look."""
    picture = opened.picture()
    assert struct.unpack(">II", picture[16:24]) == size
    if folder := os.environ.get("WOOSH_PICTURES"):
        Path(folder, f"{name}.png").write_bytes(picture)


def test_it_is_drawn_and_fits_in_both_languages(
    engine: Engine, robot: Robot, request: pytest.FixtureRequest
) -> None:
    """The map has walls, floor and robot; nothing runs out of either screen; every tab of the panel opens."""
    name = request.node.callspec.params["engine"]
    with window(engine, robot) as opened:
        for language, word in (("en", "STOP"), ("zh", "停止")):
            opened.until(f"document.querySelector('#stop').innerText.trim() === '{word}'")
            for size in (DESKTOP, PHONE):
                opened.resize(*size)
                for tab in ("drive", "camera", "health", "log", "go"):
                    opened.click(f"#tabbutton-{tab}")
                    opened.until(f"document.querySelector('#tab-{tab}').getClientRects().length > 0")
                    wide = opened.evaluate(
                        "[document.documentElement.scrollWidth, document.documentElement.scrollHeight]"
                    )
                    assert tuple(wide) == size, tab
                    panel = "document.querySelector('#panel')"
                    assert opened.evaluate(f"{panel}.scrollWidth <= {panel}.clientWidth"), tab
                colours = (
                    "(() => { const c = document.querySelector('#canvas'); const d = new Uint32Array("
                    "c.getContext('2d').getImageData(0, 0, c.width, c.height).data.buffer);"
                    "return new Set(d).size; })()"
                )
                opened.until(f"{colours} > 8")
                kept(opened, f"{name}-{language}-{size[0]}", size)
            opened.resize(*DESKTOP)
            opened.click("#language")


def test_it_goes_to_a_mark_and_stop_ends_the_next_way(engine: Engine, robot: Robot) -> None:
    """Two touches, and it arrives; one touch, and it stands, said in words."""
    with window(engine, robot, PHONE) as opened:
        opened.click(".markrow", "P1")
        opened.click("#confirm button[type=submit]")
        opened.shows("#task", "Arrived", 60)
        mark = robot.sim.world.site.marks["P1"].pose
        assert robot.away(mark.x, mark.y) < 0.3
        opened.click(".markrow", "B1")
        opened.click("#confirm button[type=submit]")
        until(lambda: robot.speed > 0.1)
        opened.click("#stop")
        opened.shows("#stop-answer", "The robot stands still.")
        assert robot.speed < 0.02


def allow(opened: Window) -> None:
    """Switch driving on, as a person does."""
    opened.click("#tabbutton-drive")
    opened.click("#drive-on")
    opened.click("#warning-check")
    opened.click("#warning-yes")
    opened.shows(".pad")
    opened.shows(".lease", "You have control.")


def hold(opened: Window, witness: Velocities) -> None:
    """The mouse on the pad, forward, until the robot is told to move: a page that a busy computer holds up lets go,
    and is pressed again.
    """
    x, y = opened.point(".pad")
    for _ in range(5):
        since = time.monotonic()
        opened.move(x, y)
        opened.down()
        opened.move(x, y - 70)
        if witness.moves(since):
            return
        opened.up()
    pytest.fail("this computer is too busy to hold anything")


def test_the_hand_let_go_is_a_zero_at_once(engine: Engine, robot: Robot, witness: Velocities) -> None:
    """While it is held it goes on; within half a second after the button came up the robot is told to stand."""
    with window(engine, robot) as opened:
        allow(opened)
        hold(opened, witness)
        opened.shows(".drivestate.driving")
        began = time.monotonic()
        opened.up()
        assert witness.seconds_to_zero(began) < PROMISED
        opened.shows(".drivestate", "Ready to drive")


def test_a_closed_tab_is_a_zero_at_once(engine: Engine, robot: Robot, witness: Velocities) -> None:
    """The tab is closed while the pad is held; control is given back too."""
    with window(engine, robot, closes=False) as opened:
        allow(opened)
        hold(opened, witness)
        opened.close()
        began = time.monotonic()
        assert witness.seconds_to_zero(began) < PROMISED
        until(lambda: robot.chassis.lease.holder is None)


def test_arrow_keys_drive_while_they_are_down(engine: Engine, robot: Robot, witness: Velocities) -> None:
    """One key held is one drive."""
    with window(engine, robot) as opened:
        allow(opened)
        opened.evaluate("document.activeElement.blur()")
        for _ in range(5):
            since = time.monotonic()
            opened.key("\ue013", down=True)
            if witness.moves(since):
                break
            opened.key("\ue013", down=False)
        began = time.monotonic()
        opened.key("\ue013", down=False)
        assert witness.seconds_to_zero(began) < PROMISED
        assert any(vx > 0.05 for at, vx, _ in witness.heard if since < at < began)
