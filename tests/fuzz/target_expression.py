"""Fuzz target of filter expressions: any text is refused or compiled. Computing it has no limits."""

from __future__ import annotations

from rosproto.cli.expression import Expression, ExpressionError

TOKENS_OF_LANGUAGE = (
    "m.ranges m.header.frame_id m.header.seq m.header.stamp 'a' 1 0 -1 9 10**6 ** * + - // % & | ^ >> ~ == in not and "
    "or [ ] ( ) , : for x in m.ranges if else round( str( sum( max( sorted( int( len( 'ab'.count( 999999999 "
    "(1,2) [0]* 1e308 inf None :: .split( 0x7fffffff 2**63"
).split(" ")


def expression(data: bytes) -> str:
    """An expression, or the one documented error."""
    try:
        Expression(data.decode("utf-8", "replace"))
    except ExpressionError as error:
        return error.args[0].rpartition(": ")[2]
    return "compiled"


TARGETS = {"expression": expression}
TOKENS = {"expression": [token.encode() for token in TOKENS_OF_LANGUAGE]}
