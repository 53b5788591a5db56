"""Values become what JSON can express."""

from __future__ import annotations

import math
from enum import IntEnum

from rosproto.codec import message_class
from rosproto.codec.dicts import to_dict
from rosproto.json_values import plain
from rosproto.msg import library_from_full_text
from rosproto.time import Time
from woosh_pure.reasons import ReasonKey


def test_values_of_parameters_become_plain() -> None:
    """Namespaces are dicts, bytes lists of numbers, and what JSON has no word for is None, or is kept."""
    value = {"a": {"data": b"\x01\x02", "stamp": Time(1, 2)}, "b": [1.5, math.inf]}
    assert plain(value) == {
        "a": {"data": [1, 2], "stamp": {"secs": 1, "nsecs": 2}},
        "b": [1.5, None],
    }
    assert plain(value, finite=False)["b"] == [1.5, math.inf]


def test_fields_of_a_message_may_be_called_as_methods_of_an_array() -> None:
    """Definitions come from the network: a field `tolist` is a field, and is not called."""
    library = library_from_full_text("a/B", "int32 tolist\nint32 secs\nint32 nsecs")
    message = message_class("a/B", library)(tolist=1)
    assert plain(message) == to_dict(message) == {"tolist": 1, "secs": 0, "nsecs": 0}


def test_an_enum_in_a_message_is_its_number_and_elsewhere_its_name() -> None:
    """A message has numbers only; what we say about a robot has names."""
    mode = IntEnum("Mode", {"AUTO": 3}).AUTO  # type: ignore[attr-defined]
    assert to_dict(message_class("std_msgs/Int8")(data=mode)) == {"data": 3}
    assert plain({"mode": mode}) == {"mode": "AUTO"}


def test_an_enum_of_texts_is_its_text() -> None:
    """Programs compare the key of a reason with the documented word."""
    assert plain(ReasonKey.NO_CHASSIS) == plain(ReasonKey.NO_CHASSIS, names=False) == "no_chassis"
