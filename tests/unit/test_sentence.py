"""A sentence equals its English text and keeps its template and values."""

from __future__ import annotations

import copy
import json
import pickle
import threading

import pytest

from rosproto.errors import ConnectionLost, RosError, RosTimeout
from rosproto.sentence import Sentence, advice, both, led, say, sentence_of

TEMPLATE = "{topic}: nothing was received within {seconds:g} s"


def made() -> Sentence:
    return say(TEMPLATE, topic="/odom", seconds=2.0)


def kept(text: str) -> Sentence:
    assert isinstance(text, Sentence)
    return text


def test_it_is_its_english_text() -> None:
    sentence = made()
    assert sentence == "/odom: nothing was received within 2 s"
    assert hash(sentence) == hash("/odom: nothing was received within 2 s")
    assert json.dumps([sentence]) == '["/odom: nothing was received within 2 s"]'
    assert (sentence.template, sentence.values) == (TEMPLATE, {"topic": "/odom", "seconds": 2.0})


def test_a_text_alone_is_its_own_template() -> None:
    """Its braces, too."""
    assert say("{not a place}") == "{not a place}"


@pytest.mark.parametrize("error", [RosTimeout, ConnectionLost, RosError, ValueError, KeyError])
def test_an_error_keeps_it(error: type[Exception]) -> None:
    assert kept(sentence_of(error(made()))).values["topic"] == "/odom"


def test_copies_and_pickles_keep_it() -> None:
    for error in (RosTimeout(made(), what="/odom"), ConnectionLost(both(made(), made()), peer="x")):
        for again in (copy.copy(error), copy.deepcopy(error), pickle.loads(pickle.dumps(error))):
            assert str(again) == str(error)
            assert kept(str(again)).template == kept(str(error)).template


def test_what_keeps_it() -> None:
    sentence = made()
    for same in (str(sentence), f"{sentence}", copy.deepcopy(sentence)):
        assert kept(same).template == TEMPLATE


def test_what_does_not_is_plain_english() -> None:
    sentence = made()
    for plain in (
        f"x {sentence}",
        "; ".join([sentence, sentence]),
        sentence[:5],
        sentence.strip(),
    ):
        assert type(plain) is str


def test_sentences_in_a_row_and_behind_what_they_are_about() -> None:
    assert both("a", "b", "c") == "a; b; c"
    assert both(made()).template == TEMPLATE
    assert kept(both(made(), "b").values["first"]).template == TEMPLATE
    assert led("/odom", made()) == "/odom: /odom: nothing was received within 2 s"
    assert led("/odom", "b").template == "{place}: {tail}"
    assert led(say("ready"), "b").template == "{head}: {tail}"


def test_lists_are_joined_by_commas() -> None:
    assert say("cancelled {what}", what=["a", say("mark {name}", name="B")]) == "cancelled a, mark B"


def test_values_are_data() -> None:
    """Braces and controls of a peer do nothing, and are escaped in an error."""
    hostile = "{seconds} {0.__class__} %s \x1b[2J\n"
    sentence = say("refused: {text}", text=hostile)
    assert sentence == f"refused: {hostile}"
    shown = str(RosError(say("{why}; {list}", why=sentence, list=[hostile])))
    assert "\x1b" not in shown
    assert shown == str(RosError(f"{sentence}; {hostile}"))
    again = kept(shown)
    assert again.template == "{why}; {list}"
    assert kept(again.values["why"]).template == "refused: {text}"


def test_an_error_as_a_value_is_what_it_says() -> None:
    assert say("{error}; try again", error=RosTimeout(made())) == f"{made()}; try again"


def test_a_place_without_a_value_is_a_mistake_of_the_program() -> None:
    with pytest.raises(KeyError):
        say("{topic} {seconds}", topic="/odom")


class Held:
    """Cannot be copied, and changes."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.name = "a"

    def __repr__(self) -> str:
        return f"<Held {self.name}>"


class Speaking:
    def __init__(self) -> None:
        self.lock = threading.Lock()

    def __str__(self) -> str:
        return say("mark {name}", name="A1")


def test_of_an_object_only_what_is_shown_is_kept() -> None:
    """An error is copied to other processes, and outlives what it is about."""
    held, names = Held(), ["a"]
    error = RosError(say("{held!r}: {names}, {what}", held=held, names=names, what=Speaking()))
    held.name, text = "b", str(error)
    names.append("b")
    assert text == "<Held a>: a, mark A1"
    for again in (error, copy.deepcopy(error), pickle.loads(pickle.dumps(error))):
        said = sentence_of(again)
        assert isinstance(said, Sentence)
        assert said == text
        assert said.values["names"] == ["a"]
        assert said.values["what"].template == "mark {name}"
        assert "{!r}".format(said.values["held"]) == "<Held a>"


def test_an_error_is_not_kept_with_its_frames() -> None:
    try:
        raise RosError(say("mark {name}", name="A1"))
    except RosError as error:
        told = say("not sent: {error}", error=error)
    assert told == "not sent: mark A1"
    assert type(told.values["error"]) is Sentence


def test_numbers_of_numpy_keep_their_formats() -> None:
    np = pytest.importorskip("numpy")
    told = say("{metres:.2f} m", metres=np.float32(1.5))
    assert told == "1.50 m"
    told = advice("{metres:.2f} m", key="far", metres=np.float32(1.5))
    assert told.advised({"far": "{metres:.1f} m"}) == "1.5 m"


def test_advice_is_found_by_its_key() -> None:
    """Also inside other sentences and after a copy; its words may change, and a name may read like it."""
    told = both(say("mark {name}", name="go by foot"), advice("go by foot", key="far"))
    assert told == "mark go by foot; go by foot"
    assert pickle.loads(pickle.dumps(told)).advised({"far": "take a cab"}) == "mark go by foot; take a cab"
    assert told.escaped().advised({"far": "take a cab"}) == "mark go by foot; take a cab"
    assert told.advised({}) == told
