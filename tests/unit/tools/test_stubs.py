"""The checked-in stubs say what the definitions say; mypy accepts what works and refuses what does not."""

from __future__ import annotations

import ast
import runpy
import subprocess
import sys
import types
from pathlib import Path

import pytest

from rosproto.msg import DefinitionLibrary, bundled, parse_message
from rosproto.time import Duration, Time
from tools import stubs
from tools.stubs import main, message_stub, stub_files

ROOT = Path(__file__).resolve().parents[3]


def test_the_stubs_are_current() -> None:
    """Run `python -m tools.stubs` after a change of definitions."""
    stale = [
        path
        for path, text in stub_files(bundled()).items()
        if not (ROOT / "msgdefs" / path).is_file() or (ROOT / "msgdefs" / path).read_text("utf-8") != text
    ]
    assert not stale
    assert main(["--check"]) == 0


def test_there_is_no_stub_without_definitions() -> None:
    """A package that is gone leaves none behind."""
    found = {
        path.relative_to(ROOT / "msgdefs").as_posix() for path in (ROOT / "msgdefs").rglob("__init__.pyi")
    }
    assert found == set(stub_files(bundled()))


def test_every_door_has_a_stub_and_every_stub_a_door() -> None:
    """The stub is what an IDE sees of the door beside it."""
    for path in stub_files(bundled()):
        assert (ROOT / "msgdefs" / path).with_suffix(".py").is_file()
    for path in (ROOT / "msgdefs").glob("*/*/__init__.py"):
        assert path.with_suffix(".pyi").is_file()


def test_wrong_arguments_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    """With the usage."""
    assert main(["--nonsense"]) == 2
    assert "usage" in capsys.readouterr().err


def test_difficult_names_and_texts_make_valid_python() -> None:
    """Keywords, builtins, quotes, back-slashes, and fields named like types."""
    library = DefinitionLibrary()
    library.add(parse_message('int8 x # """ \\ \\N{x} "', "p/Other"))
    library.add(
        parse_message(
            'string S=""" \\\nfloat32 INF=inf\nbool class=1\nint8 list\nfloat32 float\nstring self\nint8 in\n'
            "Other Other\nOther[] o\nstring[] texts\ntime t\nfloat64[3] v\nint8 after",
            "p/Odd",
        )
    )
    text = message_stub("p", library)
    tree = ast.parse(text)
    assert [node.name for node in tree.body if isinstance(node, ast.ClassDef)] == ["Odd", "Other"]
    assert "# in: int" in text
    assert "_builtins.list[_builtins.str]" not in text  # str is not shadowed
    assert "texts: _builtins.list[str]" in text
    assert "float: _builtins.float" in text
    assert "Other: _Other" in text
    assert "_Other = Other" in text


PROGRAM = """
import numpy as np
from numpy.typing import NDArray

from msgdefs.geometry_msgs.msg import Point32, Polygon, Twist, Vector3
from msgdefs.nav_msgs.msg import Odometry
from msgdefs.sensor_msgs.msg import Image, LaserScan
from msgdefs.std_srvs.srv import SetBool, SetBoolRequest
from msgdefs.woosh_msgs.msg import ArTrackResult, LED, MoveBaseAction, MoveBaseGoal, RobotStatus
from rosproto import Node
from rosproto.numeric import pose_to_matrix
from rosproto.time import Duration, Time


def read(scan: LaserScan, odom: Odometry, image: Image) -> float:
    ranges: NDArray[np.float32] = scan.ranges
    pixels: NDArray[np.uint8] = image.data
    stamp: Time = scan.header.stamp
    return float(ranges.min()) + odom.pose.pose.position.x + float(odom.pose.covariance[0]) + stamp.to_sec() + int(pixels[0])


def write() -> Twist:
    scan = LaserScan(angle_min=-1.0, ranges=[1.0, 2])
    scan.ranges = [1, 2.5]
    scan.ranges = np.zeros(3)
    scan.ranges = (np.float32(1.0),)
    Image(data=b"abc").data = bytearray(3)
    Polygon(points=[Point32(0.1, 0.2, 0.0)]).points.append(Point32())
    LED(color=0xFF00FF).submodule = 3
    goal = MoveBaseGoal()
    goal.target_pose.header.frame_id = "map"
    MoveBaseAction().action_goal.goal = goal
    ArTrackResult().ArTagPose[0].tag_pose.position.x = 1.0
    twist = Twist(linear=Vector3(x=0.1))
    twist.angular.z = 1
    return twist


def call() -> tuple[SetBoolRequest, str]:
    request = SetBool.Request(data=True)
    same: SetBoolRequest = request
    state: int = RobotStatus().task_state
    return same, SetBool.Response(success=bool(state)).message


def span(begin: Time, end: Time) -> tuple[Duration, Time, float]:
    half: Duration = (end - begin) / 2
    return half, begin + half, half / Duration(1)


def pass_on(node: Node, scan: LaserScan, fields: dict[str, bool]) -> NDArray[np.float32]:
    node.service_client("/lift", SetBool).call(**fields)
    node.publisher("/state", "std_msgs/Bool").publish(**fields)
    node.publisher("/scan", LaserScan).publish(scan)
    odometry: Odometry = node.wait_for_message("/odom", Odometry)
    node.subscriber("/odom", Odometry, callback=lambda message: print(message.pose))
    matrix = pose_to_matrix(odometry.pose.pose)
    pixels: NDArray[np.float32] = matrix.astype(np.float32)
    return pixels
"""
WRONG = {
    'LaserScan().ranges = "text"': "Incompatible types in assignment",
    "LaserScan().range": "has no attribute",
    'Twist().linear.x = "1"': "Incompatible types in assignment",
    "Twist(linaer=Vector3())": "Unexpected keyword argument",
    "SetBool.Request(data=1.5)": "incompatible type",
    "Polygon(points=[Twist()])": "List item 0 has incompatible type",
    "Time() + Time()": "Unsupported operand types",
    "pose_to_matrix(Twist())": "incompatible type",
}


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_mypy_strict_accepts_what_works_and_refuses_what_does_not(tmp_path: Path) -> None:
    """On a program that uses messages, arrays, actions and services."""
    pytest.importorskip("mypy", reason="mypy is not installed")
    program = tmp_path / "program.py"
    first = PROGRAM.count("\n") + 1
    program.write_text(PROGRAM + "\n".join(WRONG) + "\n")
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--no-error-summary", "--hide-error-context",
         "--cache-dir", str(ROOT / ".mypy_cache"), str(program)],
        capture_output=True, text=True, timeout=280, cwd=ROOT, env=None,
    )  # fmt: skip
    found = {int(line.split(":")[1]): line for line in done.stdout.splitlines() if "error:" in line}
    assert list(found) == list(range(first, first + len(WRONG))), done.stdout + done.stderr
    for line, expected in enumerate(WRONG.values(), first):
        assert expected in found[line]


def test_that_program_runs() -> None:
    """What the type checker accepts is also so."""
    from rosproto.codec import decode, encode

    names: dict[str, object] = {}
    exec(
        PROGRAM.replace(
            "ArTrackResult().ArTagPose[0]", "ArTrackResult(ArTagPose=[ArTagPose()]).ArTagPose[0]"
        ).replace("import ArTrackResult", "import ArTagPose, ArTrackResult"),
        names,
    )
    twist = names["write"]()  # type: ignore[operator]
    assert decode(type(twist), encode(twist)).angular.z == 1.0
    assert names["call"]()[1] == ""  # type: ignore[operator]
    assert names["span"](Time(1), Time(5)) == (Duration(2), Time(3), 2.0)  # type: ignore[operator]


def test_stubs_are_written_where_they_are_not_current(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """--check names them and fails; without it they are written, once."""
    definition = tmp_path / "defs" / "m" / "msg" / "Foo.msg"
    definition.parent.mkdir(parents=True)
    definition.write_text("int8 x")
    library = DefinitionLibrary([tmp_path / "defs"])
    module = types.ModuleType("msgdefs")
    module.__path__ = [str(tmp_path / "out")]
    (tmp_path / "out" / "m" / "msg").mkdir(parents=True)
    monkeypatch.setattr(stubs, "bundled", lambda: library)
    monkeypatch.setattr(stubs, "import_module", lambda name: module)
    file = tmp_path / "out" / "m" / "msg" / "__init__.pyi"
    assert stubs.main(["--check"]) == 1
    assert capsys.readouterr().out == f"not current: {file}\n1 stubs not current\n"
    assert not file.exists()
    assert stubs.main([]) == 0
    assert capsys.readouterr().out == "1 stubs written\n"
    assert "class Foo" in file.read_text()
    assert stubs.main([]) == stubs.main(["--check"]) == 0
    assert stubs.main(["--force"]) == 2
    assert "usage" in capsys.readouterr().err


def test_the_stubs_as_a_program(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """`python -m tools.stubs --check`."""
    monkeypatch.setattr(sys, "argv", ["stubs", "--check"])
    with pytest.raises(SystemExit) as caught:
        runpy.run_path(stubs.__file__, run_name="__main__")
    assert caught.value.code == 0
    assert capsys.readouterr().out == "0 stubs not current\n"
