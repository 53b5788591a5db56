"""Changed names: the old ones work, with a warning that names the new one and the line that uses the old one."""

from __future__ import annotations

import importlib

import pytest

from rosproto.aio import Pool
from rosproto.deprecation import former_attribute, former_names, former_parameters
from rosproto.gateway import Outbox
from rosproto.node import MasterClient, Node
from rosproto.recording import Recorder
from rosproto.tf import History
from woosh_pure.errors import MotionRefused


@pytest.mark.parametrize(
    ("module", "old", "new"),
    [
        ("rosproto.codec", "Flavour", "ValueStyle"),
        ("rosproto.watchdog", "Place", "WatchedNode"),
        ("rosproto.watchdog", "place_beside", "watched_node_of"),
        ("woosh_pure.geometry", "FARTHEST", "MAX_COORDINATE_METRES"),
        ("woosh_pure.lease", "MOST_SECONDS", "MAX_SECONDS"),
    ],
)
def test_an_old_name_of_a_module_is_the_new_one_with_a_warning(module: str, old: str, new: str) -> None:
    room = importlib.import_module(module)
    with pytest.warns(DeprecationWarning, match=f"^{module}.{old} is now {new}$") as told:
        assert getattr(room, old) is getattr(room, new)
    assert told[0].filename == __file__


def test_a_name_that_never_was_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'rosproto' has no attribute 'other'"):
        former_names("rosproto", {"old": "new"})("other")


def test_an_old_parameter_is_the_new_one_with_a_warning() -> None:
    @former_parameters(most="limit")
    def function(first: int, limit: int = 0) -> tuple[int, int]:
        return first, limit

    assert function(1, limit=2) == function(1, 2) == (1, 2)
    with pytest.warns(DeprecationWarning, match="^most= is now limit=$") as told:
        assert function(1, most=3) == (1, 3)
    assert told[0].filename == __file__
    with pytest.warns(DeprecationWarning, match="limit="), pytest.raises(TypeError, match="the same"):
        function(1, limit=2, most=3)


def test_an_old_attribute_is_the_new_one_with_a_warning() -> None:
    class Thing:
        limit = 1
        most = former_attribute("most", "limit")

    thing = Thing()
    with pytest.warns(DeprecationWarning, match="^Thing.most is now limit$") as told:
        assert thing.most == 1
    assert told[0].filename == __file__
    with pytest.warns(DeprecationWarning, match="^Thing.most is now limit$"):
        thing.most = 2
    assert thing.limit == 2


@pytest.mark.parametrize(
    ("kind", "old"),
    [
        (Node, "registering"),
        (Node, "revisions"),
        (Node, "look_at_master"),
        (MasterClient, "several"),
        (MotionRefused, "said"),
    ],
)
def test_the_attributes_of_the_last_release_are_deprecated(kind: type, old: str) -> None:
    assert getattr(kind, old).__doc__.startswith("Deprecated: ")


def test_the_parameters_of_the_last_release_are_taken() -> None:
    with pytest.warns(DeprecationWarning, match="max_samples="):
        History(0, most=3)
    with pytest.warns(DeprecationWarning, match="max_threads="):
        pool = Pool(most=3)
    with pytest.warns(DeprecationWarning, match="will be removed"):
        assert (pool.most, pool.idle_seconds) == (3, 10.0)
    with pytest.raises(TypeError, match="node"), pytest.warns(DeprecationWarning, match="min_free_bytes="):
        Recorder(least_free_bytes=1)
    with pytest.raises(TypeError, match="self"), pytest.warns(DeprecationWarning, match="max_bytes="):
        Outbox.take(most=1)
