"""The page in a real browser, against `woosh_pure.web` and the simulated chassis: every control once."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import pytest

from tests.support.browser import DESKTOP, PHONE, opened, person
from woosh_pure import Chassis, SimulatedChassis

if TYPE_CHECKING:
    from pathlib import Path

    from playwright.sync_api import Browser, Page

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with opened() as one:
        yield one


class Robot:
    """The simulated chassis behind a served page."""

    def __init__(self, sim: SimulatedChassis, chassis: Chassis, url: str) -> None:
        self.sim, self.chassis, self.url = sim, chassis, url

    @property
    def place(self) -> tuple[float, float]:
        pose = self.chassis.pose.wait(timeout=5.0)
        return pose.x, pose.y

    @property
    def speed(self) -> float:
        velocity = self.chassis.measured_velocity.wait(timeout=5.0)
        return abs(velocity.vx) + abs(velocity.wz)


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Robot]:
    for module in ("fastapi", "uvicorn", "websockets", "PIL"):
        pytest.importorskip(module, reason=f"{module} is not installed: pip install 'woosh-pure[web]'")
    from woosh_pure import web
    from woosh_pure.sim.site import built_in_site
    from woosh_pure.web.maps import WebMark
    from woosh_pure.web.serve import WebServer

    marks = [WebMark(name, mark.pose, mark.charger) for name, mark in built_in_site().marks.items()]
    with SimulatedChassis(speed=3) as sim, Chassis(sim.master_uri) as chassis:
        app = web.app({"sim": chassis}, allow_driving=True, marks=marks, recordings=tmp_path)
        with WebServer(app, port=0) as server:
            yield Robot(sim, chassis, server.url)


def until(condition: Callable[[], Any], page: Page, seconds: float = 20.0) -> Any:
    deadline = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < deadline, "it did not come true"
        page.wait_for_timeout(50)
    return found


def away(robot: Robot, x: float, y: float) -> float:
    here = robot.place
    return float(((here[0] - x) ** 2 + (here[1] - y) ** 2) ** 0.5)


@pytest.mark.parametrize(
    ("size", "language"),
    [pytest.param(PHONE, "zh-CN", id="phone-zh"), pytest.param(DESKTOP, "en-US", id="desktop-en")],
)
def test_two_touches_drive_to_a_mark(browser: Browser, robot: Robot, size: Any, language: str) -> None:
    """First sight: the mark, then start. Nothing is to be set before; it arrives, and the page says so."""
    arrived = {"zh-CN": "已到达", "en-US": "Arrived"}[language]
    with person(browser, robot.url, size, language=language) as page:
        page.click(".markrow >> text=A1")
        page.click("#confirm button[type=submit]")
        page.wait_for_selector("#task progress")
        page.wait_for_selector(f"#task >> text={arrived}", timeout=60_000)
        mark = robot.sim.site.marks["A1"].pose if hasattr(robot.sim, "site") else None
        if mark is not None:
            assert away(robot, mark.x, mark.y) < 0.3
        page.click("#task .close")
        page.wait_for_selector("#task", state="hidden")


def test_a_mark_on_the_map_can_be_touched(browser: Browser, robot: Robot) -> None:
    """The pin asks the same question as the list."""
    with person(browser, robot.url) as page:
        page.wait_for_timeout(1500)  # the map is fitted when its picture has come
        box = page.locator("#canvas").bounding_box()
        assert box is not None
        for column in range(24):  # pins stand somewhere in the picture: the page knows where, the test looks
            for row in range(16):
                page.mouse.click(box["x"] + 20 + column * 36, box["y"] + 60 + row * 40)
                if page.is_visible("#confirm"):
                    assert page.inner_text("#confirm-text").startswith("Go to ")
                    return
        pytest.fail("no pin was found")


def test_pause_resume_and_cancel(browser: Browser, robot: Robot) -> None:
    """While under way; the list of what was done tells each."""
    with person(browser, robot.url) as page:
        page.click(".markrow >> text=B1")
        page.click("#confirm button[type=submit]")
        page.click("#pause")
        page.click("#resume")
        page.wait_for_selector("#pause")
        page.click("#cancel")
        page.wait_for_selector("#task >> text=Cancelled")
        page.click("#tabbutton-log")
        text = page.inner_text("#journal")
        for line in ("Go to B1", "Pause no. 1", "Go on with no. 1", "Cancel no. 1", "page 1"):
            assert line in text


def test_amounts_a_place_and_the_pose(browser: Browser, robot: Robot) -> None:
    """Drive and turn by numbers; a place pressed and dragged; telling it where it is moves nothing."""
    with person(browser, robot.url) as page:
        page.wait_for_timeout(1000)
        began = robot.place
        page.fill("#amount-move", "0.5")
        page.press("#amount-move", "Enter")
        page.click("#confirm button[type=submit]")
        page.wait_for_selector("#task >> text=Arrived", timeout=30_000)
        assert 0.4 < away(robot, *began) < 0.6
        before = robot.chassis.pose.wait(timeout=5.0).yaw
        page.fill("#amount-turn", "45")
        page.press("#amount-turn", "Enter")
        page.click("#confirm button[type=submit]")
        page.wait_for_selector("#task >> text=Turn by 45°")
        page.wait_for_selector("#task >> text=Arrived", timeout=30_000)
        assert 0.6 < robot.chassis.pose.wait(timeout=5.0).yaw - before < 1.0

        page.click("#choose-place")
        page.fill("#place-x", "1.505")
        page.fill("#place-y", "0.5")
        page.fill("#place-heading", "90")
        page.click("#confirm button[type=submit]")
        page.wait_for_selector("#task progress")
        page.wait_for_selector("#task >> text=Arrived", timeout=60_000)
        assert away(robot, 1.5, 0.5) < 0.3

        page.click("#choose-pose")
        box = page.locator("#canvas").bounding_box()
        assert box is not None
        x, y = box["x"] + box["width"] * 0.3, box["y"] + box["height"] * 0.45
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x, y - 60, steps=4)
        page.mouse.up()
        assert page.input_value("#place-heading") == "90"
        page.click("#confirm button[type=submit]")
        page.wait_for_selector("text=The robot was told where it is.")
        assert away(robot, 1.5, 0.5) < 0.3, "told far from the truth: it believes nothing, and has not moved"
        page.click("#tabbutton-log")
        page.wait_for_selector("#journal >> text=Told it where it is")


def test_charge(browser: Browser, robot: Robot) -> None:
    """The charger's name stands there already."""
    with person(browser, robot.url) as page:
        page.click("#charge")
        assert page.input_value("#charger-name") == "C1"
        page.click("#confirm button[type=submit]")
        page.wait_for_selector("#task >> text=Charge at C1")
        page.wait_for_selector("#battery .icon", timeout=60_000)  # the flash: it charges


def test_stop_ends_a_goal_and_says_what_stands(browser: Browser, robot: Robot) -> None:
    """One touch, without control and without a question, by somebody else than who drives."""
    with person(browser, robot.url) as page, person(browser, robot.url, PHONE) as other:
        page.click(".markrow >> text=B1")
        page.click("#confirm button[type=submit]")
        until(lambda: robot.speed > 0.1, page)
        other.tap("#stop")
        other.wait_for_selector("#stop-answer >> text=The robot stands still.")
        assert robot.speed < 0.02
        page.wait_for_selector("#task >> text=Cancelled")


def test_recording_grows_and_is_downloaded(browser: Browser, robot: Robot, tmp_path: Path) -> None:
    """A bag that can be read comes out."""
    from rosproto.bag import BagReader

    with person(browser, robot.url) as page:
        page.click("#tabbutton-log")
        page.click("#record")
        first = page.inner_text(".recording")
        until(lambda: page.inner_text(".recording") != first, page)
        page.click("#record-stop")
        with page.expect_download() as download:
            page.click("#recordings a.button")
        download.value.save_as(tmp_path / "copy.bag")
    with BagReader(tmp_path / "copy.bag") as bag:
        assert sum(1 for _ in bag.read_messages()) > 10


def test_camera_and_values(browser: Browser, robot: Robot) -> None:
    """Both pictures are drawn; values and plots are there; the costmap can be asked for."""
    with person(browser, robot.url) as page:
        for name in ("Colour", "Depth"):
            page.click("#tabbutton-camera")
            page.click(f"#tab-camera >> text={name}")
            page.wait_for_selector("canvas.picture:not(.old)")
            pixels = page.evaluate(
                """(() => { const c = document.querySelector('canvas.picture');
                const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
                return new Set(d).size; })()"""
            )
            assert pixels > 3
        page.click("#costmap")
        page.click("#tabbutton-health")
        page.wait_for_selector("#plots figure strong:not(:empty)")
        assert "m/s" in page.inner_text("#tab-health table")


def test_hold_to_drive_and_let_go(browser: Browser, robot: Robot) -> None:
    """It moves while the pad is held, and stands within half a second (and what a busy machine adds) after."""
    with person(browser, robot.url) as page:
        page.click("#tabbutton-drive")
        page.click("#drive-on")
        page.check("#warning-check")
        page.click("#warning-yes")
        page.wait_for_selector(".pad")
        page.wait_for_selector("text=You have control.")
        box = page.locator(".pad").bounding_box()
        assert box is not None
        page.mouse.move(box["x"] + 110, box["y"] + 110)
        page.mouse.down()
        page.mouse.move(box["x"] + 110, box["y"] + 30)
        page.wait_for_selector(".drivestate.driving")
        until(lambda: robot.speed > 0.05, page)
        page.wait_for_timeout(600)
        assert robot.speed > 0.05, "it is held: it goes on"
        page.mouse.up()
        until(lambda: robot.speed < 0.01, page, 2.0)
        page.wait_for_selector(".drivestate >> text=Stands by")


def test_a_closed_page_stops_and_gives_back(browser: Browser, robot: Robot) -> None:
    """The tab is closed while it is held: the robot stands, and the next person need not wait for control."""
    with person(browser, robot.url) as page, person(browser, robot.url) as other:
        page.click("#tabbutton-drive")
        page.click("#drive-on")
        page.check("#warning-check")
        page.click("#warning-yes")
        page.wait_for_selector(".pad")
        page.wait_for_selector("text=You have control.")
        page.evaluate("document.activeElement.blur()")
        page.keyboard.down("ArrowUp")
        until(lambda: robot.speed > 0.05, page)
        page.close(run_before_unload=True)
        until(lambda: robot.speed < 0.01, other, 2.0)
        other.click("#tabbutton-drive")
        other.wait_for_selector("text=Nobody has control.")
