"""Status codes in sentences: the vendor's table has their words in both languages."""

from __future__ import annotations

import re

__all__ = ["chinese_of_code"]


def chinese_of_code(text: str) -> str | None:
    """Of "emergency stop pressed (110201000013)"; None for everything else."""
    found = re.fullmatch(r"(?P<english>.+) \((?P<code>\d{12})\)", text)
    if found is None:
        return None
    from woosh_pure.faults.codes import decode_status_code

    code = decode_status_code(int(found["code"]))
    return f"{code.chinese}（{found['code']}）" if code.english == found["english"] else None
