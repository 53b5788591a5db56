"""Loggers: one line for each record, and a bounded number about what peers do."""

from __future__ import annotations

import logging
import subprocess
import sys

import pytest

from rosproto.logs import MAX_CHARACTERS, MAX_IN_ALL, MAX_PER_MESSAGE, WINDOW, PeerLog, cut, get_logger


def run(code: str) -> tuple[str, str]:
    """Both streams of a fresh interpreter."""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True
    )
    return done.stdout, done.stderr


def test_a_record_has_the_name_and_line_of_its_caller(caplog: pytest.LogCaptureFixture) -> None:
    log = get_logger("rosproto.test")
    with caplog.at_level("DEBUG", "rosproto.test"):
        log.debug("%s two", "one")
    (record,) = caplog.records
    assert (record.name, record.getMessage()) == ("rosproto.test", "one two")
    assert (record.filename, record.funcName) == (
        "test_logs.py",
        "test_a_record_has_the_name_and_line_of_its_caller",
    )


def test_it_is_the_logger_of_that_name() -> None:
    log = get_logger("rosproto.test.other")
    assert log.isEnabledFor(logging.CRITICAL)
    assert log.manager.getLogger("rosproto.test.other").name == log.name == "rosproto.test.other"
    assert "rosproto.test.other" in repr(log)


def test_a_warning_reaches_a_program_that_never_heard_of_logging() -> None:
    code = "from rosproto.logs import get_logger; get_logger('rosproto.x').warning('! %s', 'lost')"
    assert run(code) == ("", "! lost\n")


def test_a_program_that_sets_logging_up_afterwards_sees_everything() -> None:
    code = (
        "from rosproto.logs import get_logger; log = get_logger('rosproto.x'); log.debug('before');"
        "import logging; logging.basicConfig(level='DEBUG', format='%(levelname)s %(message)s');"
        "log.debug('after')"
    )
    assert run(code) == ("", "DEBUG after\n")


@pytest.mark.promise("the rest is counted")
def test_a_flood_is_counted_instead_of_told(caplog: pytest.LogCaptureFixture) -> None:
    """So much about one thing and no more; the next record after a while says how many were left out."""
    now = [0.0]
    said = PeerLog("rosproto.test.peers", lambda: now[0])
    for number in range(1000):
        said.warning("/a", "! %s: number %d", "/a", number)
    assert len(caplog.records) == MAX_PER_MESSAGE
    said.warning("/b", "! %s: number %d", "/b", 0)  # what happens to another topic is told all the same
    assert caplog.messages[-1] == "! /b: number 0"
    assert caplog.records[-1].filename == "test_logs.py"
    now[0] += WINDOW
    said.warning("/a", "! %s: number %d", "/a", 1000)
    assert caplog.messages[-1] == "! /a: number 1000; 990 more like it were left out"


@pytest.mark.promise("the rest is counted")
def test_a_flood_about_invented_things_is_bounded(caplog: pytest.LogCaptureFixture) -> None:
    """Peers invent names, so the sum of all is bounded as well, and what is remembered of them."""
    now = [0.0]
    said = PeerLog("rosproto.test.peers", lambda: now[0])
    for number in range(2000):
        said.info(f"/topic{number}", "! it is %s", number)
        said.warning(f"/topic{number}", "! it is %s", number)
    assert len(caplog.records) <= MAX_IN_ALL
    caplog.clear()
    for number in reversed(range(2000)):  # what is remembered of each is told with its next record
        now[0] += WINDOW
        said.warning(f"/topic{number}", "! it is %s", number)
    assert len(caplog.records) == 2000
    assert 0 < sum("left out" in record.getMessage() for record in caplog.records) <= 256


@pytest.mark.promise("the rest is counted")
def test_long_texts_are_cut(caplog: pytest.LogCaptureFixture) -> None:
    said = PeerLog("rosproto.test.peers")
    said.error("/a", "! %s: %s", "/a", ValueError("x" * 1_000_000), exc_info=ValueError("cause"))
    (record,) = caplog.records
    assert len(record.getMessage()) < MAX_CHARACTERS + 100
    assert record.getMessage().endswith("x... (996000 characters more)")
    assert record.exc_info
    assert cut("short") == "short"
