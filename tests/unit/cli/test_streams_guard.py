"""Standard output and error of a command: a print of anything is safe, our own controls say that they are ours."""

from __future__ import annotations

import errno
import io
import logging
import socket
import sys

import pytest

from rosproto.cli.console import guarded, json_text, own, unguarded
from rosproto.cli.exit_codes import explain, say
from rosproto.errors import MasterError, RosError, ServiceError
from rosproto.logs import get_logger
from tests.support.hostile_peer import RAW, wrongs_of


def test_prints_are_escaped_but_for_lines(capsys: pytest.CaptureFixture[str]) -> None:
    """Also what is printed by code that knows nothing of it; outside the block nothing is changed."""
    before = sys.stdout
    with guarded():
        print(RAW)
        print(RAW, file=sys.stderr)
        sys.stdout.writelines(["a\x1b", "b\n"])
        own(sys.stdout).write("\r\x1b[K")
        with guarded(), unguarded():
            print("\x1b[1mbold\x1b[0m")
    assert sys.stdout is before
    out, err = capsys.readouterr()
    assert out.endswith("a\\x1bb\n\r\x1b[K\x1b[1mbold\x1b[0m\n")
    assert [w for w in wrongs_of(out.partition("a\\x1bb")[0] + err) if not w.startswith("FORGED")] == []


def test_errors_are_fit_to_be_shown() -> None:
    """Their text is; their facts are what came."""
    for error in (MasterError("lookupNode", 0, RAW), ServiceError("/s", RAW)):
        assert wrongs_of(str(error)) == []
        assert "\n" not in str(error)
        assert error.text == RAW
    assert str(RosError("two\nlines\x1b")) == "two\nlines\\x1b"


def test_records_are_one_line(caplog: pytest.LogCaptureFixture) -> None:
    """Through every logger of ours; what the program's own loggers say is its own."""
    get_logger("rosproto.hostile").warning("from %s: %s", RAW, "x")
    get_logger("rosproto.hostile").error("plain %s", "text")
    logging.getLogger("theirs").warning("two\nlines")
    first, second, third = caplog.records
    assert wrongs_of(first.getMessage()) == []
    assert "\n" not in first.getMessage()
    assert (second.msg, second.args) == ("plain %s", ("text",))
    assert third.getMessage() == "two\nlines"


def test_json_is_safe_and_correct() -> None:
    """ASCII or not."""
    import json

    for ascii_only in (False, True):
        text = json_text({"a": RAW, "ü": "\u202e到"}, ascii_only=ascii_only)
        assert json.loads(text) == {"a": RAW, "ü": "\u202e到"}
        assert wrongs_of(text) == []


def test_a_failure_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    """What ends a command, such as "refused by the chassis: ..." with the chassis's own words."""
    for error in (ServiceError("/s", RAW), ValueError(RAW), KeyError(RAW), OSError(RAW), RuntimeError(RAW)):
        say(explain(error)[0])
    text = capsys.readouterr().err
    assert text.count("\n") == 5
    assert wrongs_of(text) == []


class _Full(io.StringIO):
    """A stream on a full disk."""

    def write(self, text: str) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    def flush(self) -> None:
        self.write("")


def test_an_error_is_about_what_failed() -> None:
    """Only an error of stdout or stderr is told as one of the output; another one that has no name is not."""
    text, code = explain(socket.gaierror(socket.EAI_NONAME, "Name or service not known"))
    assert (text, code) == ("Name or service not known", 1)
    text, code = explain(OSError(errno.EIO, "Input/output error", "run.bag"))
    assert (text, code) == ("run.bag: Input/output error", 1)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "stdout", _Full())
        with guarded():
            for act in (lambda: print("x"), lambda: sys.stdout.flush()):
                with pytest.raises(OSError, match="No space left") as failed:
                    act()
                assert explain(failed.value) == ("cannot write the output: No space left on device", 1)
