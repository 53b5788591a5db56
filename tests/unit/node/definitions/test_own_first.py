"""A type asked for by its name: the user's own folders first, then the bundled ones, then what robots sent."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import pytest

from rosproto import ActionClient, BagReader, Master, Node
from rosproto.codec import message_class, service_class
from rosproto.errors import DefinitionError
from rosproto.msg import bundled
from rosproto.msg.user_folder import learned_paths
from rosproto.node.definitions.known_definitions import KnownDefinitions
from rosproto.recording import Player, Recorder
from rosproto.tf import TransformListener

String = message_class("std_msgs/String")


def write(folder: Path, **texts: str) -> Path:
    """A folder of definitions: `std_msgs__msg__String="..."`."""
    for name, text in texts.items():
        package, kind, base = name.split("__")
        place = folder / package / kind
        place.mkdir(parents=True, exist_ok=True)
        (place / f"{base}.{kind}").write_text(text)
    return folder


def learned_set(root: Path, **texts: str) -> Path:
    """One set, as `learned_paths` gives it."""
    write(root / "robot", **texts)
    (path,) = learned_paths(root)
    return path


OWN = {
    "std_msgs__msg__String": "string mine\n",
    "std_srvs__srv__SetBool": "int8 mine\n---\nint8 answer\n",
    "actionlib__action__Test": "string what\n---\nuint8 count\n---\n",
}
SENT = {
    "std_msgs__msg__String": "string theirs\n",
    "std_msgs__msg__Bool": "string theirs\n",
    "robot_msgs__msg__Only": "string theirs\n",
}


@pytest.mark.promise("Your own folders and the bundled definitions take precedence")
@pytest.mark.parametrize("turned", [False, True])
def test_the_order(tmp_path: Path, turned: bool) -> None:
    """Own, bundled, learned, in whatever order the folders were given."""
    paths = [write(tmp_path / "own", **OWN), learned_set(tmp_path / "learned", **SENT)]
    revisions = KnownDefinitions(reversed(paths) if turned else paths)
    for name, kind, field in [
        ("std_msgs/String", "msg", "mine"),
        ("std_srvs/SetBool", "srv", "mine"),
        ("actionlib/TestGoal", "msg", "what"),
        ("robot_msgs/Only", "msg", "theirs"),
    ]:
        library = revisions.library_for(name, kind)
        assert library is not None
        spec = library.message(name) if kind == "msg" else library.service(name).request
        assert [f.name for f in spec.fields] == [field]
    assert revisions.library_for("std_msgs/Bool") is None
    assert revisions.library_for("std_msgs/Int8") is None
    assert revisions.library_for("nobody_msgs/Knows") is None


def test_a_learned_folder_named_by_hand_is_the_users_own(tmp_path: Path) -> None:
    """The mark is in what `learned_paths` gives, and goes with it into another process."""
    path = learned_set(tmp_path, **SENT)
    assert KnownDefinitions([path]).library_for("std_msgs/Bool") is None
    assert KnownDefinitions([pickle.loads(pickle.dumps(path))]).library_for("std_msgs/Bool") is None
    assert KnownDefinitions([str(path)]).library_for("std_msgs/Bool") is not None


def test_the_same_definition_gives_the_class_that_programs_import(tmp_path: Path) -> None:
    """A workspace with ROS's own packages in it: other comments, the same md5sum, the same class."""
    revisions = KnownDefinitions([write(tmp_path, std_msgs__msg__String="# what is said\nstring data\n")])
    assert revisions.library_for("std_msgs/String") is None


def test_the_users_folders_are_read_together(tmp_path: Path) -> None:
    """A type of one may use a type of the next; the first that has one counts."""
    one = write(tmp_path / "one", my_msgs__msg__Outer="Inner inner\n", my_msgs__msg__Twice="int8 first\n")
    two = write(tmp_path / "two", my_msgs__msg__Inner="int8 deep\n", my_msgs__msg__Twice="int8 second\n")
    library = KnownDefinitions([one, two]).library_for("my_msgs/Outer")
    assert library is not None
    assert message_class("my_msgs/Outer", library)().inner.deep == 0
    assert message_class("my_msgs/Twice", library).__slots__ == ["first"]


def test_a_damaged_definition_is_told_of_when_it_is_asked_for(tmp_path: Path) -> None:
    """By its file; the bundled one is not taken in its place."""
    revisions = KnownDefinitions([write(tmp_path, std_msgs__msg__String="this is ] no definition\n")])
    with pytest.raises(DefinitionError, match=r"String\.msg"):
        revisions.library_for("std_msgs/String")
    assert revisions.library_for("std_msgs/Bool") is None


def test_a_node_takes_the_users_own(tmp_path: Path) -> None:
    """Publisher, subscriber, one message, service, and action: by name they are the user's; classes stay."""
    own = write(tmp_path / "own", **OWN)
    with (
        Master() as master,
        Node("/n", master_uri=master.uri, rosout=False, msg_path=[own]) as node,
    ):
        publisher = node.publisher("/t", "std_msgs/String", latch=True)
        publisher.publish(mine="x")
        with node.subscriber("/t", "std_msgs/String") as heard:
            assert heard.next(timeout=10).mine == "x"
        assert node.wait_for_message("/t", "std_msgs/String").mine == "x"
        with (
            node.service_server("/s", "std_srvs/SetBool", lambda r: {"answer": r.mine + 1}),
            node.service_client("/s", "std_srvs/SetBool") as client,
        ):
            assert client.call(mine=1, timeout=10).answer == 2
        with ActionClient(node, "/a", "actionlib/Test", status_timeout=None) as action:
            assert action.type.goal.__slots__ == ["what"]
        assert node.publisher("/u", message_class("std_msgs/String")).message_class.__slots__ == ["data"]


# A type of the user's of every name that the library asks for itself.
CLASHES = {
    "std_msgs__msg__String": "string mine\n",
    "rosgraph_msgs__msg__Log": "string mine\n",
    "rosgraph_msgs__msg__Clock": "string mine\n",
    "tf2_msgs__msg__TFMessage": "string mine\n",
    "actionlib_msgs__msg__GoalStatusArray": "string mine\n",
    "roscpp__srv__GetLoggers": "---\nstring mine\n",
    "roscpp__srv__SetLoggerLevel": "---\nstring mine\n",
}


def sums(node: Node) -> dict[str, str]:
    """The md5sum of each topic that a node publishes or subscribes."""
    names = [name for name, _ in (*node._parts.topics.publications(), *node._parts.topics.subscriptions())]
    found: dict[str, Any] = {
        n: node._parts.topics.publication(n) or node._parts.topics.subscription(n) for n in names
    }
    return {name: topic.type.md5sum for name, topic in found.items()}


@pytest.mark.slow
def test_what_the_library_needs_is_its_own(tmp_path: Path) -> None:
    """/rosout, /clock, /tf, loggers, recorder, player, and the status of actions keep their definitions."""
    own = write(tmp_path / "own", **CLASHES)
    md5sum = bundled().md5sum
    with Master() as master:
        with Node("/p", master_uri=master.uri, rosout=False) as setting:
            setting.params["/use_sim_time"] = True
        with (
            Node("/n", master_uri=master.uri, msg_path=[own]) as node,
            Node("/other", master_uri=master.uri, rosout=False) as other,
        ):
            assert sums(node)["/rosout"] == md5sum("rosgraph_msgs/Log")
            assert sums(node)["/clock"] == md5sum("rosgraph_msgs/Clock")
            with other.service_client("/n/get_loggers", service_class("roscpp/GetLoggers")) as client:
                assert client.call(timeout=10).loggers
            with TransformListener(node):
                assert sums(node)["/tf"] == sums(node)["/tf_static"] == md5sum("tf2_msgs/TFMessage")
            with ActionClient(node, "/a", "actionlib/Test", status_timeout=None):
                assert sums(node)["/a/status"] == md5sum("actionlib_msgs/GoalStatusArray")
            bag = tmp_path / "r.bag"
            said = other.publisher("/said", String, latch=True)
            said.publish(data="x")
            with Recorder(node, bag, ["/said"], announce=True, limit=1) as recorder:
                assert sums(node)["/begin_write"] == String._md5sum
                assert recorder.wait(10)
            with BagReader(bag) as reader, Player(node, reader, clock_hz=100.0):
                assert sums(node)["/clock"] == md5sum("rosgraph_msgs/Clock")
                assert sums(node)["/said"] == String._md5sum
