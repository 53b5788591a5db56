"""The file of a vehicle: a state and the changes since, and put aside when it makes no sense."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from tests.support.fleet import LIMITS, PureVehicle, action
from woosh_pure.fleet.order import changed, read_state
from woosh_pure.fleet.order.events import ModeChanged
from woosh_pure.fleet.persistent_order import PersistentOrder
from woosh_pure.state_file import MIN_CHANGES, Store, StoreInUse


class RecordedStore(Store):
    """A store that notes what was saved.

    Attributes:
        saved: The size of the file and the state after each time.
        whole: Number of times that the file was replaced.
        machine: Whose state it is.
    """

    machine: PersistentOrder

    def __init__(self, folder: Path) -> None:
        super().__init__(folder, "Woosh", "1")
        self.saved: list[tuple[int, dict[str, Any]]] = []
        self.whole = 0

    def save(self, data: Mapping[str, object]) -> None:
        super().save(data)
        self.saved, self.whole = [(self.path.stat().st_size, json.loads(json.dumps(data)))], self.whole + 1

    def add(self, change: Mapping[str, object]) -> bool:
        added = super().add(change)
        if added and change:
            before = self.saved[-1][1]
            data = changed(before, [json.loads(json.dumps(change))])
            self.saved.append((self.path.stat().st_size, data))
        return added


def driven(store: Store) -> PureVehicle:
    """A vehicle with this file that has passed nodes, extended its order, and finished actions."""
    vehicle = PureVehicle()
    vehicle.order_machine = PersistentOrder(LIMITS, store, "test")
    vehicle.apply(ModeChanged("AUTOMATIC"))
    vehicle.place(0.0)
    vehicle.rest()
    vehicle.order(
        nodes="abcd",
        released=3,
        node_actions={"b": [action("x"), action("y", times=2)], "d": [action("gone")]},
        edge_actions={"ab": [action("e", blocking="NONE")]},
    )
    vehicle.arrive()
    vehicle.finish("e")
    vehicle.finish("x")
    vehicle.instant(action("p", "startPause"))
    vehicle.order(update=1, nodes="cda", first=4, node_actions={"d": [action("gone"), action("ä")]})
    vehicle.instant(action("q", "stopPause"))
    vehicle.finish("y", ok=False, text="no time")
    vehicle.arrive()
    return vehicle


def test_what_was_saved_is_loaded(tmp_path: Path) -> None:
    """Also by another process; a folder that is not there is made."""
    store = Store(tmp_path / "deep", "Woosh", "A:17")
    assert store.load() == []
    store.save({"orderId": "ä"})
    store.save({"orderId": "b"})
    assert store.add({"lastNodeId": "c"})
    assert Store(tmp_path / "deep", "Woosh", "A:17").load() == [{"orderId": "b"}, {"lastNodeId": "c"}]
    assert [path.name for path in (tmp_path / "deep").iterdir()] == ["Woosh-A_17.json"]


def test_a_death_while_writing_leaves_what_was_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The file is written beside, and takes the place at once."""
    store = Store(tmp_path, "Woosh", "1")
    store.save({"n": 1})

    def dies(*given: object) -> None:
        raise OSError("power")

    monkeypatch.setattr("os.replace", dies)
    with pytest.raises(OSError, match="power"):
        store.save({"n": 2})
    monkeypatch.undo()
    assert store.load() == [{"n": 1}]


@pytest.mark.parametrize("text", ["{", "7", '{"n": 1}\n{"n"\n{"n": 3}\n', '{"n": 1}\n{"n": 2\n'])
def test_a_broken_file_is_kept_aside(tmp_path: Path, text: str) -> None:
    """Nothing is lost that a person may want to read; a state is not guessed from what is left of it."""
    store = Store(tmp_path, "Woosh", "1")
    store.path.write_text(text)
    assert store.load() == []
    assert store.path.with_suffix(".broken").read_text() == text


def test_what_is_the_same_is_not_written_again(tmp_path: Path) -> None:
    """A heartbeat costs no disk."""
    store = Store(tmp_path, "Woosh", "1")
    vehicle = driven(store)
    store.path.unlink()
    vehicle.write()
    assert not store.path.exists()


@pytest.mark.slow
def test_a_file_that_was_cut_at_any_byte_has_the_state_of_one_of_its_lines_or_is_put_aside(
    tmp_path: Path,
) -> None:
    """A loss of power while a change is added leaves the state before or after it, and no other."""
    store = RecordedStore(tmp_path / "whole")
    machine = driven(store).order_machine
    content = store.path.read_bytes()
    assert (store.whole, len(store.saved) > 8, store.saved[-1][0]) == (1, True, len(content))
    assert store.saved[-1][1] == json.loads(json.dumps(machine.state.to_json()))
    cut_file = Store(tmp_path / "cut", "Woosh", "1")
    cut_file.path.parent.mkdir()
    for cut in range(len(content) + 1):
        for tail in (b"", b"\0" * 3):  # some file systems grow a file before its content is on the disk
            cut_file.path.write_bytes(content[:cut] + tail)
            before = [data for size, data in store.saved if size <= cut + (tail == b"")]
            found = cut_file.load()
            if before:
                state = changed(found[0], found[1:])
                assert state == before[-1], cut
                assert read_state(state, LIMITS).order_id == before[-1]["orderId"]
            else:
                assert (found, cut_file.path.exists()) == ([], False), cut


def test_a_change_that_could_not_be_added_is_followed_by_the_whole_state(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Part of it may be in the file: nothing is added behind that."""
    store = Store(tmp_path, "Woosh", "1")
    store.save({"n": 1})

    def fails(number: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", fails)
    with pytest.raises(OSError, match="No space left"):
        store.add({"n": 2})
    monkeypatch.undo()
    assert not store.add({"n": 3})
    store.save({"n": 3})
    assert store.load() == [{"n": 3}]


def test_a_file_that_somebody_else_has_changed_is_replaced(tmp_path: Path) -> None:
    """Removed, or cut: a change alone would make no sense in it."""
    store = Store(tmp_path, "Woosh", "1")
    assert not store.add({"n": 1}), "nothing was saved yet"
    for harm in (store.path.unlink, lambda: store.path.write_bytes(b"")):
        store.save({"n": 1})
        harm()
        assert not store.add({"n": 2})


def test_many_changes_give_way_to_a_state(tmp_path: Path) -> None:
    """The file stays below twice the state, and a little."""
    store = Store(tmp_path, "Woosh", "1")
    store.save({"n": 0})
    added = 1
    while store.add({"n": "x" * 1000}):
        added += 1
    assert 0 < store.path.stat().st_size <= MIN_CHANGES + 100
    assert added > 60


def test_one_file_belongs_to_one_vehicle(tmp_path: Path) -> None:
    """Two that keep their order in one file would restore each other's; the sentence says what to do."""
    first, second = Store(tmp_path, "Woosh", "1"), Store(tmp_path, "Woosh", "1")
    first.lock()
    with pytest.raises(StoreInUse, match="running already; end that one"):
        second.lock()
    with pytest.raises(StoreInUse):
        first.lock()
    Store(tmp_path, "Woosh", "2").lock()
    first.unlock()
    second.lock()
    second.save({"n": 1})
    second.unlock()


HOLDER = """
import sys
from pathlib import Path
from woosh_pure.state_file import Store
store = Store(Path(sys.argv[1]), "Woosh", "1")
store.lock()
print("locked", flush=True)
sys.stdin.read()
"""


def test_the_lock_of_a_process_that_was_killed_is_gone(tmp_path: Path) -> None:
    """Another process holds it, and is killed."""
    command = [sys.executable, "-c", HOLDER, str(tmp_path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "locked\n"
        store = Store(tmp_path, "Woosh", "1")
        with pytest.raises(StoreInUse):
            store.lock()
        holder.kill()
        holder.wait(10.0)
        store.lock()
        store.unlock()


def test_a_folder_that_cannot_be_made_is_locked_with_the_first_save(tmp_path: Path) -> None:
    """A failing disk is reported by `save`, which locks the file later."""
    (tmp_path / "state").write_text("a file where the folder belongs")
    store = Store(tmp_path / "state", "Woosh", "1")
    with pytest.raises(OSError):
        store.lock()
    with pytest.raises(OSError):
        store.save({"n": 1})
    (tmp_path / "state").unlink()
    store.save({"n": 1})
    with pytest.raises(StoreInUse):
        Store(tmp_path / "state", "Woosh", "1").lock()
    store.unlock()
