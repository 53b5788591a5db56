"""A learned folder remembers that it is one, and a library what it adds to its base."""

from __future__ import annotations

import pickle
from pathlib import Path

from rosproto.msg import DefinitionLibrary, bundled, parse_message
from rosproto.msg.learned_folder import LearnedFolder
from rosproto.msg.user_folder import is_learned, learned_paths


def test_the_mark_is_in_the_object(tmp_path: Path) -> None:
    folder = LearnedFolder(tmp_path)
    assert folder == tmp_path
    assert is_learned(folder)
    assert not is_learned(tmp_path)
    assert not is_learned(str(folder))


def test_it_is_kept_by_a_pickle(tmp_path: Path) -> None:
    """Node options are handed to other processes."""
    copy = pickle.loads(pickle.dumps(LearnedFolder(tmp_path)))
    assert copy == tmp_path
    assert is_learned(copy)


def test_what_was_learned_bears_it(tmp_path: Path) -> None:
    (tmp_path / "robot" / "foo_msgs" / "msg").mkdir(parents=True)
    (tmp_path / "robot" / "foo_msgs" / "msg" / "Foo.msg").write_text("int32 a\n", "utf-8")
    assert all(is_learned(path) for path in learned_paths(tmp_path))
    assert learned_paths(tmp_path / "nowhere") == []


def test_a_library_knows_what_it_adds_itself() -> None:
    library = DefinitionLibrary(base=bundled())
    library.add(parse_message("int32 a", "foo_msgs/Foo"))
    assert library.defines("msg", "foo_msgs/Foo")
    assert not library.defines("msg", "std_msgs/String")
    assert library.has("msg", "std_msgs/String")
    assert not library.defines("msg", "no name")
