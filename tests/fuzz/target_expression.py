"""Fuzz target of filter expressions: any text is refused or computed, with little memory and soon."""

from __future__ import annotations

import numpy as np

from rosproto.cli.expression import Expression, ExpressionError
from rosproto.codec import message_class


def _scan() -> object:
    scan = message_class("sensor_msgs/LaserScan")()
    scan.ranges = np.arange(500, dtype="f4")
    scan.header.frame_id = "laser"
    scan.header.seq = 7
    return scan


MESSAGE = _scan()
TOKENS_OF_LANGUAGE = (
    "m.ranges m.header.frame_id m.header.seq m.header.stamp 'a' 1 0 -1 9 10**6 ** * + - // % & | ^ >> ~ == in not and "
    "or [ ] ( ) , : for x in m.ranges if else round( str( sum( max( sorted( int( len( 'ab'.count( 999999999 "
    "(1,2) [0]* 1e308 inf None :: .split( 0x7fffffff 2**63"
).split(" ")


def expression(data: bytes) -> str:
    """A value, or the one documented error."""
    try:
        value = Expression(data.decode("utf-8", "replace"))(m=MESSAGE)
    except ExpressionError as error:
        return error.args[0].rpartition(": ")[2]
    return type(value).__name__


TARGETS = {"expression": expression}
TOKENS = {"expression": [token.encode() for token in TOKENS_OF_LANGUAGE]}
