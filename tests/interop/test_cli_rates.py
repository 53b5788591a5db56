"""`rosproto topic hz|bw|delay` and the layer's `rostopic` beside Debian's: fed the same messages, they print the same."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from rosproto.cli import topic_rates
from rosproto.time import Time
from tests.support import ros

ROSTOPIC = """
import json, sys, time, rospy, rostopic
verb, window, topics, events = json.loads(sys.argv[1])
now = [0.0]
rospy.get_rostime = lambda: rospy.Time.from_sec(now[0])
time.time = lambda: now[0]
class Message:
    _has_header = True
if verb == "hz":
    meter = rostopic.ROSTopicHz(window)
    arrived, report = meter.callback_hz, lambda: meter.print_hz(topics)
elif verb == "bw":
    meter = rostopic.ROSTopicBandwidth(window)
    arrived, report = lambda m, topic: meter.callback(m), meter.print_bw
else:
    meter = rostopic.ROSTopicDelay(window)
    arrived, report = lambda m, topic: meter.callback_delay(m), meter.print_delay
for now[0], topic, stamp, size in events:
    if topic is None:
        report()
        continue
    message = Message()
    message._buff = bytes(size)
    message.header = Message()
    message.header.stamp = rospy.Time.from_sec(stamp)
    arrived(message, topic)
"""
Events = list[tuple[float, str | None, float, int]]
"""When, on which topic (None: a report is due), the stamp, the length."""


def stream(period: float, size: int, *, topic: str = "/a", count: int = 12, jitter: float = 0.0) -> Events:
    """Messages, some later than others, each a bit older than the one before."""
    return [
        (
            1000.0 + i * period + jitter * (i % 3),
            topic,
            999.9 + i * period - 0.00137 * (i % 4),
            size + 7 * (i % 5),
        )
        for i in range(count)
    ]


def with_reports(*streams: Events) -> Events:
    """A report each second, and two after the last message."""
    events = sorted((event for one in streams for event in one), key=lambda event: event[0])
    end = events[-1][0]
    reports: Events = [(999.6 + i, None, 0.0, 0) for i in range(int(end - 1000.0) + 4)]
    return sorted([*events, *reports], key=lambda event: event[0])


SAMPLES: dict[str, tuple[str, int, list[str], Events]] = {
    "hz": ("hz", 50_000, ["/a"], with_reports(stream(0.25, 10, jitter=0.015625))),
    "hz, small window": ("hz", 4, ["/a"], with_reports(stream(0.25, 10, jitter=0.015625))),
    "hz, all at once": ("hz", 50_000, ["/a"], with_reports(stream(0.0, 10))),
    "hz, one message": ("hz", 50_000, ["/a"], with_reports(stream(1.0, 10, count=1))),
    # As many of each at each report: rostopic shows the first topic's window in the rows of the others, too.
    "hz, two topics": (
        "hz",
        50_000,
        ["/a", "/longer/name"],
        with_reports(
            stream(0.25, 1, count=9), stream(0.25, 1, topic="/longer/name", jitter=0.015625, count=9)
        ),
    ),
    "bw in bytes": ("bw", 100, ["/a"], with_reports(stream(0.5, 20))),
    "bw in kilobytes": ("bw", 100, ["/a"], with_reports(stream(0.02, 700, count=150))),
    "bw in megabytes": ("bw", 100, ["/a"], with_reports(stream(0.05, 900_000))),
    "bw, one message": ("bw", 100, ["/a"], with_reports(stream(1.0, 10, count=1))),
    "delay": ("delay", 50_000, ["/a"], with_reports(stream(0.25, 10, jitter=0.015625))),
    "delay, small window": ("delay", 5, ["/a"], with_reports(stream(0.25, 10, jitter=0.015625))),
    "delay, one message": ("delay", 50_000, ["/a"], with_reports(stream(1.0, 10, count=1))),
}


def of_ours(
    verb: str, window: int, topics: list[str], events: Events, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Run the command's own function with its stream and its clocks replaced."""
    now = [0.0]

    def watch(_: object, arrived: Callable[..., None], report: Callable[[], None], *, raw: bool) -> int:
        for now[0], topic, stamp, size in events:
            if topic is None:
                report()
                continue
            header = SimpleNamespace(stamp=Time(*divmod(round(stamp * 1e9), 10**9)))
            message: Any = SimpleNamespace(_has_header=True, _buff=bytes(size), header=header)
            arrived(topic, message, now[0])
        return 0

    monkeypatch.setattr(topic_rates, "_watch", watch)
    monkeypatch.setattr(topic_rates, "_topics", lambda _: topics)
    monkeypatch.setattr(topic_rates, "time", SimpleNamespace(time=lambda: now[0], monotonic=lambda: now[0]))
    run = {"hz": topic_rates.run_hz, "bw": topic_rates.run_bw, "delay": topic_rates.run_delay}[verb]
    arguments: Any = SimpleNamespace(window=window, filter=None, json=False, topic=topics)
    assert not run(arguments)


@pytest.mark.parametrize("name", SAMPLES)
def test_the_same_numbers_are_the_same_text(
    name: str, ros_installed: None, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    theirs = ros.run_rospy(ROSTOPIC, "http://127.0.0.1:1", json.dumps(SAMPLES[name])).stdout
    of_ours(*SAMPLES[name], monkeypatch)
    assert capsys.readouterr().out == theirs
    assert theirs or "one message" in name


@pytest.mark.parametrize("name", SAMPLES)
def test_programs_that_import_rostopic_print_the_same(name: str, ros_installed: None, tmp_path: Path) -> None:
    """The classes ROSTopicHz, ROSTopicBandwidth and ROSTopicDelay, as monitors use them."""
    theirs = ros.run_rospy(ROSTOPIC, "http://127.0.0.1:1", json.dumps(SAMPLES[name])).stdout
    program = tmp_path / "meter.py"
    program.write_text(ROSTOPIC, "utf-8")
    words = [sys.executable, "-m", "rosproto", "run", str(program), json.dumps(SAMPLES[name])]
    ours = subprocess.run(words, capture_output=True, text=True, timeout=60, check=False)
    assert (ours.stdout, ours.stderr) == (theirs, "")
