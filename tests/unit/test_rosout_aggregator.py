"""The node /rosout: the log of every node on one topic."""

from __future__ import annotations

import pytest

from rosproto.errors import ConnectionLost
from rosproto.master import Master
from rosproto.node import MasterClient, Node
from rosproto.rosout_aggregator import RosoutAggregator
from tests.support.victim import eventually

LOG = "rosgraph_msgs/Log"


def test_its_registrations_are_those_of_debians() -> None:
    """Names, topics and services by which tools find it; it does not publish /rosout itself."""
    with Master() as master, RosoutAggregator(master.uri), MasterClient(master.uri, "/test") as client:
        assert client.get_system_state() == (
            {"/rosout_agg": ["/rosout"]},
            {"/rosout": ["/rosout"]},
            {"/rosout/get_loggers": ["/rosout"], "/rosout/set_logger_level": ["/rosout"]},
        )
        assert client.get_topic_types() == {"/rosout": LOG, "/rosout_agg": LOG}


def test_what_every_node_says_comes_out_with_its_name_and_stamp() -> None:
    """Unchanged: `seq` too, which counts the records of the node that wrote them."""
    with (
        Master() as master,
        RosoutAggregator(master.uri),
        Node("/a", master_uri=master.uri) as a,
        Node("/b", master_uri=master.uri) as b,
        Node("/screen", master_uri=master.uri, rosout=False) as screen,
    ):
        heard = screen.subscriber("/rosout_agg", LOG, queue_size=10)
        heard.wait_for_connection()
        for node in (a, b):
            eventually(
                lambda node=node: any(
                    link.topic == "/rosout" and link.connected for link in node.stats().links
                )
            )
            node.logger.warning("from %s", node.name)
        records = {record.name: record for record in (heard.next(20), heard.next(20))}
        assert {name: (r.msg, r.level, r.header.seq) for name, r in records.items()} == {
            "/a": ("from /a", 4, 1),
            "/b": ("from /b", 4, 1),
        }
        assert records["/a"].file == "test_rosout_aggregator.py"


def test_it_leaves_the_master_when_closed() -> None:
    with Master() as master, MasterClient(master.uri, "/test") as client:
        aggregator = RosoutAggregator(master.uri)
        aggregator.close()
        aggregator.close()
        assert client.get_system_state().nodes == []


def test_without_a_master_it_says_so() -> None:
    with Master() as master:
        uri = master.uri
    with pytest.raises(ConnectionLost, match="/rosout cannot join the master"):
        RosoutAggregator(uri)
