"""The page in a real window: whatever takes the key-up or the pointer-up away from it ends the drive.

A menu, a dialog or another window is opened by the mouse and keyboard of a screen while a control is held; the hand lets
go where the page does not see it. WINDOW_TRIALS=50 in the environment repeats each way so often (`-s` shows the longest
times), and HOLD_SECONDS=60 holds so long where nothing disturbs.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import pytest

from tests.support.real_window import RealWindow, real_window
from tests.web.test_page_alone import kinds
from tests.web.test_page_pad import BUSY

if TYPE_CHECKING:
    from tests.web.fake_server import Fake

pytestmark = pytest.mark.slow
TRIALS = int(os.environ.get("WINDOW_TRIALS", "1"))
HOLD = float(os.environ.get("HOLD_SECONDS", "4"))
AT_ONCE, REPEATS = 1.0, 2.5
"""Seconds until the last beat. The first is for events that the page sees, on a busy computer; the second is for repeats
that do not come any more."""


@pytest.fixture(scope="module")
def served() -> Iterator[tuple[Fake, str]]:
    for module in ("fastapi", "uvicorn", "websockets", "PIL"):
        pytest.importorskip(module, reason=f'{module} is not installed: pip install ".[web]"')
    from tests.web.fake_server import Fake, Served

    fake = Fake()
    fake.robots = ["woosh-42", "woosh-43"]
    with Served(fake) as server:
        yield fake, server.url


@pytest.fixture(scope="module")
def opened(served: tuple[Fake, str], tmp_path_factory: pytest.TempPathFactory) -> Iterator[RealWindow]:
    """A window in which driving is switched on."""
    with real_window(tmp_path_factory.mktemp("window"), served[1]) as window:
        for selector in ("#tabbutton-drive", "#drive-on", "#warning-check", "#warning-yes"):
            window.click(selector)
        window.until("document.querySelector('.lease').innerText.includes('You have control')")
        yield window


class Hand:
    """What a person holds, and what the server hears of it."""

    def __init__(self, window: RealWindow, fake: Fake) -> None:
        self.window, self.fake = window, fake

    def down(self, control: str) -> None:
        """Begin to hold."""
        if control == "key":
            self.window.move("#canvas")
            self.window.xdotool("keydown", "a")
        else:
            self.window.move(".pad", 0, -40)
            self.window.xdotool("mousedown", 1)

    def up(self, control: str) -> None:
        """Let go, whoever sees it."""
        self.window.xdotool(*(("keyup", "a") if control == "key" else ("mouseup", 1)))

    def hold(self, control: str, seconds: float) -> None:
        """Hold, until the page has driven for so long: a busy computer ends a drive, and it is pressed again."""
        for _ in range(15):
            self.fake.heard.clear()
            self.down(control)
            deadline = time.monotonic() + seconds + 3.0
            while time.monotonic() < deadline and not kinds(self.fake, "release"):
                pressed = kinds(self.fake, "press")
                if pressed and time.monotonic() - pressed[0]["time"] > seconds:
                    return
                time.sleep(0.02)
            self.up(control)
            time.sleep(0.2)
        pytest.fail(f"nothing can be held for {seconds} s: {self.state}")

    def seconds_to_silence(self, since: float) -> float:
        """Return the time of the last beat, once none has come for 0.6 s; at least 0."""
        while time.monotonic() - (last := max([since, *self.beats()])) < 0.6:
            assert last - since < 6.0, f"it drives on: {self.state}"
            time.sleep(0.02)
        return last - since

    def beats(self) -> list[float]:
        """When a press or a beat came."""
        return [one["time"] for one in kinds(self.fake, "press", "beat")]

    @property
    def state(self) -> str:
        return str(self.window.evaluate("document.querySelector('.drivestate').innerText"))

    def quiet(self) -> None:
        """Nothing is held or open, and the page has the keyboard."""
        self.window.xdotool("mouseup", 1, "mouseup", 3, "keyup", "a")
        for _ in range(20):
            self.window.xdotool("key", "Escape")
            time.sleep(0.1)
            self.window.click("#scale")
            if self.window.evaluate("document.hasFocus()"):
                break
        self.window.xdotool("key", "a", "key", "a")  # one whose key-up was not seen is pressed once more
        time.sleep(0.2)


def keys(*names: str) -> Callable[[RealWindow], object]:
    return lambda window: window.xdotool("key", *names)


def frame(dy: int, button: int) -> Callable[[RealWindow], object]:
    """Press in the browser's own frame, so far below the upper edge of the window."""

    def press(window: RealWindow) -> None:
        x, y = window.evaluate("[screenX, screenY]")
        window.xdotool("mousemove", x + 700, y + dy, "click", button)

    return press


def alert(window: RealWindow) -> None:
    window.evaluate("(() => { setTimeout(() => alert('a dialog'), 0); return 0; })()")


def lift_left_while_right_is_held(window: RealWindow) -> None:
    window.xdotool("mousedown", 3)
    time.sleep(0.1)
    window.xdotool("mouseup", 1, "mousemove_relative", 2, 2)


WAYS: dict[str, tuple[str, float, Callable[[RealWindow], object]]] = {
    "right click on the map": ("key", AT_ONCE, lambda window: window.click("#canvas", 3)),
    "the Menu key": ("key", AT_ONCE, keys("Menu")),
    "Shift and F10": ("key", AT_ONCE, keys("shift+F10")),
    "F10": ("key", AT_ONCE, keys("F10")),
    "Alt and F": ("key", AT_ONCE, keys("alt+f")),
    "Alt": ("key", AT_ONCE, keys("alt")),
    "the Windows or Command key": ("key", AT_ONCE, keys("super")),
    "another window by Alt and Tab": ("key", AT_ONCE, keys("alt+Tab")),
    "find in the page": ("key", AT_ONCE, keys("ctrl+f")),
    "print": ("key", AT_ONCE, keys("ctrl+p")),
    "the list of robots": ("key", AT_ONCE, lambda window: window.click("#robots select")),
    "the mouse on the map": ("key", AT_ONCE, lambda window: window.click("#canvas")),
    "a dialog of the browser": ("key", AT_ONCE, alert),
    "the address bar": ("key", AT_ONCE, frame(58, 1)),
    "a menu of the browser's frame": ("key", REPEATS, frame(20, 3)),
    "the right button, beside the left one": ("pad", AT_ONCE, lambda window: window.xdotool("mousedown", 3)),
    "the left button lifted while the right one is held": ("pad", AT_ONCE, lift_left_while_right_is_held),
    "a menu by keys while the pad is held": ("pad", AT_ONCE, keys("alt+f")),
    "a key while the pad is held": ("pad", AT_ONCE, keys("a")),
}


@pytest.mark.promise("something else is pressed, touched or opened")
@pytest.mark.parametrize("way", WAYS)
def test_what_takes_the_release_away_ends_the_drive(
    served: tuple[Fake, str], opened: RealWindow, way: str
) -> None:
    """At once; nothing resumes when what was opened is closed, and afterwards a new press drives."""
    control, limit, take = WAYS[way]
    hand, times = Hand(opened, served[0]), []
    for _ in range(TRIALS):
        hand.quiet()
        hand.hold(control, 1.2 if limit == REPEATS else 0.4)
        take(opened)  # the programs of these hands take their time
        times.append(hand.seconds_to_silence(time.monotonic()))
        assert times[-1] < limit, f"{times[-1]:.2f} s: {hand.state}"
        hand.up(control)
        count = len(hand.beats())
        opened.xdotool("key", "Escape")
        opened.click("#scale")
        time.sleep(0.4)
        assert len(hand.beats()) == count, f"it resumed: {hand.state}"
    hand.quiet()
    hand.hold("key", 0.3)
    hand.up("key")
    print(f"\n{way}: {len(times)} trials, last beat at most {max(times):.2f} s later")


@pytest.mark.parametrize("control", ["key", "pad"])
def test_what_nothing_disturbs_goes_on_until_it_is_let_go(
    served: tuple[Fake, str], opened: RealWindow, control: str
) -> None:
    """The watch for missing repeats costs no good drive; a computer that held up the page may."""
    fake, _ = served
    hand = Hand(opened, fake)
    ended = 0
    for _ in range(TRIALS):
        hand.quiet()
        hand.hold(control, 0.4)
        deadline = time.monotonic() + HOLD
        while time.monotonic() < deadline and not kinds(fake, "release"):
            time.sleep(0.02)
        if kinds(fake, "release"):
            ended += 1
            assert BUSY in hand.state
        hand.up(control)
        deadline = time.monotonic() + 10.0
        while not kinds(fake, "release"):
            assert time.monotonic() < deadline, f"it was let go: {hand.state}"
            time.sleep(0.02)
    print(f"\n{control}: {TRIALS} times {HOLD} s, {ended} ended by a busy computer")


@pytest.mark.promise("something else is pressed, touched or opened")
def test_a_key_that_is_still_held_when_the_menu_closes_drives_nothing(
    served: tuple[Fake, str], opened: RealWindow
) -> None:
    """Its repeats come to the page again; a new press is needed."""
    hand = Hand(opened, served[0])
    for _ in range(TRIALS):
        hand.quiet()
        hand.hold("key", 1.0)
        opened.click("#canvas", 3)
        hand.seconds_to_silence(time.monotonic())
        count = len(hand.beats())
        opened.move("#scale")
        opened.xdotool("click", 1)
        time.sleep(1.0)
        assert len(hand.beats()) == count, hand.state
        hand.up("key")
