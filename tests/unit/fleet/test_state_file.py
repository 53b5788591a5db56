"""The file of a vehicle: replaced as a whole, and put aside when it makes no sense."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from woosh_pure.fleet.state_file import Store, StoreInUse


def test_what_was_saved_is_loaded(tmp_path: Path) -> None:
    """Also by another process; a folder that is not there is made."""
    store = Store(tmp_path / "deep", "Woosh", "A:17")
    assert store.load() is None
    store.save({"orderId": "ä"})
    store.save({"orderId": "b"})
    assert Store(tmp_path / "deep", "Woosh", "A:17").load() == {"orderId": "b"}
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
    assert store.load() == {"n": 1}


def test_a_broken_file_is_kept_aside(tmp_path: Path) -> None:
    """Nothing is lost that a person may want to read."""
    store = Store(tmp_path, "Woosh", "1")
    store.path.write_text("{")
    assert store.load() is None
    assert store.path.with_suffix(".broken").read_text() == "{"


def test_what_is_the_same_is_not_written_again(tmp_path: Path) -> None:
    """A heartbeat costs no disk."""
    store = Store(tmp_path, "Woosh", "1")
    store.save({"n": 1})
    store.path.unlink()
    store.save({"n": 1})
    assert not store.path.exists()


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
from woosh_pure.fleet.state_file import Store
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
