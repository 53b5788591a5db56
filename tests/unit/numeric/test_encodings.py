"""The table of image encodings."""

from __future__ import annotations

import pytest

from rosproto.numeric.images import ENCODINGS, PICTURES, picture_order, pixel_layout


@pytest.mark.parametrize("encoding", sorted(PICTURES))
def test_the_order_of_a_picture_names_each_value_of_a_pixel_once(encoding: str) -> None:
    assert sorted(PICTURES[encoding]) == list(range(pixel_layout(encoding).channels))


def test_only_what_is_in_another_order_is_put_in_order() -> None:
    assert [picture_order(encoding) for encoding in ("rgb8", "mono16", "bgr16", "8UC4", "32FC1")] == [
        None,
        None,
        [2, 1, 0],
        [2, 1, 0, 3],
        None,
    ]


def test_names_tell_colours_and_rules_do_not() -> None:
    assert {entry.colour for entry in ENCODINGS.values()} >= {"GRAY", "BGRA", "BAYER_RGGB", "YUV422"}
    assert pixel_layout("16SC3") == ("i2", 3, "")
    with pytest.raises(ValueError, match="known are mono8"):
        pixel_layout("16FC1")
