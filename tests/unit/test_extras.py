"""Libraries of extras: imported when needed; the caller's error says what to install."""

from __future__ import annotations

import json

import pytest

from rosproto.errors import BagError
from rosproto.extras import optional_module


def test_an_installed_library_is_returned() -> None:
    assert optional_module("json", BagError("not raised")) is json


def test_a_missing_library_raises_the_given_error_with_its_cause() -> None:
    missing = BagError('this needs the package absent: pip install ".[absent]"')
    with pytest.raises(BagError, match="pip install") as caught:
        optional_module("absent_of_all_names", missing)
    assert caught.value is missing
    assert isinstance(missing.__cause__, ImportError)
