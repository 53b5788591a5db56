"""Importing the codec is cheap; numpy comes with the first array."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]

PROGRAM = """
import sys
from rosproto.codec import message_class, encode, decode
twist = message_class("geometry_msgs/Twist")
decode(twist, encode(twist()))
assert "numpy" not in sys.modules, "a message without arrays"
heavy = {"asyncio", "http", "xmlrpc", "ssl", "xml", "yaml", "inspect"} & set(sys.modules)
assert not heavy, heavy
message_class("sensor_msgs/LaserScan")()
assert "numpy" in sys.modules
"""


def test_numpy_is_imported_with_the_first_array() -> None:
    """Not with the package, nor with messages of plain fields."""
    done = subprocess.run(
        [sys.executable, "-S", "-c", "import site; site.main();" + PROGRAM],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        cwd=ROOT,
    )
    assert done.returncode == 0, done.stderr


def test_what_generates_code_is_imported_when_it_is_needed() -> None:
    """Writers of source are not part of the import time."""
    program = (
        "import sys, rosproto.codec as c; late = ('decode_generator', 'encode_generator');"
        "assert not [n for n in late if 'rosproto.codec.' + n in sys.modules];"
        "c.encode(c.message_class('std_msgs/String')(data='x'));"
        "assert 'rosproto.codec.encode_generator' in sys.modules"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False, cwd=ROOT
    )
    assert done.returncode == 0, done.stderr
