"""The name of a node: its own part must be legal, the namespace only usable."""

from __future__ import annotations

import pytest

from rosproto.node.options import node_name


@pytest.mark.parametrize("name", ["my-node", "my.node", "7up", "kn\u00f6ten", "a b", "~x", "/", "", "a//b"])
def test_a_name_of_ones_own_that_is_not_legal_is_refused(name: str) -> None:
    """It is a mistake of this program, seen where it is made."""
    with pytest.raises(ValueError, match="is not a node name"):
        node_name(name, "/", False)


def test_a_namespace_that_is_not_legal_is_told_and_taken(caplog: pytest.LogCaptureFixture) -> None:
    """It is the robot's (ROS_NAMESPACE=robot-1); rospy and its tools work there."""
    assert node_name("n", "robot-1", False) == "/robot-1/n"
    assert node_name("/n", "robot-1", False) == "/n"
    assert [record.getMessage() for record in caplog.records] == [
        "! /robot-1/n is not a legal ROS name; roscpp and some tools refuse it"
    ]


@pytest.mark.parametrize("namespace", ["robot 1", "a:b", "~a"])
def test_a_namespace_that_no_master_takes_is_refused_with_its_source(namespace: str) -> None:
    """The user may not have written it into the program."""
    with pytest.raises(ValueError, match=r"is not a ROS name; .* ROS_NAMESPACE"):
        node_name("n", namespace, False)
