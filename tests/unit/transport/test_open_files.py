"""The limit of open files is raised where it is too low, and never lowered."""

from __future__ import annotations

import sys

import pytest

from rosproto.transport.os_errors import allow_open_files, max_connections

if sys.platform == "win32":
    pytest.skip("there is no such limit", allow_module_level=True)

import resource

NONE = resource.RLIM_INFINITY


@pytest.mark.promise("ask the system for 4096")
@pytest.mark.parametrize(
    ("before", "after"),
    [
        ((256, NONE), (1000, NONE)),  # a terminal of macOS
        ((256, 4096), (1000, 4096)),
        ((256, 600), (600, 600)),  # as many as it may
        ((1024, 4096), None),
        ((NONE, NONE), None),
    ],
)
def test_it_is_raised_as_far_as_needed_and_allowed(
    before: tuple[int, int], after: tuple[int, int] | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    set_to: list[tuple[int, int]] = []
    monkeypatch.setattr(resource, "getrlimit", lambda _: before)
    monkeypatch.setattr(resource, "setrlimit", lambda _, limits: set_to.append(limits))
    allow_open_files(1000)
    assert set_to == ([] if after is None else [after])


def test_a_system_that_refuses_is_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """macOS does for more than `kern.maxfilesperproc`."""

    def refuse(_: int, __: tuple[int, int]) -> None:
        raise ValueError("not allowed to raise maximum limit")

    monkeypatch.setattr(resource, "getrlimit", lambda _: (256, NONE))
    monkeypatch.setattr(resource, "setrlimit", refuse)
    allow_open_files(1000)


@pytest.mark.promise("are kept for the robot and for a stop")
@pytest.mark.parametrize(
    ("limit", "newest", "connections", "most"),
    [
        (256, 50, [], 142),  # 50 files of others, 64 in reserve
        (256, 190, range(50, 190), 142),
        (256, 60, [55, 56, *range(70, 200)], 256 - 64 - 58),  # a low number was free again
        (150, 50, [], 63),  # a quarter in reserve
        (64, 60, [], 8),  # some in any case
        (NONE, 5000, range(10, 5000), sys.maxsize),
    ],
)
def test_the_number_of_connections_follows_from_the_limit(
    limit: int, newest: int, connections: list[int], most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(resource, "getrlimit", lambda _: (limit, limit))
    assert max_connections(newest, connections) == most
