"""The file of a vehicle: replaced as a whole, and put aside when it makes no sense."""

from __future__ import annotations

from pathlib import Path

import pytest

from woosh_pure.fleet.store import Store


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
