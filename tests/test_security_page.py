"""SECURITY.md names every limit with its default, so that nobody has to read the source for it."""

from __future__ import annotations

import re
from pathlib import Path

from rosproto.bag import BagLimits
from rosproto.msg import DefinitionLimits
from rosproto.protocol.limits import Limits

PAGE = (Path(__file__).resolve().parent.parent / "SECURITY.md").read_text("utf-8")


HOLDS = {
    "a definition of its own goes with its connection": [
        "unit/node/test_peer_costs.py::test_a_revision_goes_with_its_last_subscriber",
        "unit/node/test_peer_costs.py::test_one_that_leaves_during_the_handshake_leaves_nothing",
        "unit/node/test_peer_costs.py::test_many_subscribers_with_definitions_of_their_own_take_no_memory",
    ],
    "is bounded in number and length": [
        "unit/test_kept.py::test_the_entry_used_longest_ago_makes_room",
        "unit/node/test_peer_costs.py::test_what_peers_define_is_kept_by_its_length",
        "unit/node/test_peer_costs.py::test_what_was_looked_for_in_vain_is_kept_by_number",
        "unit/node/test_peer_costs.py::test_the_name_of_a_subscriber_is_cut",
        "unit/action/test_action_flood.py::test_servers_under_invented_names_are_forgotten",
        "unit/action/test_action_flood.py::test_goals_that_have_ended_are_told_of_within_bounds",
    ],
    "tried every few seconds": [
        "unit/node/test_peer_costs.py::test_a_publisher_that_agrees_and_leaves_is_not_told_of_every_time",
        "unit/node/incoming/test_link_state.py::test_sessions_that_end_at_once_are_no_success",
    ],
    "every few minutes": [
        "unit/node/test_peer_costs.py::test_a_publisher_of_another_type_is_asked_once",
        "unit/node/incoming/test_link_state.py::test_another_definition_is_not_asked_again_and_again",
    ],
    "Your own folders and the bundled definitions come before it": [
        "unit/cli/test_own_definitions.py::test_the_users_own_come_first_everywhere",
    ],
    "a type whose name no file can have is left out": [
        "scenarios/test_learn.py::test_a_type_no_file_can_be_named_after_is_left_out_and_told",
    ],
    "the rest is counted": [
        "unit/test_logs.py::test_a_flood_is_counted_instead_of_told",
        "unit/test_logs.py::test_a_flood_about_invented_things_is_bounded",
        "unit/test_logs.py::test_long_texts_are_cut",
    ],
}
"""Words of the page, and the tests that hold them."""


def rows(title: str) -> dict[str, str]:
    """Name -> default of one table."""
    table = PAGE.partition(f"| `{title}` field |")[2].partition("\n\n")[0]
    return dict(re.findall(r"^\| `(\w+)` \| ([\d.]+) \|", table, re.MULTILINE))


def test_limits() -> None:
    """The table is the class."""
    assert rows("Limits") == {name: str(value) for name, value in Limits._field_defaults.items()}


def test_definition_limits() -> None:
    """The table is the tuple."""
    expected = {name: str(value) for name, value in DefinitionLimits._field_defaults.items()}
    assert rows("DefinitionLimits") == expected


def test_bag_limits() -> None:
    """The table is the tuple."""
    assert rows("BagLimits") == {name: str(value) for name, value in BagLimits._field_defaults.items()}


HELD_BY = {
    "commands no terminal and forges no line": "scenarios/hostile/test_hostile_texts.py",
    "Every operation is bounded before it begins": "unit/cli/test_expression.py",
    "`BagLimits` field": "unit/bag/test_bag_limits.py",
    "is decoded within about 150 times": "unit/codec/test_amplification.py",
}
"""What the page says, and the tests that hold it."""


def test_what_is_said_is_held() -> None:
    """Each of these sentences stands on the page, and its tests are there."""
    for sentence, path in HELD_BY.items():
        assert sentence in PAGE, sentence
        assert "def test_" in (Path(__file__).resolve().parent / path).read_text("utf-8")


def test_every_limit_is_set_by_a_test() -> None:
    """A limit that nobody ever reached may not hold: some unit test or scenario makes each small and runs into it."""
    here = Path(__file__).resolve().parent
    tests = [
        path.read_text("utf-8") for room in ("unit", "scenarios") for path in (here / room).rglob("*.py")
    ]
    for kind in (Limits, DefinitionLimits, BagLimits):
        setting = [text for text in tests if kind.__name__ in text]
        names = kind._field_defaults
        untested = [name for name in names if not any(re.search(rf"\b{name}\b", text) for text in setting)]
        assert not untested, untested


def test_what_holds_a_sentence_is_there() -> None:
    """The words are still on the page, and so are the tests in their files."""
    here = Path(__file__).resolve().parent
    page = " ".join(PAGE.split())
    for words, tests in HOLDS.items():
        assert words in page, words
        for path, _, name in (test.partition("::") for test in tests):
            assert f"def {name}(" in (here / path).read_text("utf-8"), f"{path}::{name}"
