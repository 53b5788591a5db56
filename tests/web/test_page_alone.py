"""The page in a real browser, against a server that can lose the robot, fall silent, refuse and be slow."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import pytest

from tests.support.browser import DESKTOP, PHONE, person
from tests.support.load import crowd
from tests.web.test_page_fits import TABS

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web.fake_server import Fake

pytestmark = pytest.mark.slow
SIZES = [pytest.param(PHONE, id="phone"), pytest.param(DESKTOP, id="desktop")]
LANGUAGES = [
    pytest.param("en-US", "Where should it go?", id="en"),
    pytest.param("zh-CN", "选择目的地", id="zh"),
]


@pytest.fixture
def served() -> Iterator[tuple[Fake, str]]:
    for module in ("fastapi", "uvicorn", "websockets", "PIL"):
        pytest.importorskip(module, reason=f'{module} is not installed: pip install ".[web]"')
    from tests.web.fake_server import Fake, Served

    fake = Fake()
    with Served(fake) as server:
        yield fake, server.url


def until(condition: Callable[[], Any], page: Page, seconds: float = 5.0) -> Any:
    """What the server sees, waited for while the browser's own events go on."""
    deadline = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < deadline, "it did not come true"
        page.wait_for_timeout(20)
    return found


@pytest.mark.parametrize(
    ("size", "scheme"),
    [pytest.param(PHONE, "light", id="phone-light"), pytest.param(DESKTOP, "dark", id="desktop-dark")],
)
@pytest.mark.parametrize(("language", "title"), LANGUAGES)
def test_every_page_fits_and_can_be_touched(
    browser: Browser, served: tuple[Fake, str], size: Any, language: str, title: str, scheme: str
) -> None:
    """In both languages (light or dark changes no place): nothing runs out of the screen, and each control is 44 px at least."""
    with person(browser, served[1], size, language=language, scheme=scheme) as page:
        assert page.inner_text("#tab-go h2") == title
        for tab in TABS:
            page.click(f"#tabbutton-{tab}")
            wide, high = page.evaluate(
                "[document.documentElement.scrollWidth, document.documentElement.scrollHeight]"
            )
            assert (wide, high) == size, tab
            longest = page.evaluate(
                """(text) => { document.querySelector('#state').textContent = text;
                document.querySelector('#simulated').classList.remove('hidden');
                return document.documentElement.scrollWidth; }""",
                {"en-US": "State unknown", "zh-CN": "状态未知"}[language],
            )
            assert longest == size[0], "a long state, beside a simulated robot"
            panel = page.evaluate(
                "(({scrollWidth: a, clientWidth: b}) => [a, b])(document.querySelector('#panel'))"
            )
            assert panel[0] <= panel[1], tab
            small = page.evaluate(
                """[...document.querySelectorAll('button, a.button, input, select')].filter((one) => {
                    const {width, height} = one.getBoundingClientRect();
                    return width > 0 && one.type !== 'checkbox' && (height < 43.9 || width < 43.9);
                }).map((one) => one.outerHTML.slice(0, 80))"""
            )
            assert small == [], tab
            stop = page.locator("#stop").bounding_box()
            assert stop is not None
            assert stop["y"] + stop["height"] <= size[1]
            hit = page.evaluate("([x, y]) => document.elementFromPoint(x, y).closest('#stop') !== null",
                                [stop["x"] + stop["width"] / 2, stop["y"] + stop["height"] / 2])  # fmt: skip
            assert hit, f"something lies over STOP on {tab}"


def test_the_language_is_switched_and_kept(browser: Browser, served: tuple[Fake, str]) -> None:
    """One touch, every word, and the same language after a reload."""
    with person(browser, served[1]) as page:
        page.click("#language")
        assert page.inner_text("#stop") == "停止"
        assert page.get_attribute("html", "lang") == "zh"
        page.reload()
        page.wait_for_selector(".markrow")
        assert page.inner_text("#tabbutton-go") == "前往"
        page.click("#language")
        assert page.inner_text("#stop") == "STOP"


def test_a_silent_server_is_said_within_two_seconds(browser: Browser, served: tuple[Fake, str]) -> None:
    """In words, in a live region, and the page looks old; it comes back by itself."""
    fake, url = served
    with person(browser, url) as page:
        page.wait_for_selector("#lost", state="hidden")
        fake.silent, began = True, time.monotonic()
        page.wait_for_selector("#lost:not(.hidden)")
        assert time.monotonic() - began < 2.0 * crowd()
        assert "What you see is old" in page.inner_text("#lost")
        assert page.get_attribute("#lost", "role") == "alert"
        assert "gone" in (page.get_attribute("body", "class") or "")
        fake.silent = False
        page.wait_for_selector("#lost", state="hidden")
        assert "gone" not in (page.get_attribute("body", "class") or "")


def test_a_lost_robot_is_said_in_words(browser: Browser, served: tuple[Fake, str]) -> None:
    """The server lives, the robot does not."""
    fake, url = served
    with person(browser, url) as page:
        page.wait_for_selector("#lost", state="hidden")
        fake.lost = time.monotonic()
        page.wait_for_selector("#lost:not(.hidden)")
        assert "The robot has been silent" in page.inner_text("#lost")
        fake.lost = None
        page.wait_for_selector("#lost", state="hidden")


def test_the_end_of_a_goal_that_was_never_seen_running(browser: Browser, served: tuple[Fake, str]) -> None:
    """A goal may begin and end between two messages. What had ended before the page came is no news."""
    fake, url = served
    old = {
        "id": "1",
        "kind": "mark",
        "who": "page 1",
        "description": "mark A1",
        "state": "arrived",
        "done": True,
    }
    fake.goals = [old]
    with person(browser, url) as page:
        page.wait_for_selector("#battery >> text=76")
        assert not page.is_visible("#task")
        fake.goals = [old, {**old, "id": "2", "description": "mark B1", "state": "cancelled"}]
        page.wait_for_selector("#task >> text=Cancelled")
        fake.goals = []


@pytest.mark.parametrize(
    ("stands", "text"),
    [
        (True, "The robot stands still."),
        (False, "THE ROBOT IS STILL MOVING"),
        (None, "not known. Watch it"),
    ],
)
def test_stop_is_one_touch_and_answered(
    browser: Browser, served: tuple[Fake, str], stands: Any, text: str
) -> None:
    """What stands still, what does not, and what is not known are three answers."""
    fake, url = served
    fake.stands = stands
    with person(browser, url, PHONE) as page:
        page.tap("#stop")
        page.wait_for_selector("#stop-answer:not(.hidden) >> text=" + text)
        assert fake.calls[0] == ("live", "stop", None)


def test_a_slow_stop_says_so_and_a_key_presses_it(browser: Browser, served: tuple[Fake, str]) -> None:
    """After two seconds without an answer the page names the red button."""
    fake, url = served
    fake.stop_delay = 3.0
    with person(browser, url) as page:
        page.focus("#stop")
        page.keyboard.press("Enter")
        page.wait_for_selector("#stop-answer >> text=No answer yet", timeout=3500)
        page.wait_for_selector("#stop-answer >> text=stands still")


def test_what_the_server_refuses_is_its_own_sentence(browser: Browser, served: tuple[Fake, str]) -> None:
    """A problem's detail is shown."""
    fake, url = served
    with person(browser, url) as page:
        page.click(".markrow >> text=D9")
        page.click("#confirm button[type=submit]")
        page.wait_for_selector(".toast.bad >> text=the chassis knows no mark 'D9'")
        assert fake.goals == []


@pytest.mark.parametrize(
    ("takes", "text"),
    [
        (True, "has confirmed this position"),
        (False, "The robot says that it is 3.6 m"),
        (None, "has not answered"),
    ],
)
def test_the_tick_after_a_pose_comes_from_the_robot(
    browser: Browser, served: tuple[Fake, str], takes: Any, text: str
) -> None:
    """Not when it was sent: when the robot says that it is there; and if it does not, that is said."""
    fake, url = served
    fake.takes_pose = takes if takes is not True else False
    with person(browser, url) as page:
        page.wait_for_selector("#battery >> text=76")
        page.click("#choose-pose")
        page.fill("#place-x", "3")
        page.fill("#place-y", "2")
        page.click("#confirm button[type=submit]")
        page.wait_for_selector(".toast.wait")
        page.wait_for_timeout(1000)
        assert page.locator(".toast.ok").count() == 0
        if takes is True:
            fake.pose = [3.0, 2.0, 0.4]
        page.wait_for_selector(f".toast.{ {True: 'ok', False: 'ask', None: 'bad'}[takes] } >> text={text}")
        assert page.locator(".toast.wait").count() == 0, "it waits no longer"


def test_nothing_is_sent_without_a_yes(browser: Browser, served: tuple[Fake, str]) -> None:
    """Escape and Cancel are no."""
    fake, url = served
    with person(browser, url) as page:
        page.click(".markrow >> text=A1")
        page.keyboard.press("Escape")
        page.wait_for_selector("#confirm", state="hidden")
        page.click(".markrow >> text=B1")
        page.click("#confirm .plain")
        page.wait_for_selector("#confirm", state="hidden")
        assert fake.calls == []


@pytest.mark.parametrize("size", [*SIZES, pytest.param((844, 390), id="lying phone")])
def test_a_question_covers_neither_the_place_nor_stop(
    browser: Browser, served: tuple[Fake, str], size: Any
) -> None:
    """While a place is chosen the map can be pressed around its middle, and STOP is free."""
    with person(browser, served[1], size) as page:
        page.click("#choose-place")
        for target in ("#canvas", "#stop"):
            free = page.evaluate(
                """(target) => { const box = document.querySelector(target).getBoundingClientRect();
                return [0.4, 0.5, 0.6].every((part) => document.elementFromPoint(
                    box.x + part * box.width, box.y + 0.5 * box.height).closest(target) !== null); }""",
                target,
            )
            assert free, target
        card = page.locator("#confirm").bounding_box()
        assert card is not None
        assert card["x"] >= 0
        assert card["y"] >= 0
        assert card["x"] + card["width"] <= size[0]


def test_why_it_would_not_move_and_what_to_do(browser: Browser, served: tuple[Fake, str]) -> None:
    """A plain no is shown on every page; faults have their sentence and an advice."""
    fake, url = served
    reason = {
        "key": "emergency_stop",
        "text": "the emergency stop is pressed",
        "blocking": True,
        "doubt": False,
    }
    fake.ready = {"answer": "no", "text": reason["text"], "reasons": [reason]}
    fault = {"code": 100200300402, "level": "SEVERE", "text": "motor overheated", "text_zh": "电机过热"}
    fake.faults = {"known": True, "present": True, "text": "", "active": [fault]}
    with person(browser, url, PHONE, language="zh-CN") as page:
        page.wait_for_selector("#notices >> text=急停已按下。")
        assert "红色按钮" in page.inner_text("#notices")
        page.click("#fault-chip")
        page.wait_for_selector("#tab-health >> text=电机过热")
        assert "怎么办" in page.inner_text("#tab-health")


def test_start_is_offered_again_when_the_emergency_stop_is_released(
    browser: Browser, served: tuple[Fake, str]
) -> None:
    """The open question says why there is no Start now, and follows the robot; correcting the position moves nothing."""
    fake, url = served
    reason = {"key": "emergency_stop", "text": "pressed", "values": {}, "blocking": True, "doubt": False}
    with person(browser, url) as page:
        page.click(".markrow >> text=A1")
        assert not page.is_disabled("#confirm button[type=submit]")
        fake.ready = {"answer": "no", "text": "", "reasons": [reason]}
        page.wait_for_selector("#confirm .why >> text=It cannot move now: The emergency stop is pressed.")
        assert page.is_disabled("#confirm button[type=submit]")
        page.click("#choose-pose")
        assert not page.is_disabled("#confirm button[type=submit]")
        page.click("#charge")
        assert page.is_disabled("#confirm button[type=submit]")
        fake.ready = {"answer": "yes", "text": "", "reasons": []}
        page.wait_for_selector("#confirm .why", state="hidden")
        assert not page.is_disabled("#confirm button[type=submit]")
        assert fake.calls == []


LOST = {"key": "not_localised", "text": "lost", "values": {}, "blocking": False, "doubt": False}


def test_a_robot_that_does_not_know_where_it_is_is_sent_to_no_place(
    browser: Browser, served: tuple[Fake, str]
) -> None:
    """The question says why, and what to do; it may still drive by a distance."""
    fake, url = served
    fake.ready = {"answer": "not known", "text": "", "reasons": [LOST]}
    with person(browser, url) as page:
        page.wait_for_selector("#notices >> text=It does not know where it is.")
        for selector in (".markrow >> text=A1", "#charge", "#choose-place"):
            page.click(selector)
            why = page.inner_text("#confirm .why")
            assert why.startswith("It does not know where it is. What to do: Tell it where it is"), selector
            assert page.is_disabled("#confirm button[type=submit]")
        page.press("#amount-move", "Enter")
        assert page.is_enabled("#confirm button[type=submit]")


def test_health_does_not_send_to_itself(browser: Browser, served: tuple[Fake, str]) -> None:
    fake, url = served
    reason = {"key": "fault", "text": "fan slow", "values": {}, "blocking": True, "doubt": False}
    fake.ready = {"answer": "no", "text": "", "reasons": [reason]}
    with person(browser, url) as page:
        page.wait_for_selector("#notices >> text=“Health”")
        page.click("#tabbutton-health")
        page.wait_for_selector("#tab-health li >> text=It reports a fault.")
        assert "“Health”" not in page.inner_text("#tab-health")


def test_the_cause_of_a_failure_is_told_as_past(browser: Browser, served: tuple[Fake, str]) -> None:
    """The card stays until it is closed, and the cause may be over; what to do is said where the cause is said to last."""
    fake, url = served
    reason = {"key": "emergency_stop", "text": "pressed", "values": {}, "blocking": True, "doubt": False}
    goal = {"id": "1", "kind": "mark", "who": "page 1", "description": "mark A1", "state": "failed", "done": True,
            "stands_still": True, "reasons": [reason]}  # fmt: skip
    with person(browser, url) as page:
        page.wait_for_selector("#battery >> text=76")
        fake.goals = [goal]
        page.wait_for_selector(
            "#task.bad >> text=At that time: The emergency stop is pressed. It stood still."
        )
        assert "What to do" not in page.inner_text("#task")


def test_a_low_battery_is_a_sentence(browser: Browser, served: tuple[Fake, str]) -> None:
    """With the button that helps, until it charges."""
    fake, url = served
    fake.percent = 15
    with person(browser, url, PHONE) as page:
        page.wait_for_selector("#notices >> text=The battery is low: 15 %.")
        assert "“Charge”" in page.inner_text("#notices")
        fake.charging = True
        page.wait_for_selector("#notices .notice", state="detached")


def test_stop_closes_an_open_question(browser: Browser, served: tuple[Fake, str]) -> None:
    """Nobody starts by the next touch what was asked before the stop."""
    with person(browser, served[1]) as page:
        for selector in (".markrow >> text=A1", "#choose-place"):
            page.click(selector)
            page.wait_for_selector("#confirm:not(.hidden)")
            page.click("#stop")
            page.wait_for_selector("#confirm", state="hidden")
            assert page.locator("#map.placing").count() == 0


def test_without_the_server_nothing_of_a_goal_can_be_pressed(
    browser: Browser, served: tuple[Fake, str]
) -> None:
    fake, url = served
    with person(browser, url) as page:
        page.click(".markrow >> text=A1")
        page.click("#confirm button[type=submit]")
        page.wait_for_selector("#pause:enabled")
        fake.silent = True
        page.wait_for_selector("#cancel:disabled")
        assert page.is_disabled("#pause")
        fake.silent = False
        page.wait_for_selector("#cancel:enabled")


def test_driving_by_hand_is_said_to_who_drives_and_to_who_watches(
    browser: Browser, served: tuple[Fake, str]
) -> None:
    """To the robot a velocity is nothing to do: it calls itself idle."""
    fake, url = served
    with person(browser, url) as one, person(browser, url, PHONE, language="zh-CN") as two:
        one.wait_for_selector("#state >> text=Idle")
        fake.driver = "page 1"
        one.wait_for_selector("#state >> text=Driven by hand")
        two.wait_for_selector("#state >> text=手动遥控中")
        one.click("#tabbutton-health")
        one.wait_for_selector("#tab-health >> text=Driven by hand")
        fake.driver = None
        one.wait_for_selector("#state >> text=Idle")


def test_a_recording_that_the_server_ended_for_want_of_disk_does_not_look_like_the_others(
    browser: Browser, served: tuple[Fake, str]
) -> None:
    """Who watches is told at once; the list says it for good."""
    fake, url = served
    one = {
        "id": "1",
        "who": "page 1",
        "name": "a.bag",
        "running": True,
        "end": "",
        "seconds": 12.0,
        "bytes": 5000,
    }
    fake.recordings = [one]
    with person(browser, url) as page:
        page.click("#tabbutton-log")
        page.wait_for_selector("#record-stop")
        fake.recordings = [{**one, "running": False, "end": "no-room"}]
        page.wait_for_selector(".toast.bad >> text=its disk is nearly full")
        page.wait_for_selector("#recordings .saved.bad >> text=its disk is nearly full")
        fake.recordings = [
            {**one, "running": False, "end": "asked"},
            {**one, "id": "2", "running": False, "end": "limit"},
        ]
        page.wait_for_selector("#recordings >> text=Ended at its longest time or largest size. Saved: ")
        assert page.locator("#recordings .saved").count() == 2
        assert page.locator("#recordings .saved.bad").count() == 0


def test_the_camera_is_asked_for_only_while_it_is_looked_at(
    browser: Browser, served: tuple[Fake, str]
) -> None:
    """The other tabs, "off" and a hidden page end it."""
    fake, url = served
    with person(browser, url) as page:
        until(lambda: fake.looks, page)
        assert fake.looks["camera"] is None
        page.click("#tabbutton-camera")
        until(lambda: fake.looks["camera"] == "color", page)
        page.wait_for_selector("canvas.picture:not(.old)")
        page.click("#tab-camera >> text=Depth")
        until(lambda: fake.looks["camera"] == "depth", page)
        hide(page)
        until(lambda: fake.looks["camera"] is None, page)
        assert fake.looks["costmap"] is False
        page.click("#costmap")
        until(lambda: len(fake.heard) > 3, page)


def hide(page: Page) -> None:
    """As when another tab is chosen; a browser without a window cannot really do it."""
    page.evaluate(
        """Object.defineProperty(document, 'hidden', {value: true, configurable: true});
        document.dispatchEvent(new Event('visibilitychange'))"""
    )


def allow(page: Page) -> None:
    """Switch driving on, as a person does."""
    page.click("#tabbutton-drive")
    page.click("#drive-on")
    page.check("#warning-check")
    page.click("#warning-yes")
    page.wait_for_selector(".pad")


def hold(page: Page) -> None:
    box = page.locator(".pad").bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 110, box["y"] + 110)
    page.mouse.down()
    page.mouse.move(box["x"] + 110, box["y"] + 40)


def held(page: Page, fake: Fake) -> None:
    """Press until five beats have come: on a busy computer a page stands still for a moment, and that ends it."""
    for _ in range(10):
        fake.heard.clear()
        hold(page)
        until(lambda: len(kinds(fake, "beat")) > 4 or kinds(fake, "release"), page, 10.0)
        if not kinds(fake, "release"):
            return
        page.mouse.up()
    pytest.fail("this computer is too busy to hold anything for half a second")


def kinds(fake: Fake, *names: str) -> list[dict[str, Any]]:
    """What was heard of these kinds."""
    return [one for one in fake.heard if one["t"] in names]


WAYS: dict[str, Callable[[Page], Any]] = {
    "let go": lambda page: page.mouse.up(),
    "hidden": hide,
    "window left": lambda page: page.evaluate("dispatchEvent(new Event('blur'))"),
    "page left": lambda page: page.evaluate("dispatchEvent(new Event('pagehide'))"),
    "touch taken": lambda page: page.evaluate(
        "document.querySelector('.pad').dispatchEvent(new PointerEvent('pointercancel', {pointerId: 1}))"
    ),
    "Escape": lambda page: page.keyboard.press("Escape"),
    "other tab of the panel": lambda page: page.evaluate("document.querySelector('#tabbutton-go').click()"),
    "stop": lambda page: page.evaluate("document.querySelector('#stop').click()"),
    "page busy": lambda page: page.evaluate("{const end = Date.now() + 700; while (Date.now() < end);}"),
}


@pytest.mark.parametrize("way", WAYS)
def test_every_way_of_not_being_there_lets_go(browser: Browser, served: tuple[Fake, str], way: str) -> None:
    """Beats come while it is held; then one release, and nothing more while it is still held."""
    fake, url = served
    drive: list[dict[str, Any]] = []
    with person(browser, url) as page:
        allow(page)
        assert not [message for message in fake.heard if message["t"] in ("press", "beat")]
        held(page, fake)
        WAYS[way](page)
        until(lambda: [one for one in fake.heard if one["t"] == "release"], page, 2.0 * crowd())
        page.wait_for_timeout(500)
        if way != "let go":
            page.mouse.move(500, 300)  # still held, and moved
            page.wait_for_timeout(300)
        drive = [one for one in fake.heard if one["t"] in ("press", "beat", "release")]
        page.mouse.up()
    said = ",".join(one["t"] for one in drive)
    assert re.fullmatch("press(,beat)+,release", said)
    numbers = [one["seq"] for one in drive if "seq" in one]
    assert numbers == sorted(set(numbers))


def test_keys_drive_and_a_new_press_is_needed(browser: Browser, served: tuple[Fake, str]) -> None:
    """Arrow keys hold; after the window was left, the key that is still down does nothing."""
    fake, url = served
    with person(browser, url) as page:
        allow(page)
        page.focus(".pad") if page.get_attribute(".pad", "tabindex") else page.evaluate(
            "document.activeElement.blur()"
        )
        page.keyboard.down("ArrowUp")
        beat = until(lambda: [one for one in fake.heard if one["t"] == "beat"], page)[0]
        assert beat["vx"] > 0
        page.evaluate("dispatchEvent(new Event('blur'))")
        until(lambda: [one for one in fake.heard if one["t"] == "release"], page)
        count = len(fake.heard)
        page.wait_for_timeout(400)
        assert len(fake.heard) == count
        page.keyboard.up("ArrowUp")
        page.keyboard.down("ArrowLeft")
        until(lambda: len([one for one in fake.heard if one["t"] == "press"]) == 2, page)
        page.keyboard.up("ArrowLeft")


def test_driving_is_off_until_it_is_allowed_and_confirmed(browser: Browser, served: tuple[Fake, str]) -> None:
    """Without --allow-driving there is no pad and no switch; with it the box must be ticked."""
    fake, url = served
    with person(browser, url) as page:
        page.click("#tabbutton-drive")
        page.keyboard.down("ArrowUp")
        page.wait_for_timeout(300)
        page.keyboard.up("ArrowUp")
        page.click("#drive-on")
        assert page.is_disabled("#warning-yes")
        assert "bypasses the robot's obstacle avoidance" in page.inner_text("#warning")
        assert page.is_visible("#stop")
        assert page.locator(".pad").count() == 0
    fake.allow_driving = False
    with person(browser, url) as page:
        page.click("#tabbutton-drive")
        page.wait_for_selector("#tab-drive >> text=--allow-driving")
        assert page.locator("#drive-on").count() == 0
    assert not [one for one in fake.heard if one["t"] in ("press", "beat", "confirm")]


def test_control_is_asked_for_and_handed_over(browser: Browser, served: tuple[Fake, str]) -> None:
    """Two viewers: the second asks, the first hands over, and only then the second may drive."""
    fake, url = served
    with person(browser, url) as first, person(browser, url) as second:
        first.click("#tabbutton-drive")
        first.click("text=Take control")
        first.wait_for_selector("text=You have control.")
        second.click("#tabbutton-drive")
        second.wait_for_selector(".lease >> text=page 1 has control.")
        second.click("text=Ask for control")
        first.wait_for_selector("#notices >> text=page 2 asks for control.")
        first.click("#notices >> text=Hand over")
        second.wait_for_selector("text=You have control.")
        assert fake.holder == "page 2"


def test_a_press_takes_the_control_that_nobody_has(browser: Browser, served: tuple[Fake, str]) -> None:
    """It has lapsed unnoticed: the pad says that it is ready, and so it is."""
    fake, url = served
    with person(browser, url, PHONE) as page:
        allow(page)
        fake.holder = None
        page.wait_for_selector(".lease >> text=Nobody has control.", state="attached")
        assert page.inner_text(".drivestate") == "Ready to drive"
        held(page, fake)
        assert fake.holder == "page 1"
        page.mouse.up()


def test_a_press_takes_no_control_away_and_the_pad_says_so_before(
    browser: Browser, served: tuple[Fake, str]
) -> None:
    """Beside the pad: who has it, and the button that asks for it."""
    fake, url = served
    with person(browser, url, PHONE) as page:
        allow(page)
        fake.holder = "page 7 at 192.0.2.7"
        page.wait_for_selector(".drivestate.bad >> text=page 7 (192.0.2.7) has control.")
        hold(page)
        page.mouse.up()
        page.wait_for_selector(".toast.bad >> text=page 7 (192.0.2.7) has control.")
        assert kinds(fake, "press") == []
        assert (fake.holder, fake.asking) == ("page 7 at 192.0.2.7", [])
        page.click("#drive-ask")
        until(lambda: fake.asking == ["page 1"], page)


def test_the_pad_is_not_ready_while_a_press_would_be_refused(
    browser: Browser, served: tuple[Fake, str]
) -> None:
    fake, url = served
    reason = {"key": "emergency_stop", "text": "pressed", "values": {}, "blocking": True, "doubt": False}
    with person(browser, url) as page:
        allow(page)
        fake.ready = {"answer": "no", "text": "", "reasons": [reason]}
        page.wait_for_selector(".drivestate.bad >> text=It cannot move now: The emergency stop is pressed.")
        fake.ready = {"answer": "yes", "text": "", "reasons": []}
        page.wait_for_selector(".drivestate >> text=Ready to drive")
        fake.goals = [{"id": "1", "kind": "mark", "who": "a program", "state": "running", "done": False}]
        page.wait_for_selector(".drivestate.bad >> text=A task is under way.")


@pytest.mark.promise("is put into it as text, never as HTML")
def test_what_a_robot_says_is_shown_as_text(
    browser: Browser, served: tuple[Fake, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A mark, a fault and a reason that look like HTML make no element and run nothing."""
    from tests.web import fake_server

    fake, url = served
    html = "<img src=x onerror=document.title='taken'><b id=planted>B</b>"
    monkeypatch.setattr(fake_server, "MARKS", [{**fake_server.MARKS[0], "name": html, "note": html}])
    fake.ready = {"answer": "no", "text": html, "reasons": [{"key": html, "text": html, "blocking": True}]}
    fault = {"code": 7, "level": html, "text": html, "text_zh": html}
    fake.faults = {"known": True, "present": True, "text": html, "active": [fault]}
    with person(browser, url) as page:
        page.click(".markrow")
        assert html in page.inner_text("#confirm-text")
        page.click("#confirm .plain")
        page.click("#fault-chip")
        page.wait_for_selector("#tab-health li >> text=planted")
        assert html in page.inner_text("#notices")
        assert page.locator("#planted").count() == 0
        assert page.title() == "woosh-42"


def test_everything_is_reached_by_the_keyboard(browser: Browser, served: tuple[Fake, str]) -> None:
    """Tab reaches STOP, the map, the tabs and the marks; the first step skips to STOP; focus can be seen."""
    with person(browser, served[1]) as page:
        page.keyboard.press("Tab")
        page.keyboard.press("Enter")
        page.keyboard.press("Tab")
        seen: list[str] = []
        for _ in range(40):
            seen.append(page.evaluate("document.activeElement.id || document.activeElement.className"))
            page.keyboard.press("Tab")
        assert {"canvas", "stop", "tabbutton-go", "markrow", "choose-place"} <= set(seen), seen
        page.focus("#tabbutton-go")
        page.keyboard.press("ArrowRight")
        assert page.get_attribute("#tabbutton-missions", "aria-selected") == "true"
        outline = page.evaluate("getComputedStyle(document.activeElement).outlineStyle")
        assert outline != "none"
