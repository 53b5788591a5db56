"""Two definitions of a type side by side, field by field, for error messages and reports."""

from __future__ import annotations

from typing import NamedTuple

from rosproto.msg.spec import Field, MessageSpec


class Difference(NamedTuple):
    """One field that two definitions do not share.

    Attributes:
        name: The field.
        ours: Its type on our side; "" when we do not have it.
        theirs: Its type on the other side; "" when they do not have it.
    """

    name: str
    ours: str
    theirs: str


def differences(ours: MessageSpec, theirs: MessageSpec) -> list[Difference]:
    """What differs between two definitions; fields that only moved are not listed (see `side_by_side`)."""
    left = {field.name: str(field.type) for field in ours.fields}
    right = {field.name: str(field.type) for field in theirs.fields}
    return [
        Difference(name, left.get(name, ""), right.get(name, ""))
        for name in dict.fromkeys([*left, *right])
        if left.get(name) != right.get(name)
    ]


def side_by_side(
    ours: MessageSpec, theirs: MessageSpec, titles: tuple[str, str] = ("here", "other side")
) -> str:
    """Both definitions as two columns in their own order, with a mark at each line that differs."""
    rows = [("", *titles)]
    left, right = list(ours.fields), list(theirs.fields)
    for i in range(max(len(left), len(right))):
        mine = left[i] if i < len(left) else None
        other = right[i] if i < len(right) else None
        rows.append(("  " if mine == other else "! ", _words(mine), _words(other)))
    width = max(len(row[1]) for row in rows)
    return "\n".join(f"{mark:2}{mine:{width}} | {other}".rstrip() for mark, mine, other in rows)


def _words(field: Field | None) -> str:
    return f"{field.type} {field.name}" if field is not None else "-"
