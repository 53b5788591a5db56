"""Which language is spoken: --lang, then the environment, then Windows; never one that cannot be shown."""

from __future__ import annotations

import ctypes
import io
import subprocess
import sys
from types import SimpleNamespace

import pytest

from woosh_pure.language import language_of


@pytest.mark.parametrize(
    ("environment", "language"),
    [
        ({}, "en"),
        ({"LANG": "zh_CN.UTF-8"}, "zh"),
        ({"LANG": "zh_TW"}, "zh"),
        ({"LANG": "zh-Hans"}, "zh"),
        ({"LANG": "ZH"}, "zh"),
        ({"LANG": "C.UTF-8"}, "en"),
        ({"LANG": "zhx_XX"}, "en"),
        ({"LANG": "zh_CN.UTF-8", "LC_ALL": "en_US.UTF-8"}, "en"),
        ({"LANG": "en_US.UTF-8", "LC_ALL": "zh_CN.UTF-8"}, "zh"),
        ({"LANG": "en_US.UTF-8", "LC_MESSAGES": "zh_CN.UTF-8"}, "zh"),
        ({"LANG": "zh_CN.UTF-8", "LC_ALL": ""}, "zh"),
    ],
)
@pytest.mark.parametrize("platform", ["linux", "darwin", "win32"])
def test_the_environment_says_it(
    environment: dict[str, str], language: str, platform: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("woosh_pure.language._windows_is_chinese", lambda: False)
    assert language_of([], environment, platform=platform) == language


@pytest.mark.parametrize(
    ("words", "language"),
    [
        (["--lang", "zh", "status"], "zh"),
        (["status", "--lang=zh"], "zh"),
        (["status", "--lang", "en"], "en"),
        (["status", "--lang", "xx"], "en"),
        (["status", "--lang"], "en"),
        (["say", "--", "--lang", "zh"], "en"),
    ],
)
def test_the_option_goes_before_everything(words: list[str], language: str) -> None:
    """Also before what the terminal can show: who asks for it gets it."""
    assert language_of(words, {}, stream=io.TextIOWrapper(io.BytesIO(), "ascii")) == language
    if language == "en" and "--" not in words:
        assert language_of(words, {"LANG": "zh_CN.UTF-8"}) == "en"


@pytest.mark.parametrize(
    ("identifier", "language"), [(0x0804, "zh"), (0x0404, "zh"), (0x0409, "en"), (0x0411, "en")]
)
def test_windows_is_asked_for_the_language_of_its_screens(
    identifier: int, language: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    kernel = SimpleNamespace(GetUserDefaultUILanguage=lambda: identifier)
    monkeypatch.setattr(ctypes, "windll", SimpleNamespace(kernel32=kernel), raising=False)
    assert language_of([], {}, platform="win32") == language
    assert language_of([], {"LANG": "en_US"}, platform="win32") == "en"
    assert language_of([], {}, platform="linux") == "en"


def test_a_windows_that_does_not_know_is_no_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken() -> int:
        raise OSError("no such function")

    monkeypatch.setattr(ctypes, "windll", SimpleNamespace(), raising=False)
    assert language_of([], {}, platform="win32") == "en"
    kernel = SimpleNamespace(GetUserDefaultUILanguage=broken)
    monkeypatch.setattr(ctypes, "windll", SimpleNamespace(kernel32=kernel), raising=False)
    assert language_of([], {}, platform="win32") == "en"
    monkeypatch.setitem(sys.modules, "ctypes", None)
    assert language_of([], {}, platform="win32") == "en"


@pytest.mark.parametrize(
    ("encoding", "language"), [("utf-8", "zh"), ("gbk", "zh"), ("cp1252", "en"), ("ascii", "en")]
)
def test_what_cannot_be_shown_is_not_chosen(encoding: str, language: str) -> None:
    """Escapes in place of characters help nobody."""
    stream = io.TextIOWrapper(io.BytesIO(), encoding)
    assert language_of([], {"LANG": "zh_CN.UTF-8"}, stream=stream) == language


def test_english_does_not_load_the_table() -> None:
    """It would be paid for by every start."""
    code = (
        "import sys\nfrom woosh_pure.cli import main\n"
        "assert main(['connect', '--show']) == 1\nassert 'woosh_pure.language.table' not in sys.modules"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0, done.stderr
