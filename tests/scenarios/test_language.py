"""The commands an owner types, in Chinese: run for real, and nothing English is left in what they say.

What a sentence must be is in tests/unit/language; here the seams are looked at: output, errors, parsers, columns.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from rosproto.text import width
from tests.support.extras import needs
from tests.support.woosh_command import woosh_process
from tools.templates import english_left
from woosh_pure import SimulatedChassis
from woosh_pure.cli import main

pytestmark = pytest.mark.usefixtures("private_config")
Woosh = Callable[..., tuple[int, str, str]]
ROOT = Path(__file__).resolve().parents[2]


def chinese(text: str) -> None:
    """It is Chinese, and no English sentence is in it; names, numbers, commands and paths are neither."""
    assert any("一" <= character <= "鿿" for character in text), text
    assert [line for line in text.splitlines() if english_left(line)] == []


@pytest.mark.parametrize(
    ("line", "code", "words"),
    [
        ("status --wait 1", 0, "可以移动"),
        ("faults --listen 0.2", 5, "未知：没有收到状态码"),
        ("faults --find localization", 0, "定位"),
        ("doctor --listen 0.5", 0, "没有发现问题"),
        ("move 0.2", 0, "已到达"),
        ("rotate -20", 0, "已到达"),
        ("goto A1", 0, "正在前往标记点“A1”"),
        ("goto --pose 1 0 0", 0, "已到达"),
        ("stop", 0, "机器人已停稳"),
        ("stop --end-drivers", 0, "机器人已停稳"),
        ("goto Z9", 3, "被底盘拒绝"),
        ("goto", 2, "请给出一个标记点"),
        ("goto a b", 2, "请加引号"),
        ("goto 1 2", 2, "位姿要这样写"),
        ("move", 2, "缺少参数"),
        ("move x", 2, "不是普通的十进制数；应类似 0.5 或 -12"),
        ("move " + 400 * "9", 2, "最多为 1000000000"),
        ("move 50", 2, "更长的路程"),
        ("move 1 --speed 0", 2, "必须大于 0"),
        ("rotate 9999", 2, "十圈"),
        ("drive", 2, "需要终端"),
        ("faults --code -1", 2, "状态码是"),
        ("faults 7", 0, "作为 task_state 是已完成"),
        ("plan A9", 2, "存有位姿的标记点"),
        ("charge", 2, "请给出充电桩的标记点"),
        ("forward", 2, "未知的命令"),
        ("状态", 2, "未知的命令 '状态'；您是不是想输入 `woosh status`？"),
        ("去 A1", 2, "您是不是想输入 `woosh goto MARK`？"),
        ("停止", 2, "您是不是想输入 `woosh stop`？"),
        ("stop --timeout 0 --nonsense", 2, "用法"),
        ("--sim goto A1", 2, "互相矛盾"),
        ("connect", 0, "现在是默认底盘"),
        ("battery", 0, "电池         87 %，未充电"),
        ("led none --strip both", 0, "底盘和货架灯带：none"),
        ("task pause --id 3", 3, "暂停任务 3：被拒绝：没有正在执行的任务可以暂停"),
        ("charge B1", 1, "目标处没有充电桩"),
        ("learn --dry-run", 0, "与自带的相同："),
        ("stop --nonsense", 2, "woosh stop [选项]"),
        ("scan", 0, "360 条射线"),
        ("cloud", 0, " 个点，坐标系"),
        ("camera --no-file", 0, "坐标系"),
        ("camera --depth --no-file", 0, "米"),
        ("plan 1 0 0 --start 0 0 0", 0, "2 个点，1.00 米"),
        ("costmap clear", 0, "已清除"),
        ("mode free", 2, "不是有效的"),
        ("watch --lines --for 1.5", 0, "没有收到状态"),
        ("imu", 0, "加速度"),
        ("faults 100201010101", 0, "由其名称或编号推出"),
        ("led red --module 9", 2, "0 表示全部，或 1 到 8"),
        ("web --no-browser --token short", 2, "令牌只有 5 个字符"),
        ("web --no-browser --port 0 --origin foo", 2, "不是有效的来源"),
        ("record --for 2", 2, "无法识别：--for；您是不是想输入 --force 或 --format？"),
        ("connect --show", 2, "请给出底盘的地址"),
        ("foxglove --port 0 --for 0.2", 0, "（只读；用 --allow-write PATTERN 开放写入）"),
        ("foxglove --port 0 --for 0.2 --allow-driving", 0, "允许写入时，Foxglove 的网页不能连接"),
    ],
)  # fmt: skip
def test_what_is_said_is_chinese(
    woosh: Woosh, capsys: pytest.CaptureFixture[str], line: str, code: int, words: str
) -> None:
    if (command := line.split()[0]) in ("web", "foxglove"):
        needs(command)
    try:
        found, out, err = woosh("--lang", "zh", *line.split())
    except SystemExit as error:  # the parser's
        found, (out, err) = int(str(error.code)), capsys.readouterr()
    assert found == code, out + err
    assert words in out + err
    chinese(out + err)


def test_who_cannot_be_reached_and_what_is_not_ready(
    sim: SimulatedChassis, woosh: Woosh, capsys: pytest.CaptureFixture[str]
) -> None:
    """An emergency stop and its status code, a place where nothing listens, a name that does not resolve."""
    sim.press_emergency_stop()
    woosh("--lang", "zh", "ready")
    sim.report(110201000013)
    for words in (["ready", "--listen", "0.5"], ["goto", "A1"], ["status"]):
        _, out, err = woosh("--lang", "zh", *words)
        chinese(out + err)
    for words in (["status"], ["connect", "127.0.0.1:1"], ["doctor"], ["stop"]):
        assert main(
            ["--chassis", "127.0.0.1:1", "--lang", "zh", *words]
            if words[0] != "connect"
            else ["--lang", "zh", *words]
        )
        chinese("".join(capsys.readouterr()))
    assert main(["--chassis", "robot.invalid", "--lang", "zh", "status"]) == 4
    assert "无法解析" in capsys.readouterr().err


def test_a_recording_in_chinese(woosh: Woosh, tmp_path: Path) -> None:
    """Its progress, its end, and what was not heard."""
    _, out, err = woosh("--lang", "zh", "record", "-O", str(tmp_path / "a.bag"), "--duration", "1.5")
    chinese(out + err)
    assert f"正在录制到 {tmp_path}" in err
    assert "条消息" in err


def test_a_line_of_the_log_has_its_sentences_in_chinese(sim: SimulatedChassis) -> None:
    """What `woosh vda5050` says of a broker that is not there, or that a robot moves already, is such a line."""
    needs("fleet")
    words = ("vda5050", "--broker", "mqtt://127.0.0.1:1", "--serial", "7", "--for", "1.5")
    out, err = woosh_process("--lang", "zh", "--master", sim.master_uri, *words).communicate(timeout=60)
    chinese(out + err)
    assert "! uagv/v2/Woosh/7: 无法连接代理 mqtt://127.0.0.1:1：" in err
    assert "；会不断重试" in err


def test_the_selftest_in_chinese(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["selftest", "--no-ros", "--lang", "zh"]) == 0
    out = capsys.readouterr().out
    chinese(out)
    assert "自检全部通过" in out
    assert (
        len({width(line[: line.index(" s  ")]) for line in out.splitlines()[:-1]}) == 1
    )  # columns are straight


def test_documents_for_programs_are_the_same(woosh: Woosh) -> None:
    """A script does not depend on who runs it."""
    documents = []
    for language in ("en", "zh"):
        code, out, _ = woosh("--lang", language, "goto", "--json")
        documents.append((code, json.loads(out)))
        code, out, _ = woosh("--lang", language, "doctor", "--listen", "0.2", "--json")
        documents.append((code, json.loads(out)["findings"][0]))
    assert documents[:2] == documents[2:]
    assert "give a mark" in documents[0][1]["error"]


@pytest.mark.parametrize(("name", "value", "words"), [("LANG", "zh_CN.UTF-8", "没有"), ("LC_ALL", "zh_CN", "没有"), ("LANG", "en_US.UTF-8", "no chassis")])  # fmt: skip
def test_the_environment_is_asked(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], name: str, value: str, words: str
) -> None:
    for other in ("LC_ALL", "LC_MESSAGES", "LANG"):
        monkeypatch.delenv(other, raising=False)
    monkeypatch.setenv(name, value)
    assert main(["connect", "--show"]) == 1
    assert words in capsys.readouterr().out


def test_a_pipe_that_cannot_show_it_stays_readable() -> None:
    """Escapes would help nobody; who asks for Chinese gets it all the same."""
    command = [sys.executable, "-m", "woosh_pure", "connect", "--show"]
    environment = {
        "PYTHONPATH": str(ROOT),
        "PYTHONIOENCODING": "ascii",
        "LANG": "zh_CN.UTF-8",
        "HOME": str(ROOT),
    }
    for more, words in (([], "no chassis is saved"), (["--lang", "zh"], "\\u6ca1")):
        done = subprocess.run(
            [*command, *more], env={**environment, "WOOSH_CONFIG_DIR": "/nonexistent"}, capture_output=True, text=True,
            timeout=60, check=False,
        )  # fmt: skip
        assert done.returncode == 1, done.stderr
        assert words in done.stdout
