"""The page in a real browser, against `woosh_pure.web` and the simulated chassis: every control once."""

from __future__ import annotations

import json
import math
import re
import time
import urllib.request
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import pytest

from tests.support.browser import DESKTOP, PHONE, person
from tests.support.load import crowd
from tests.support.web import PageClient
from woosh_pure import Chassis

if TYPE_CHECKING:
    from pathlib import Path

    from playwright.sync_api import Browser, Page

    from tests.web.conftest import Robot

pytestmark = pytest.mark.slow


def until(condition: Callable[[], Any], page: Page, seconds: float = 20.0) -> Any:
    deadline = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < deadline, "it did not come true"
        page.wait_for_timeout(50)
    return found


def in_view(page: Page, what: str) -> bool:
    """Whether it can be seen without scrolling."""
    return bool(
        page.evaluate(
            """(what) => { const box = document.querySelector(what).getBoundingClientRect();
            return document.elementFromPoint(box.x + 20, box.y + 10)?.closest(what) !== null; }""",
            what,
        )
    )


@pytest.mark.parametrize(
    ("size", "language"),
    [pytest.param(PHONE, "zh-CN", id="phone-zh"), pytest.param(DESKTOP, "en-US", id="desktop-en")],
)
def test_two_touches_drive_to_a_mark(browser: Browser, robot: Robot, size: Any, language: str) -> None:
    """First sight: the mark, then start. Nothing is to be set before; it arrives, and the page says so."""
    arrived = {"zh-CN": "已到达", "en-US": "Arrived"}[language]
    with person(browser, robot.url, size, language=language) as page:
        page.click(".markrow >> text=P1")  # on a phone the list has to be scrolled for it
        page.click("#confirm button[type=submit]")
        page.wait_for_selector("#task progress")
        until(lambda: in_view(page, "#task"), page)
        page.wait_for_selector(f"#task >> text={arrived}", timeout=60_000)
        mark = robot.sim.world.site.marks["P1"].pose
        assert robot.away(mark.x, mark.y) < 0.3
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
        for line in ("Go to B1", r"Pause no. \d", r"Resume no. \d", r"Cancel no. \d", r"page \d"):
            assert re.search(line, text), line


def test_the_header_says_what_the_robot_does(browser: Browser, robot: Robot) -> None:
    """Also on the way to a place, during which the robot calls itself idle; and the API says the same."""

    def said() -> Any:
        with urllib.request.urlopen(f"{robot.url}api/v1/status", timeout=10.0) as answer:
            return json.load(answer)["activity"]

    with person(browser, robot.url, PHONE) as page, Chassis(robot.sim.master_uri) as other:
        page.wait_for_selector("#state >> text=Idle")
        assert said() == "idle"
        for goal in (robot.chassis.go_to, other.go_to):
            begun = goal(4.0, 2.0)
            page.wait_for_selector("#state >> text=Under way")
            assert said() == "under way"
            begun.cancel()
            page.wait_for_selector("#state >> text=Idle")


def test_amounts_a_place_and_the_pose(browser: Browser, robot: Robot) -> None:
    """Drive and turn by numbers; a place pressed and dragged; telling it where it is moves nothing."""
    with person(browser, robot.url) as page:
        page.wait_for_timeout(1000)
        began = robot.place
        page.fill("#amount-move", "0.5")
        page.press("#amount-move", "Enter")
        page.click("#confirm button[type=submit]")
        page.wait_for_selector("#task >> text=Arrived", timeout=30_000)
        assert 0.4 < robot.away(*began) < 0.6
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
        assert robot.away(1.5, 0.5) < 0.3

        page.click("#choose-pose")
        box = page.locator("#canvas").bounding_box()
        assert box is not None
        x, y = box["x"] + box["width"] * 0.6, box["y"] + box["height"] * 0.45
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x, y - 60, steps=4)
        page.mouse.up()
        assert page.input_value("#place-heading") == "90"
        page.click("#confirm button[type=submit]")
        page.wait_for_selector(".toast.ask >> text=The robot says that it is", timeout=20_000)
        assert robot.away(1.5, 0.5) < 0.3, "told far from the truth: it believes nothing, and has not moved"
        page.click("#tabbutton-log")
        page.wait_for_selector("#journal .entry.ended >> text=Corrected its position")


def test_a_robot_that_is_lost_finds_itself_and_says_so(browser: Browser, robot: Robot) -> None:
    """Health names the button by its name; told the truth, the robot says that it is there, and then comes the tick."""
    with person(browser, robot.url) as page:
        page.click("#tabbutton-health")
        robot.sim.lose_localization()
        page.wait_for_selector("#tab-health >> text=It does not know where it is.")
        name = page.inner_text("#choose-pose") or page.text_content("#choose-pose")
        assert f"“{name}”" in page.inner_text("#tab-health")
        page.click("#tabbutton-go")
        page.click("#choose-pose")
        start = robot.sim.world.body.pose
        for field, value in (("x", start.x), ("y", start.y), ("heading", math.degrees(start.yaw))):
            page.fill(f"#place-{field}", f"{value:.2f}")
        page.click("#confirm button[type=submit]")
        page.wait_for_selector(".toast.ok >> text=The robot has confirmed this position.", timeout=20_000)


def test_after_a_reload_a_goal_is_still_ones_own(browser: Browser, robot: Robot) -> None:
    """With the way that is done; and a plan is drawn while it is driven, and no longer."""

    def plan() -> list[Any]:
        with urllib.request.urlopen(f"{robot.url}api/v1/plan", timeout=10.0) as answer:
            return list(json.load(answer)["points"])

    def bar(page: Page) -> float:
        return float(page.evaluate("document.querySelector('#task progress')?.value ?? 0"))

    speed = robot.sim.speed
    robot.sim.speed = 1.0  # so that it does not arrive before the page of a busy computer pauses it
    with person(browser, robot.url) as page:
        page.click(".markrow >> text=C1")
        page.click("#confirm button[type=submit]")
        page.wait_for_selector("#task >> text=by you")
        until(lambda: bar(page) > 10, page)
        assert len(plan()) > 1
        page.click("#pause")
        page.wait_for_selector("#resume")
        robot.sim.speed = speed
        done = bar(page)
        for _ in range(10):
            page.reload()
            page.wait_for_selector("#task >> text=by ")
            assert "by you" in page.inner_text("#task")
            assert bar(page) > done - 5
        page.click("#resume")
        page.wait_for_selector("#task >> text=Arrived", timeout=60_000)
        until(lambda: plan() == [], page)


def test_a_copied_tab_is_somebody_else(browser: Browser, robot: Robot) -> None:
    """A tab that is copied while it lives does not take its session along."""
    with person(browser, robot.url) as page:
        assert page.evaluate("sessionStorage.length") == 0


JARGON = re.compile(r"robot_state|/\w+_\w+|register[A-Z]|\d{6,}|\brad\b|\w\(\)|_stop\b")
NAMES = re.compile(
    r"\b(sim|ROS|bag|YAML|WASD|English|STOP|[A-Z]\d|[xym]|Hz|[kM]?B)\b|--allow-driving|--bind|代码 \d+|[\w-]+\.bag"
)


def test_what_a_person_reads_is_chinese_and_begins_with_the_cause(browser: Browser, robot: Robot) -> None:
    """The emergency stop ends a goal, and no other is offered: no page of the panel has a word of English, or of ours."""
    read: list[str] = []
    with person(browser, robot.url, language="zh-CN") as page:
        page.click(".markrow >> text=B1")
        page.click("#confirm button[type=submit]")
        until(lambda: robot.speed > 0.1, page)
        robot.sim.press_emergency_stop()
        page.wait_for_selector("#task.bad >> text=急停已按下。")
        assert page.inner_text("#notices").startswith("现在不能移动：急停已按下。")
        assert "它报告了故障" not in page.inner_text("#notices")
        page.click(".markrow >> text=A1")
        assert page.inner_text("#confirm .why") == "现在不能移动：急停已按下。"
        assert page.is_disabled("#confirm button[type=submit]")
        page.click("#confirm .plain")
        page.click("#stop")
        page.wait_for_selector("#stop-answer >> text=机器人已停稳。")
        for tab in ("go", "drive", "health", "log"):
            page.click(f"#tabbutton-{tab}")
            read.append(page.inner_text("body"))
        assert page.inner_text("#tab-health li >> nth=0").startswith("急停已按下。")
        robot.sim.release_emergency_stop()
    for text in read:
        text = NAMES.sub("", text)
        assert not JARGON.search(text), text
        words = re.findall(r"[A-Za-z]{2,}", text)
        assert words == [], text


def test_a_lost_localisation_is_a_sentence_above_every_tab(browser: Browser, robot: Robot) -> None:
    """With what to do about it; it goes when the robot knows its place again."""
    with person(browser, robot.url, PHONE) as page:
        page.wait_for_selector("#battery .level", state="attached")
        robot.sim.lose_localization()
        for tab in ("drive", "log"):
            page.click(f"#tabbutton-{tab}")
            page.wait_for_selector("#notices .notice.bad >> text=It does not know where it is.")
        assert "Correct its position" in page.inner_text("#notices")
        robot.reset()
        page.wait_for_selector("#notices .notice", state="detached")


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
    """A bag that can be read comes out, with a bar while it comes; and the map as a picture."""
    from rosproto.bag import BagReader

    with person(browser, robot.url) as page:
        page.click("#tabbutton-log")
        page.click("#record")
        first = page.inner_text(".recording")
        until(lambda: page.inner_text(".recording") != first, page)
        page.click("#record-stop")
        page.wait_for_selector("#recordings .saved")
        slow = page.context.new_cdp_session(page)
        slow.send("Network.enable")
        limits = {"offline": False, "latency": 0, "downloadThroughput": 60_000, "uploadThroughput": -1}
        slow.send("Network.emulateNetworkConditions", limits)
        with page.expect_download() as download:
            page.click("#recordings .saved button")
            bar = "document.querySelector('.saved progress')?.value ?? -1"
            until(lambda: 0.0 < page.evaluate(bar) < 1.0, page)
            assert " of " in page.inner_text(".saved .underway")
        download.value.save_as(tmp_path / "copy.bag")
        page.wait_for_selector("#recordings >> text=Downloaded: woosh-")
        with page.expect_download() as download:
            page.click("#save-png")
        download.value.save_as(tmp_path / "map.png")
    with BagReader(tmp_path / "copy.bag") as bag:
        assert sum(1 for _ in bag.read_messages()) > 10
    assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")


def test_camera_and_values(browser: Browser, robot: Robot) -> None:
    """Both pictures are drawn, also of a robot that stands; values and plots are there."""
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
        page.wait_for_timeout(2500)
        assert page.locator("canvas.picture.old").count() == 0, "the same picture again is no old picture"
        page.click("#tabbutton-health")
        page.wait_for_selector("#plots figure strong:not(:empty)")
        assert "m/s" in page.inner_text("#tab-health table")


def test_the_costmap_is_drawn_where_the_simulator_says(browser: Browser, robot: Robot) -> None:
    """Each sampled place of the hall is coloured when it costs something, and only then; and it can be put away."""
    from woosh_pure.sim.planner import Costmap

    costs = Costmap(robot.sim.world.site.grid, robot.sim.world.settings.radius).with_obstacles([])
    cells = [(row, column) for row in range(2, 80, 5) for column in range(2, 120, 5)]
    with person(browser, robot.url) as page:
        page.click("#fit")
        page.wait_for_timeout(500)
        width, height = page.evaluate("[canvas.clientWidth, canvas.clientHeight]")
        scale = min(
            (width - 16 - 72) / 12.0, (height - 16 - 40) / 8.0
        )  # the hall's 12 by 8 m beside the tools
        middle = (16 + width - 72) / 2, (16 + height - 40) / 2
        places = []
        for row, column in cells:
            x, y = costs.point_of(row, column)
            places.append([middle[0] + (x - 4.0) * scale, middle[1] - y * scale])
        colours = "(all) => { const c = canvas.getContext('2d'); return all.map((at) => [...c.getImageData(...at, 1, 1).data]); }"
        before = page.evaluate(colours, places)
        page.click("#costmap")

        def changed() -> list[bool]:
            return [a != b for a, b in zip(before, page.evaluate(colours, places), strict=True)]

        until(lambda: sum(changed()) > 100, page)
        coloured = changed()
        free = [found for cell, found in zip(cells, coloured, strict=True) if costs.cells[cell] == 0]
        costly = [found for cell, found in zip(cells, coloured, strict=True) if costs.cells[cell] > 0]
        assert len(free) > 80
        assert not any(free)
        assert sum(costly) > 0.95 * len(costly), "but for what pins and the robot cover"
        assert page.is_hidden("#hint")
        page.click("#costmap")
        until(lambda: not any(changed()), page)


def allow(page: Page) -> None:
    """Switch driving on, as a person does."""
    page.click("#tabbutton-drive")
    page.click("#drive-on")
    page.check("#warning-check")
    page.click("#warning-yes")
    page.wait_for_selector(".pad")
    page.wait_for_selector("text=You have control.")


def drive(page: Page, robot: Robot) -> None:
    """The mouse on the pad, forward, until it moves: a page that a busy computer holds up lets go, and is pressed
    again.
    """
    box = page.locator(".pad").bounding_box()
    assert box is not None
    for _ in range(10):
        page.mouse.move(box["x"] + 110, box["y"] + 110)
        page.mouse.down()
        page.mouse.move(box["x"] + 110, box["y"] + 30)
        page.wait_for_selector(".drivestate.driving, .drivestate.bad")
        until(lambda: robot.speed > 0.05 or page.locator(".drivestate.bad").count(), page)
        if robot.speed > 0.05:
            return
        page.mouse.up()
    pytest.fail("this computer is too busy to hold anything")


def test_hold_to_drive_and_let_go(browser: Browser, robot: Robot) -> None:
    """It moves while the pad is held, and stands within half a second (and what a busy machine adds) after."""
    with person(browser, robot.url) as page:
        allow(page)
        drive(page, robot)
        page.wait_for_timeout(600)
        ended = page.locator(".drivestate.bad").count() > 0
        assert robot.speed > 0.05 or ended, "it is held: it goes on"
        page.mouse.up()
        until(lambda: robot.speed < 0.01, page, 2.0 * crowd())
        page.wait_for_selector(".drivestate >> text=Ready to drive")


def test_a_closed_page_stops_and_gives_back(browser: Browser, robot: Robot) -> None:
    """The tab is closed while it is held: the robot stands, and the next person need not wait for control."""
    with person(browser, robot.url) as page, person(browser, robot.url) as other:
        allow(page)
        page.evaluate("document.activeElement.blur()")
        page.keyboard.down("ArrowUp")
        until(lambda: robot.speed > 0.05, page)
        page.close(run_before_unload=True)
        until(lambda: robot.speed < 0.01, other, 2.0 * crowd())
        other.click("#tabbutton-drive")
        other.wait_for_selector("text=Nobody has control.")


def test_who_drives_hands_over_only_when_asked(browser: Browser, robot: Robot) -> None:
    """The other one's order is refused in words; it asks, the first agrees while driving, and that ends the drive."""
    with person(browser, robot.url) as first, person(browser, robot.url, PHONE) as second:
        allow(first)
        second.tap(".markrow >> text=A1")
        second.tap("#confirm button[type=submit]")
        second.wait_for_selector(".toast.ask >> text=has to agree")
        first.wait_for_selector("#notices >> text=asks for control.")
        drive(first, robot)  # asking takes nothing away
        first.evaluate("document.querySelector('#notices button.primary').click()")  # the mouse holds the pad
        until(lambda: robot.speed < 0.01, first, 3.0 * crowd())
        first.wait_for_selector(".drivestate.bad")
        first.mouse.up()
        second.tap(".markrow >> text=A1")
        second.tap("#confirm button[type=submit]")
        second.wait_for_selector("#task >> text=Arrived", timeout=60_000)
        first.wait_for_selector(".lease >> text=has control.")


def test_who_keeps_control_refuses_a_request(browser: Browser, robot: Robot) -> None:
    """The question ends at the holder; the other one is told, may ask again, and is told when it is handed over."""
    with person(browser, robot.url) as first, person(browser, robot.url, PHONE) as second:
        allow(first)
        second.tap("#tabbutton-drive")
        second.tap(".lease .ask")
        second.wait_for_selector(".lease >> text=has to agree")
        assert second.locator(".toast.bad").count() == 0, "a request is not an error"
        first.click("#notices button >> text=Keep it")
        first.wait_for_selector("#notices .notice", state="detached")
        second.wait_for_selector(".toast.ask >> text=keeps control.")
        assert robot.chassis.lease.state.asking == ()
        second.tap(".lease .ask")
        first.click("#notices button.primary")
        second.wait_for_selector(".toast.ok >> text=You have control.")


_GAMEPAD = """
const buttons = Array.from({length: 17}, () => ({pressed: false, touched: false, value: 0}));
window.gamepad = {connected: true, mapping: "standard", index: 0, id: "mock", axes: [0, 0, 0, 0], buttons};
navigator.getGamepads = () => [null, gamepad];
"""


def test_a_gamepad_drives_while_its_shoulder_is_held(browser: Browser, robot: Robot) -> None:
    """The stick alone does nothing; the shoulder let go ends it, with the stick still pushed."""
    with person(browser, robot.url) as page:
        page.evaluate(_GAMEPAD)
        allow(page)
        page.evaluate("gamepad.axes[1] = -1")
        page.wait_for_timeout(400)
        assert page.inner_text(".drivestate") == "Ready to drive"
        page.evaluate("gamepad.buttons[5].pressed = true")
        page.wait_for_selector(".drivestate.driving")
        until(lambda: robot.speed > 0.05, page)
        page.evaluate("gamepad.buttons[5].pressed = false")
        until(lambda: robot.speed < 0.01, page, 3.0 * crowd())
        page.wait_for_selector(".drivestate >> text=Ready to drive")


def test_a_frozen_page_stops_and_resumes_nothing(browser: Browser, robot: Robot) -> None:
    """Not a step of its script runs while it is held, as on a phone that sleeps; living again it says why it ended."""
    with person(browser, robot.url) as page, person(browser, robot.url) as other:
        allow(page)
        drive(page, robot)
        life = page.context.new_cdp_session(page)
        life.send("Debugger.enable")  # a headless browser takes no note of Page.setWebLifecycleState
        life.send("Debugger.pause")
        until(lambda: robot.speed < 0.01, other, 3.0 * crowd())
        other.wait_for_timeout(700)
        life.send("Debugger.resume")
        page.wait_for_selector(".drivestate.bad")
        page.wait_for_timeout(500)
        assert robot.speed < 0.01, "it is still held, and nothing resumes"
        page.mouse.up()
        page.wait_for_selector("#lost", state="hidden")


def test_of_two_tabs_with_one_session_the_older_takes_a_new_one(browser: Browser, robot: Robot) -> None:
    """A tab can be copied together with its session; the two must not end each other's connection in turn."""
    clients = robot.server.app.state.context.clients
    with person(browser, robot.url) as page:
        page.wait_for_selector("#battery >> text=%")
        newest = next(reversed(clients._known))
        with PageClient(robot.server.port, f"/api/v1/live?session={newest}") as copy:
            name = copy.of("hello")["you"]
            until(lambda: next(reversed(clients._known)) != newest, page)
            copy.forget()
            copy.of("pose")
            assert clients._known[newest].name == name
            assert copy.socket.close_code is None


@pytest.mark.parametrize("size", [pytest.param(PHONE, id="phone"), pytest.param(DESKTOP, id="desktop")])
def test_the_simulation_is_changed_from_the_page(browser: Browser, robot: Robot, size: Any) -> None:
    """Its tab has what may happen to a robot: each button does what it says, and a tap on the map is an obstacle or a place."""
    sim = robot.sim
    with person(browser, robot.url, size) as page:
        page.click("#tabbutton-sim")
        page.wait_for_timeout(1000)  # the map is fitted when its picture has come
        page.click("#sim-press")
        page.wait_for_selector("#notices .notice.bad >> text=emergency stop")
        page.click("#sim-release")
        page.wait_for_selector("#notices .notice", state="hidden")
        page.click("#sim-lose")
        page.wait_for_selector("#notices .notice.bad")
        page.click("#sim-battery")
        page.wait_for_selector("#battery.low >> text=10 %")
        page.click("#fit")
        box = page.locator("#canvas").bounding_box() or {}
        middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        at = [round(box["width"] / 2), round(box["height"] / 2)]
        colour = f"[...canvas.getContext('2d').getImageData({at[0]}, {at[1]}, 1, 1).data].join()"
        before = page.evaluate(colour)
        page.click("#sim-obstacle")
        page.mouse.click(*middle)
        until(lambda: sim.world.obstacles, page)
        until(lambda: page.evaluate(colour) != before, page)
        assert page.locator("#sim-obstacle[aria-pressed=true]").count() == 1, "the next tap is another one"
        page.click("#sim-clear")
        until(lambda: not sim.world.obstacles, page)
        until(lambda: page.evaluate(colour) == before, page)
        page.click("#sim-reset")
        page.wait_for_selector("#notices .notice", state="hidden")
        start = sim.pose
        page.click("#sim-teleport")
        page.mouse.click(middle[0], middle[1] + (20 if size == PHONE else 60))  # in the middle is a wall
        until(lambda: (sim.pose.x, sim.pose.y) != (start.x, start.y), page)
        page.select_option("#sim-speed", "10")
        until(lambda: sim.speed == 10.0, page)
        page.click("#tabbutton-go")
        here = sim.pose
        page.mouse.click(*middle)
        page.click("#tabbutton-log")
        page.wait_for_selector("#journal >> text=Changed the simulation")
        assert sim.pose == here, "a tap is an ordinary one again"
        page.reload()
        page.click("#tabbutton-sim")
        assert page.input_value("#sim-speed") == "10"
    sim.speed = 3.0
