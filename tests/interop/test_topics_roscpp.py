"""Topics between us and roscpp, both directions, on our master and on Debian's."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rosproto.node import Node
from tests.interop.topic_samples import TYPES, exchange, sample, wire
from tests.support import ros

ECHO = """
#include <ros/ros.h>
#include <std_msgs/String.h>
#include <geometry_msgs/Twist.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/Image.h>
#include <woosh_msgs/RobotStatus.h>

template <class M> void echo(ros::NodeHandle& node, ros::Publisher& pub, ros::Subscriber& sub) {
  pub = node.advertise<M>("/out", 10);
  boost::function<void(const M&)> callback = [&pub](const M& message) { pub.publish(message); };
  sub = node.subscribe<M>("/in", 10, callback);
}

int main(int argc, char** argv) {
  ros::init(argc, argv, "echo", ros::init_options::NoSigintHandler);
  ros::NodeHandle node;
  ros::Publisher pub;
  ros::Subscriber sub;
  std::string type = argv[1];
  if (type == "std_msgs/String") echo<std_msgs::String>(node, pub, sub);
  if (type == "geometry_msgs/Twist") echo<geometry_msgs::Twist>(node, pub, sub);
  if (type == "sensor_msgs/LaserScan") echo<sensor_msgs::LaserScan>(node, pub, sub);
  if (type == "sensor_msgs/Image") echo<sensor_msgs::Image>(node, pub, sub);
  if (type == "woosh_msgs/RobotStatus") echo<woosh_msgs::RobotStatus>(node, pub, sub);
  ros::spin();
}
"""


@pytest.fixture(scope="session")
def echo_program(build_roscpp: Callable[[str, str], Path]) -> Path:
    """The echo node, compiled once."""
    return build_roscpp("topic_echo", ECHO)


@pytest.mark.parametrize("type_name", TYPES)
def test_a_message_comes_back_from_roscpp_as_it_was(
    any_master: str, echo_program: Path, type_name: str
) -> None:
    """Our publisher -> roscpp's subscriber -> roscpp's publisher -> our subscriber, byte for byte."""
    with ros.start_program(echo_program, any_master, type_name), Node("/ours", master_uri=any_master) as node:
        received = node.subscriber("/out", type_name)
        untyped = node.subscriber("/out")
        publisher = node.publisher("/in", type_name)
        publisher.wait_for_connection(20)
        received.wait_for_connection(20)
        message = sample(type_name)
        assert wire(exchange(publisher, received, message)) == wire(message)
        assert wire(untyped.next(10)) == wire(message)


def test_a_restarted_roscpp_node_is_connected_again(any_master: str, echo_program: Path) -> None:
    """Killed and started again, on other ports, under the same name: both directions come back."""
    with Node("/ours", master_uri=any_master) as node:
        received = node.subscriber("/out", "std_msgs/String", queue_size=1)
        publisher = node.publisher("/in", "std_msgs/String")
        for words in ("before", "after"):
            with ros.start_program(echo_program, any_master, "std_msgs/String") as program:
                publisher.wait_for_connection(20)
                received.wait_for_connection(20)
                while exchange(publisher, received, publisher.message_class(data=words)).data != words:
                    pass
                program.kill()
