"""Doors: classes come out of definitions on first use, and everything Python asks of a module is answered."""

from __future__ import annotations

import importlib
import subprocess
import sys

import pytest

import rosproto.codec
from rosproto.msg import bundled


def test_a_message_is_made_once_and_is_the_codec_s_own() -> None:
    """Two imports and `message_class` give the same class."""
    from msgdefs.geometry_msgs.msg import Twist
    from msgdefs.geometry_msgs.msg import Twist as Again

    assert Twist is Again
    assert Twist is rosproto.codec.message_class("geometry_msgs/Twist")
    assert vars(sys.modules["msgdefs.geometry_msgs.msg"])["Twist"] is Twist
    assert Twist._md5sum == "9f195f881246fdfa2798d1d3eebca84a"


def test_messages_of_actions_are_there() -> None:
    """All seven."""
    from msgdefs.woosh_msgs.msg import MoveBaseAction, MoveBaseActionGoal, MoveBaseGoal

    assert type(MoveBaseAction().action_goal) is MoveBaseActionGoal
    assert type(MoveBaseActionGoal().goal) is MoveBaseGoal


def test_services_have_three_names() -> None:
    """The service, and its parts as genpy names them."""
    from msgdefs.std_srvs.srv import SetBool, SetBoolRequest, SetBoolResponse

    assert SetBool.Request is SetBoolRequest
    assert SetBool.Response is SetBoolResponse
    assert SetBool._type == "std_srvs/SetBool"


def test_both_spellings_of_the_vendor_are_there() -> None:
    """They are two type names on the wire."""
    from msgdefs.woosh_msgs.msg import WooshRosbagRecord, wooshRosbagRecord
    from msgdefs.woosh_msgs.srv import WooshInit, wooshInit

    assert wooshRosbagRecord._type == "woosh_msgs/wooshRosbagRecord"
    assert WooshRosbagRecord._md5sum == wooshRosbagRecord._md5sum
    assert WooshInit._md5sum == wooshInit._md5sum


@pytest.mark.parametrize("package", bundled().packages())
def test_every_name_of_dir_and_all_can_be_imported(package: str) -> None:
    """Each type of each package becomes a class."""
    for kind, names in (("msg", bundled().messages(package)), ("srv", bundled().services(package))):
        if not names:
            with pytest.raises(ImportError):
                importlib.import_module(f"msgdefs.{package}.{kind}")
            continue
        door = importlib.import_module(f"msgdefs.{package}.{kind}")
        assert {name.partition("/")[2] for name in names} <= set(door.__all__) <= set(dir(door))
        for name in door.__all__:
            assert getattr(door, name).__name__ == name


def test_star_imports_everything() -> None:
    """`__all__` is asked of the door."""
    names: dict[str, object] = {}
    exec("from msgdefs.std_msgs.msg import *", names)
    assert {"String", "Header", "UInt8MultiArray"} <= set(names)


def test_a_name_that_is_not_there_is_an_attribute_error_with_near_matches() -> None:
    """So hasattr() works, and `from ... import` is an ImportError."""
    from msgdefs.geometry_msgs import msg
    from msgdefs.std_srvs import srv

    with pytest.raises(AttributeError, match="geometry_msgs/Twist"):
        _ = msg.Twits
    with pytest.raises(AttributeError, match="std_srvs/SetBool"):
        _ = srv.SetBoll
    with pytest.raises(ImportError):
        exec("from msgdefs.geometry_msgs.msg import Twits")
    assert not hasattr(msg, "_private")
    assert not hasattr(msg, "__wrapped__")
    assert not hasattr(srv, "Request")


def test_importing_a_door_loads_nothing_else() -> None:
    """Neither the codec nor numpy, before a class is asked for."""
    program = (
        "import sys, msgdefs.sensor_msgs.msg as m; "
        "print([n for n in ('rosproto', 'rosproto.codec', 'numpy') if n in sys.modules]);"
        "m.LaserScan; print('numpy' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stdout.split("\n")[0] == "[]"
