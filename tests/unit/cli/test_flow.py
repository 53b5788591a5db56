"""Values in one line, as they are typed, are read back as what they were."""

from __future__ import annotations

import pytest

from rosproto.cli.yaml_values import to_flow, value_of


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ({"data": False}, "{data: false}"),
        ({"b": 1, "a": ""}, "{b: 1, a: ''}"),
        ({"header": {"stamp": {"secs": 0, "nsecs": 0}}, "poses": [], "x": 0.5}, None),
        ({"names": ["a", "it's"], "none": []}, None),
        ({}, "{}"),
    ],
)
def test_what_is_written_is_read_back(value: object, text: str | None) -> None:
    written = to_flow(value)
    assert "\n" not in written
    assert value_of(written) == value
    assert text is None or written == text
