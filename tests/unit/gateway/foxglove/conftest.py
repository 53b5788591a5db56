"""A graph with a Foxglove server's node in it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.support.foxglove_ground import Ground


@pytest.fixture
def ground() -> Iterator[Ground]:
    made = Ground()
    try:
        yield made
    finally:
        made.close()
