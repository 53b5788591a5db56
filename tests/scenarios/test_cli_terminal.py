"""`woosh watch` and `woosh drive` on a terminal: what is on the screen, and that the robot stops."""

from __future__ import annotations

import io
import os
import re
import signal
import sys
import threading
import time

import pytest

if sys.platform == "win32":
    pytest.skip("needs a pseudo-terminal", allow_module_level=True)

from rosproto import Node
from rosproto.master.api import MasterApi
from tests.support.terminal import ELSEWHERE, LAUNCH, Terminal
from tests.support.woosh_command import woosh_process
from woosh_pure import Chassis
from woosh_pure.geometry import Pose2D

pytestmark = pytest.mark.whole

UP, DOWN, RIGHT, LEFT = (f"\x1b[{final}" for final in "ABCD")
ACKNOWLEDGED = ("--acknowledged", "--feedback-timeout", "2")


@pytest.fixture
def slow(sim, real_time):
    """A simulated chassis in real time."""
    return sim


def wanted(sim) -> float:
    """Forward velocity that the simulated base was told last, m/s."""
    with sim.lock:
        return sim.world.body.velocity.vx


def drive(sim, *more: str) -> Terminal:
    return Terminal("drive", "--master", sim.master_uri, *(more or ACKNOWLEDGED), columns=120)


def standing(sim) -> bool:
    with sim.lock:
        return sim.world.body.velocity.is_standing()


def hold(terminal, key: str, sim, until, timeout: float = 30.0) -> None:
    """Repeat a key as a held one does, until something holds."""
    end = time.monotonic() + timeout
    while not until():
        assert time.monotonic() < end, f"it did not come true; the screen:\n{terminal.text}"
        terminal.send(key)
        time.sleep(0.04)


def test_drive_asks_in_the_language_of_who_drives(slow):
    """Who says no has sent nothing."""
    with drive(slow, "--lang", "zh") as terminal:
        asked = terminal.wait_for(lambda text: "确认后输入 yes" in text)
        assert [line.replace(" ", "") for line in asked.splitlines()[:4]] == [
            "速度控制会绕过底盘的避障和限制。",
            "周围必须没有人和障碍物。请一直看着机器人，红色急停按钮要伸手可及。",
            "本程序不是急停：程序或网络中断后，机器人可能继续行驶。",
            "确认后输入yes开始：",
        ]
        terminal.send("no\r")
        assert terminal.exit_code() == 3
        assert "没有确认，没有发送任何命令" in terminal.text
    with drive(slow, *ACKNOWLEDGED, "--lang", "zh") as terminal:
        terminal.wait_for(lambda text: "速度档" in text and "已发送" in text and "测得" in text)
        terminal.send("q")
        assert terminal.exit_code() == 0
        assert "机器人已停稳" in terminal.text
    assert standing(slow)


# -- watch ---------------------------------------------------------------------------------------------------


def test_watch_shows_map_robot_scan_battery_and_rates(slow):
    """The hall with its pillars, the robot in it, and the facts at the right."""
    slow.report(110201000013)
    with Terminal("watch", "--master", slow.master_uri, columns=100, rows=30) as terminal:
        facts = ("pose     0.00 0.00 m 0°", "battery  █████████░ 87 %", "velocity +0.00 m/s +0°/s", "nearest")
        drawn = ("→", "•", "█" * 10)  # the robot, the scan, the wall
        first = terminal.wait_for(
            lambda text: all(part in text for part in (*facts, *drawn, "pose           "))
        )
        assert first.startswith(f"woosh watch {slow.master_uri}")
        assert "q: leave" in first.splitlines()[0]
        assert terminal.screen.alternate
        assert not terminal.screen.cursor_visible
        terminal.send("q")
        assert terminal.exit_code() == 0
        assert not terminal.screen.alternate
        assert terminal.screen.cursor_visible
        assert terminal.restored
        assert terminal.screen.unknown == []


def test_watch_follows_the_robot_and_tells_faults(slow, until):
    with Terminal("watch", "--master", slow.master_uri, "--rate", "10") as terminal:
        terminal.wait_for("→")
        until(
            lambda: (
                slow.graph.first("/status_code").connections and slow.graph.first("/robot_status").connections
            )
        )
        with slow.lock:
            slow.world.body.pose = Pose2D(4.0, 1.0, 3.14159 / 2)
        slow.press_emergency_stop()
        text = terminal.wait_for(lambda t: "NOT READY" in t and "emergency stop" in t)
        assert "faults" in text
        slow.release_emergency_stop()
        terminal.wait_for(lambda t: re.search(r"faults +none", t))  # the robot says that it is idle


def test_watch_on_a_narrow_terminal_puts_the_map_below(slow):
    with Terminal("watch", "--master", slow.master_uri, columns=60, rows=45) as terminal:
        lines = terminal.wait_for(lambda t: "→" in t and "rates" in t).splitlines()
        rates = next(i for i, line in enumerate(lines) if line.startswith("rates"))
        robot = next(i for i, line in enumerate(lines) if "→" in line)
        assert robot > rates


@pytest.mark.parametrize(
    ("columns", "rows", "shows"),
    [
        (40, 10, ["q: leave", "emergency stop", "pose", "87 %"]),
        (60, 20, ["q: leave", "emergency stop", "pose", "87 %", "→", "█"]),
        (80, 12, ["q: leave", "emergency stop", "pose", "87 %", "→", "█"]),
        (200, 60, ["q: leave", "emergency stop", "pose", "87 %", "→", "█", "rates"]),
        (20, 5, ["woosh watch"]),
        (1, 1, ["w"]),
    ],
)
def test_watch_shows_what_matters_on_a_screen_of_any_size(slow, columns, rows, shows):
    """What has to be left out is the least important."""
    arguments = ("--master", slow.master_uri, "--rate", "10")
    with Terminal("watch", *arguments, columns=columns, rows=rows) as terminal:

        def complete(text: str) -> bool:
            slow.report(110201000013)  # a code is told when it changes only: until it has been heard
            return all(word in text for word in shows)

        terminal.wait_for(complete)
        assert terminal.screen.unknown == []
        terminal.send("q")
        assert terminal.exit_code() == 0


@pytest.mark.parametrize("encoding", ["ascii", "cp1252", "cp936"])
def test_watch_draws_with_what_the_encoding_has(slow, encoding):
    with Terminal("watch", "--master", slow.master_uri, PYTHONIOENCODING=encoding) as terminal:
        text = terminal.wait_for(lambda t: "87 %" in t and ">" in t and "###" in t)
        assert text.isascii()
        terminal.send("q")
        assert terminal.exit_code() == 0


@pytest.mark.slow
def test_no_colours_with_no_color_and_whole_lines_on_a_dumb_terminal(slow):
    with Terminal("watch", "--master", slow.master_uri, NO_COLOR="1") as terminal:
        terminal.wait_for("87 %")
        assert not any(sequence.endswith("m") for sequence in terminal.screen.seen)
        terminal.send("q")
        assert terminal.exit_code() == 0
    with Terminal("watch", "--master", slow.master_uri, "--for", "2.5", TERM="dumb") as terminal:
        assert terminal.exit_code() == 0
        assert " in map  " in terminal.text
        assert terminal.screen.seen == []


def test_a_sign_of_life_counts_on_a_terminal_and_goes_away(slow):
    with Terminal("faults", "--listen", "2.5", "--master", slow.master_uri, columns=40, rows=10) as terminal:
        terminal.wait_for(lambda text: re.search(r"listening: \d s", text))
        assert terminal.exit_code() == 5  # no code came, and no state: not known
        assert "listening" not in terminal.text


@pytest.mark.parametrize("columns", [40, 80])
def test_one_line_tells_how_far_a_motion_is(slow, columns):
    """A second one over it would be a flicker that nobody can read; what it was is gone at the end."""
    seen: set[str] = set()

    def ended(text: str) -> bool:
        seen.update(text.splitlines())
        return "arrived after" in text

    with Terminal("move", "0.6", "--master", slow.master_uri, columns=columns, rows=12) as terminal:
        terminal.wait_for(ended)
        assert terminal.exit_code() == 0
        assert [line for line in terminal.text.splitlines() if line.startswith("  ")] == []
        assert terminal.screen.unknown == []
    live = [line for line in seen if line.startswith("  ")]
    assert any(" % " in line or " %," in line for line in live)
    assert [line for line in seen if line.startswith("moving") and not line.endswith("...")] == []


def test_a_sign_of_life_stays_in_its_line(slow):
    """As long as it is: what is longer than the terminal is wide cannot be written over."""
    slow.fall_silent(30.0)
    words = ("camera", "--no-file", "--wait", "2.5", "--master", slow.master_uri)
    with Terminal(*words, columns=30, rows=10) as terminal:
        terminal.wait_for(lambda text: re.search(r"^\.\.\..*image_raw: \d s", text, re.M))
        assert terminal.exit_code() == 1
        assert not re.search(r"image_raw: \d s", terminal.text)


@pytest.mark.parametrize(
    ("columns", "rows", "encoding"), [(40, 10, "utf-8"), (100, 30, "utf-8"), (40, 10, "cp1252")]
)
def test_a_plot_fits_its_terminal(slow, columns, rows, encoding):
    words = ("topic", "echo", "/scan/ranges[0]", "--plot", "--master", slow.master_uri)
    size = {"columns": columns, "rows": rows}
    with Terminal(*words, module="rosproto", **size, PYTHONIOENCODING=encoding) as terminal:
        axis = "┤" if encoding == "utf-8" else "|"
        lines = terminal.wait_for(lambda t: t.count(axis) >= min(rows - 3, 8) and "now" in t).splitlines()
        assert lines[0].startswith("/scan/ranges[0]  ")
        assert all(axis in line for line in lines[1 : rows - 2 if rows < 14 else 9])
        assert terminal.screen.unknown == []
        terminal.send("\x03")
        assert terminal.exit_code() == 130
        assert "Traceback" not in terminal.text


def test_watch_leaves_the_terminal_in_order_on_ctrl_c(slow):
    with Terminal("watch", "--master", slow.master_uri, "--ascii", NO_COLOR="1") as terminal:
        text = terminal.wait_for(lambda t: "87 %" in t and ">" in t)
        assert text.isascii()
        terminal.send("\x03")
        assert terminal.exit_code() == 130
        assert terminal.restored
        assert not terminal.screen.alternate
        assert "Traceback" not in terminal.text


# -- drive ---------------------------------------------------------------------------------------------------


def test_drive_asks_once_and_sends_nothing_without_a_yes(slow):
    with drive(slow, "--feedback-timeout", "2") as terminal:
        asked = terminal.wait_for("Type yes to drive:")
        assert asked.splitlines()[:4] == [
            "DRIVING BY VELOCITY BYPASSES THE CHASSIS'S OBSTACLE AVOIDANCE AND LIMITS.",
            "The area must be clear. Watch the robot all the time, and keep its red button within reach.",
            "This program is not an emergency stop: if it or the network fails, the robot may keep driving.",
            "Type yes to drive:",
        ]
        terminal.send("no\n")
        assert terminal.exit_code() == 3
        assert "not acknowledged" in terminal.text
    with drive(slow, "--feedback-timeout", "2") as terminal:
        terminal.wait_for("Type yes to drive:")
        terminal.send("yes\n")
        terminal.wait_for("sent +0.00")
        hold(terminal, UP, slow, lambda: wanted(slow) > 0.05)
        terminal.send("q")
        assert terminal.exit_code() == 0
        assert terminal.text.count("Type yes") == 1
        assert "the robot stands still" in terminal.text


def test_zero_is_on_the_wire_within_four_tenths_of_a_second_of_the_last_key(slow, until):
    """By the times at which another node receives the velocities: after silence, and at once after another key."""
    got: list[tuple[float, float]] = []
    with (
        Node("/spy", master_uri=slow.master_uri, rosout=False) as spy,
        spy.subscriber(
            "/base_cmd_vel",
            "geometry_msgs/Twist",
            lambda m: got.append((time.monotonic(), m.linear.x)),
            queue_size=1000,
        ),
        drive(slow, *ACKNOWLEDGED, "--direct") as terminal,
    ):
        terminal.wait_for("sent +0.00")

        def seconds_to_zero(key: str, last_key: str) -> float:
            got.clear()
            hold(terminal, key, slow, lambda: any(vx > 0.0 for _, vx in list(got)))
            terminal.send(last_key)
            last = time.monotonic()
            until(lambda: any(at > last and vx == 0.0 for at, vx in list(got)))
            until(lambda: standing(slow))
            return next(at for at, vx in got if at > last and vx == 0.0) - last

        # A busy computer is late now and then; the promise is kept when nothing is in the way.
        assert any(seconds_to_zero(UP, UP) <= 0.4 for _ in range(10))
        assert any(seconds_to_zero("w", "w") <= 0.4 for _ in range(10))
        assert any(seconds_to_zero(UP, "x") <= 0.15 for _ in range(10))
        terminal.send("q")
        assert terminal.exit_code() == 0


def test_keys_pressed_before_the_drive_is_open_move_nothing(slow):
    with drive(slow, "--feedback-timeout", "2", "--direct") as terminal:
        terminal.wait_for("Type yes to drive:")
        terminal.send("yes\n" + UP * 3)
        terminal.wait_for("sent +0.00")
        for _ in range(20):
            assert standing(slow)
            time.sleep(0.02)
        terminal.send("q")
        assert terminal.exit_code() == 0


@pytest.mark.slow
@pytest.mark.promise("a stop while a motion is being prepared")
def test_a_stop_by_another_program_while_the_drive_is_opened_keeps_it_from_driving(slow, until, monkeypatch):
    """Keys that were pressed before it move nothing; one that is pressed after it does."""
    driver = ""
    has_looked, stopped = threading.Event(), threading.Event()
    dispatch = MasterApi.dispatch

    def noted(self, method, params, peer=""):
        """Keep the drive from the answer to its look for other programs, which it does when it has registered."""
        nonlocal driver
        answer = dispatch(self, method, params, peer)
        caller, *more = params[:2]
        if (method, more) == ("registerPublisher", ["/base_cmd_vel"]):
            driver = driver or caller  # the other program comes later
        elif (method, caller) == ("getSystemState", driver) and not stopped.is_set():
            has_looked.set()  # before: a program that is sending zeros is one that can drive
            stopped.wait(20.0)
        return answer

    monkeypatch.setattr(MasterApi, "dispatch", noted)
    with (
        drive(slow, "--feedback-timeout", "2", "--direct") as terminal,
        Chassis(slow.master_uri) as other,
    ):
        terminal.wait_for("Type yes to drive:")
        terminal.send("yes\n")
        terminal.wait_for("any other key: stop")
        assert has_looked.wait(20.0)
        terminal.send(UP * 3)
        other.stop(everything=True, timeout=0.5)
        assert "sent" not in terminal.text, "the drive was open before the stop"
        stopped.set()
        terminal.wait_for("sent +0.00")
        end = time.monotonic() + 1.0
        while time.monotonic() < end:
            assert standing(slow)
            time.sleep(0.02)
        hold(terminal, UP, slow, lambda: wanted(slow) > 0.05)
        terminal.send("q")
        assert terminal.exit_code() == 0


def test_a_limit_above_the_chassis_s_own_is_refused(slow):
    with drive(slow, "--acknowledged", "--linear", "9") as terminal:
        assert terminal.exit_code() == 2
        assert "at most the chassis's limit" in terminal.text
        assert terminal.restored


def test_turning_left_and_right_and_backward(slow):
    with drive(slow, *ACKNOWLEDGED, "--direct") as terminal:
        terminal.wait_for("sent +0.00")

        def turning(sign):
            with slow.lock:
                return slow.world.body.velocity.wz * sign > 0.05

        hold(terminal, LEFT, slow, lambda: turning(1))
        hold(terminal, "d", slow, lambda: turning(-1))
        hold(terminal, DOWN, slow, lambda: wanted(slow) < -0.03)
        terminal.send("\x1b")
        assert terminal.exit_code() == 0
        assert standing(slow)


@pytest.mark.slow
def test_the_drive_is_over_when_the_chassis_falls_silent(slow):
    with drive(slow, "--acknowledged", "--direct", "--feedback-timeout", "0.8") as terminal:
        terminal.wait_for("sent +0.00")
        hold(terminal, UP, slow, lambda: wanted(slow) > 0.05)
        slow.fall_silent(30.0)
        hold(terminal, UP, slow, lambda: terminal.process.poll() is not None)
        assert terminal.exit_code() == 4
        assert "the drive is over" in terminal.text
        assert "silent" in terminal.text
        assert standing(slow)
        assert terminal.restored


@pytest.mark.slow
def test_the_drive_is_over_when_the_node_that_listens_dies(slow):
    """The link itself drops: nobody subscribes to the velocity any more."""
    with drive(slow, "--acknowledged", "--direct", "--feedback-timeout", "5") as terminal:
        terminal.wait_for("sent +0.00")
        hold(terminal, UP, slow, lambda: wanted(slow) > 0.05)
        slow.crash_node("/mobile_base_nodelet_manager")
        hold(terminal, UP, slow, lambda: terminal.process.poll() is not None)
        assert terminal.exit_code() == 4
        assert "no longer has a subscriber" in terminal.text
        assert terminal.restored


@pytest.mark.promise(
    "Ctrl-C or SIGTERM in a `woosh` command", "SIGQUIT (Ctrl-\\\\) or SIGHUP to a `woosh` command"
)
@pytest.mark.parametrize(
    ("end", "code"), [("ctrl-c", 130), (signal.SIGTERM, 143), (signal.SIGHUP, 143), (signal.SIGQUIT, 143)]
)
def test_ctrl_c_and_signals_stop_the_robot_and_restore_the_terminal(slow, end, code):
    with drive(slow, *ACKNOWLEDGED) as terminal:
        terminal.wait_for("sent +0.00")
        hold(terminal, UP, slow, lambda: wanted(slow) > 0.05)
        if end == "ctrl-c":
            terminal.send("\x03")
        else:
            terminal.process.send_signal(end)
        assert terminal.exit_code() == code
        assert standing(slow)
        assert terminal.restored
        assert "stands still" in terminal.text
        assert "Traceback" not in terminal.text


@pytest.mark.promise("SIGQUIT (Ctrl-\\\\) or SIGHUP to a `woosh` command, or the end of its terminal")
@pytest.mark.parametrize("launch", [LAUNCH, ELSEWHERE], ids=["with SIGHUP", "by EIO alone"])
@pytest.mark.parametrize("verb", ["drive", "goto", "watch"])
def test_a_closed_terminal_stops_the_robot_and_ends_the_command_with_143(slow, until, verb, launch):
    """Whether the signal or the failed write comes first, or no signal at all: a program of another session gets none."""
    words = {"drive": ACKNOWLEDGED, "goto": ("A1",), "watch": ()}[verb]
    with Terminal(
        verb, "--master", slow.master_uri, *words, columns=120, launch=(sys.executable, "-c", launch)
    ) as terminal:
        if verb == "drive":
            terminal.wait_for("sent +0.00")
            hold(terminal, UP, slow, lambda: wanted(slow) > 0.05)
        elif verb == "goto":
            until(lambda: not standing(slow))
        else:
            terminal.wait_for("attery")
        terminal.hang_up()
        assert terminal.process.wait(30) == 143
        until(lambda: standing(slow))


def test_ctrl_z_does_not_put_a_driving_program_to_sleep(slow, until):
    with drive(slow, *ACKNOWLEDGED) as terminal:
        terminal.wait_for("sent +0.00")
        hold(terminal, UP, slow, lambda: wanted(slow) > 0.05)
        terminal.send("\x1a")
        os.kill(terminal.process.pid, signal.SIGTSTP)
        until(lambda: standing(slow))
        terminal.send("q")
        assert terminal.exit_code() == 0


def test_shell_is_python_with_a_chassis(slow):
    with Terminal("shell", "--master", slow.master_uri) as terminal:
        terminal.wait_for(">>>")
        terminal.send("chassis.battery.wait().percent\n")
        terminal.wait_for(lambda text: re.search(r"^87\s+>>>", text, re.M))  # it reads again
        terminal.send("\x04")
        assert terminal.exit_code() == 0


@pytest.mark.slow
def test_a_simulated_robot_is_driven_at_once():
    """No warning and no question: nothing can be hit. The line of --sim says whose robot it is, and how to share one."""
    with Terminal("--sim", "drive", "--feedback-timeout", "5", columns=200) as terminal:
        terminal.wait_for("measured +0.00")
        assert "Type yes" not in terminal.text
        assert "a new simulated robot, for this command alone" in terminal.text
        assert "`woosh sim` and, beside it, `woosh connect 127.0.0.1`" in terminal.text
        terminal.send("w")
        terminal.wait_for(lambda text: "sent +0.1" in text)
        terminal.send("q")
        terminal.wait_for("stands still")


@pytest.mark.slow
def test_an_address_that_no_phone_reaches_is_no_code():
    pytest.importorskip("fastapi", reason="needs the extra `web`")
    pytest.importorskip("segno", reason="needs the extra `web`")
    with Terminal(
        "sim", "--robots", "2", "--port", "0", "--page-port", "0", columns=200, rows=60
    ) as terminal:
        assert "█" not in terminal.wait_for("try:")


@pytest.mark.slow
def test_the_address_for_a_phone_is_whole_where_the_terminal_is_the_owners(tmp_path):
    """With the token and as a QR code; neither a pipe nor a log gets the token of a file."""
    pytest.importorskip("fastapi", reason="needs the extra `web`")
    segno = pytest.importorskip("segno", reason="needs the extra `web`")
    token = tmp_path / "token"
    token.write_text("Kd83-hsa2-Pq")
    token.chmod(0o600)
    words = ("--sim", "web", "--bind", "0.0.0.0", "--port", "0", "--no-browser", "--token-file", str(token))
    with Terminal(*words, columns=200, rows=60) as terminal:
        text = terminal.wait_for("for programs:")
        found = re.search(r"the page for others: (http://(?!127)[^/]+:\d+/#token=Kd83-hsa2-Pq)", text)
        assert found
        segno.make(found[1], error="l", micro=False).terminal(code := io.StringIO(), border=2, compact=True)
        assert code.getvalue().strip("\n") in text
    process = woosh_process(*words)
    try:
        lines = [process.stdout.readline() for _ in range(3)]
    finally:
        process.kill()
        process.communicate(timeout=10)
    assert any("the page for others: http://" in line for line in lines)
    assert not any("Kd83" in line or "█" in line for line in lines)
