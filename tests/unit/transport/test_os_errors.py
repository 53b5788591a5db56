"""The operating system's errors become readable sentences."""

from __future__ import annotations

from rosproto.transport.deadline import Deadline
from rosproto.transport.os_errors import translate


def test_a_time_out_is_told_in_round_seconds() -> None:
    """A budget that is partly used up has many digits; the text has three."""
    error = translate(TimeoutError(), "getPid", "10.0.0.7", Deadline(4.999998927999513))
    assert "no answer within 5 s; check the address" in str(error)
