"""The stand-ins for ROS's modules as an installed package has them: all in one file."""

from __future__ import annotations

import ast
import functools
import inspect
import subprocess
import sys
from importlib.util import module_from_spec
from pathlib import Path

import pytest

from rosproto.msg.packed import make_pack
from rosproto.rospy.shortened import shortened
from rosproto.rospy.stock import MODULES, FileStock, PackedStock

PROGRAM = """
import sys
from pathlib import Path
from rosproto.rospy import finder, stock
packed = stock.PackedStock(Path(sys.argv[1]).read_text("utf-8"))
finder.stock = lambda: packed
finder.serve()
import rospy, rospy.impl.init, actionlib.action_client, rosbag, tf.transformations as tf, PyKDL
from sensor_msgs import point_cloud2
from rospy.msg import AnyMsg
assert [type(m.__loader__).__name__ for m in (rospy, rospy.impl, tf, PyKDL, point_cloud2)] == ["PackedLoader"] * 5
try:
    import rospy.nothing
except ImportError as error:
    print(error)
tf.euler_from_quaternion("no quaternion at all")
"""


short = functools.cache(shortened)


@pytest.fixture(scope="module")
def text_of_pack() -> str:
    return make_pack(MODULES, (".py",), short)


@pytest.fixture
def packed(text_of_pack: str) -> PackedStock:
    return PackedStock(text_of_pack)


def test_the_pack_serves_what_the_files_do(packed: PackedStock) -> None:
    """Every file, under the same path and as the same kind of module; and nothing else."""
    files, one = FileStock(), packed
    assert files.names() == one.names()
    for path in Path(MODULES).rglob("*.py"):
        inner = path.relative_to(MODULES)
        parts = inner.parent.parts if path.stem == "__init__" else inner.with_suffix("").parts
        ours, theirs = one.spec("name", *parts), files.spec("name", *parts)
        assert ours is not None, parts
        assert theirs is not None, parts
        assert (ours.origin, ours.submodule_search_locations) == (
            theirs.origin,
            theirs.submodule_search_locations,
        )
        assert ours.loader.get_source("name") == short(path.read_text("utf-8"))  # type: ignore[union-attr]
        assert ours.loader.is_package("name") is (path.stem == "__init__")  # type: ignore[union-attr]
    for absent in (("nothing",), ("rospy", "nothing"), ("angles", "inside")):
        assert one.spec("name", *absent) is None
        assert files.spec("name", *absent) is None


def test_source_lines_are_known(packed: PackedStock, monkeypatch: pytest.MonkeyPatch) -> None:
    """`inspect.getsource` and tracebacks ask the loader: the file is not there."""
    spec = packed.spec("angles_from_a_pack", "angles")
    assert spec is not None
    spec.origin = spec.loader.path = "/nowhere/angles.py"  # type: ignore[union-attr]
    module = module_from_spec(spec)
    monkeypatch.setitem(sys.modules, module.__name__, module)
    module.__loader__.exec_module(module)  # type: ignore[union-attr]
    assert inspect.getsource(module.normalize_angle).startswith("def normalize_angle(")


def test_a_program_runs_from_the_pack(text_of_pack: str, tmp_path: Path) -> None:
    """Modules, packages, modules inside packages, what lies in message packages; errors name their place."""
    pack = tmp_path / "modules.txt"
    pack.write_text(text_of_pack, "utf-8")
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(pack)], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 1
    assert done.stdout == "No module named 'rospy.nothing'\n"
    assert "modules/tf/transformations.py" in done.stderr.replace("\\", "/")


def without_docstrings(text: str) -> str:
    """A module's statements and their lines."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if hasattr(node, "col_offset"):
            node.col_offset = node.end_col_offset = 0
        documented = isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
        if documented and ast.get_docstring(node) is not None and len(node.body) > 1:
            del node.body[0]
    return ast.dump(tree, include_attributes=True)


def test_packed_texts_are_the_same_program_on_the_same_lines() -> None:
    """What is left out of a wheel are remarks, and nothing else."""
    for path in Path(MODULES).rglob("*.py"):
        text = path.read_text("utf-8")
        rest = short(text)
        assert without_docstrings(rest) == without_docstrings(text), path
        assert len(rest.splitlines()) == len(text.splitlines())


@pytest.mark.parametrize(
    ("text", "rest"),
    [
        ('"""The module\'s."""\nx = 1  # one\n# end\n', "\nx = 1\n\n"),
        ('def f():\n    """Two\n    lines."""\n    return "#"\n', 'def f():\n\n\n return "#"\n'),
        ('def f():\n    """Only this."""\n', 'def f():\n """Only this."""\n'),
        (
            'if x:\n    y = """a\n        b"""\n    z = f(\n        1,\n    )\n',
            'if x:\n y = """a\n        b"""\n z = f(\n  1,\n )\n',
        ),
        ('def f(): "All"; return 1\n', 'def f(): "All"; return 1\n'),
        (
            'def f():\n    "In front"; x = 1\n    return x\n',
            'def f():\n "In front"; x = 1\n return x\n',
        ),
    ],
)
def test_what_is_left_out_of_a_packed_text(text: str, rest: str) -> None:
    assert shortened(text) == rest
