"""Fixtures for tests against real ROS 1; what they do is in tests/support/ros.py.

Everything in this directory is marked `interop`. A fixture whose peer is absent skips the test with the reason;
with REQUIRE_INTEROP=1 in the environment it fails instead.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import pytest

from rosproto.master import Master
from tests.interop.rosbridge_world import World, world
from tests.support import ros, rosbridge_suite

HERE = Path(__file__).resolve().parent
COMPILED = {
    "roscpp_peer",
    "build_revised_roscpp",
}  # fixtures: 10 s of a processor, of which there may be a tenth


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what is in this directory, and give it time: it starts programs, and may have to compile them first."""
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(pytest.mark.interop)
            compiled = COMPILED & set(getattr(item, "fixturenames", ()))
            item.add_marker(pytest.mark.timeout(600 if compiled else 300))


@pytest.fixture(scope="session")
def ros_installed() -> None:
    """Real ROS 1 is there; otherwise the test is skipped."""
    ros.require_ros()


@pytest.fixture
def our_master() -> Iterator[Master]:
    """A fresh master of ours on 127.0.0.1; `.uri`."""
    with Master() as master:
        yield master


@pytest.fixture
def real_roscore(ros_installed: None) -> Iterator[str]:
    """URI of a fresh rosmaster of Debian's on 127.0.0.1."""
    with ros.start_real_master() as uri:
        yield uri


@pytest.fixture(params=["ours", "debian"])
def any_master(request: pytest.FixtureRequest) -> str:
    """URI of a fresh master; the test runs against ours and against Debian's."""
    if request.param == "ours":
        return str(request.getfixturevalue("our_master").uri)
    return str(request.getfixturevalue("real_roscore"))


@pytest.fixture(scope="session")
def shared_directory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One directory per test session, the same for all pytest-xdist workers."""
    base = tmp_path_factory.getbasetemp()
    if os.environ.get("PYTEST_XDIST_WORKER"):
        base = base.parent  # each worker's own directory lies in the session's
    directory = base / "ros-shared"
    directory.mkdir(exist_ok=True)
    return directory


def _made_once(directory: Path, make: Callable[[Path], Path]) -> Path:
    """`make(directory)` by whichever worker comes first; the others wait for it."""
    done = directory.with_suffix(".done")
    with ros.exclusive(directory.with_suffix(".lock")):
        if not done.exists():
            make(directory)
            done.touch()
    return directory


@pytest.fixture(scope="session")
def genpy_packages(ros_installed: None, shared_directory: Path) -> Path:
    """Python message packages of our msgdefs (woosh_msgs and so on) made by genpy; for `packages=`."""
    return _made_once(shared_directory / "python-packages", ros.generate_python_packages)


@pytest.fixture(scope="session")
def revised_packages(genpy_packages: Path, shared_directory: Path) -> Callable[[str], str]:
    """`revised_packages("1.1.0")`: woosh_msgs of that revision for rospy, made by genpy; for `packages=`."""

    def make(label: str) -> str:
        def generate(target: Path) -> Path:
            root = ros.write_revision(target / "definitions", "woosh_msgs", label)
            return ros.generate_python_packages(target, root)

        made = _made_once(shared_directory / f"python-revision-{label}", generate)
        return f"{made}{os.pathsep}{genpy_packages}"  # it finds its woosh_msgs first, the others behind

    return make


@pytest.fixture(scope="session")
def build_revised_roscpp(ros_installed: None, shared_directory: Path) -> Callable[..., Path]:
    """`build(name, source, "1.1.0") -> executable`: a C++ node with woosh_msgs of that revision, by gencpp.

    `changes` replaces texts: {"msg/Battery.msg": "..."}; give it a label of its own then: "page+1".
    """

    def build(name: str, source: str, label: str, changes: Mapping[str, str] | None = None) -> Path:
        def generate(target: Path) -> Path:
            root = ros.write_revision(target / "definitions", "woosh_msgs", label.partition("+")[0])
            for path, text in (changes or {}).items():
                (root / "woosh_msgs" / path).write_text(text)
            return root

        made = _made_once(shared_directory / f"cpp-revision-{label}", generate)
        return ros.build_cpp_node(f"{name}-{label}", source, shared_directory, made / "definitions", "-O0")

    return build


@pytest.fixture(scope="session")
def roscpp_peer(ros_installed: None, shared_directory: Path) -> Path:
    """The executable of roscpp_peer.cpp, compiled once per session; its first argument is a role."""
    source = (HERE / "roscpp_peer.cpp").read_text("utf-8")
    return ros.build_cpp_node("roscpp_peer", source, shared_directory, optimise="-O0")


@pytest.fixture(scope="session")
def built_rosbridge(ros_installed: None, shared_directory: Path) -> Path:
    """rosbridge_suite as catkin would have made it; skipped without a checkout of it."""
    place = rosbridge_suite.checkout()

    def make(target: Path) -> Path:
        return rosbridge_suite.build(place, target)

    return _made_once(shared_directory / "rosbridge-suite", make)


@pytest.fixture(scope="module", params=["ours", "original"])
def web_world(request: pytest.FixtureRequest, genpy_packages: Path) -> Iterator[World]:
    """A robot of rospy at Debian's master, behind our bridge, and behind the original."""
    built = request.getfixturevalue("built_rosbridge") if request.param == "original" else None
    with ros.start_real_master() as uri, world(request.param, uri, genpy_packages, built) as made:
        yield made
