"""`rosproto master` is a roscore: the node /rosout runs beside the master."""

from __future__ import annotations

from rosproto.node import MasterClient, Node
from tests.unit.cli.test_master import TIMEOUT, command, first_line


def test_the_log_of_the_graph_is_there_when_the_uri_is() -> None:
    with command("master", "--port", "0") as process:
        uri = first_line(process)
        with (
            Node("/screen", master_uri=uri, rosout=False) as screen,
            Node("/talker", master_uri=uri) as talker,
        ):
            assert screen.master.get_system_state().publishers["/rosout_agg"] == ["/rosout"]
            log = screen.subscriber("/rosout_agg", "rosgraph_msgs/Log")
            log.wait_for_connection(TIMEOUT)
            talker.logger.error("it is broken")
            heard = log.next(TIMEOUT)
            assert (heard.name, heard.msg) == ("/talker", "it is broken")


def test_a_master_for_every_network_has_it_too() -> None:
    """Under an address that others can reach."""
    with command("master", "--port", "0", "--host", "0.0.0.0") as process:
        uri = first_line(process)
        with MasterClient(uri, "/test") as client:
            assert client.lookup_node("/rosout").startswith(uri.rpartition(":")[0] + ":")


def test_it_may_be_left_out() -> None:
    with (
        command("master", "--port", "0", "--no-rosout") as process,
        MasterClient(first_line(process), "/test") as client,
    ):
        assert client.get_system_state().nodes == []


def test_a_master_that_its_own_computer_may_not_ask_goes_on_without() -> None:
    """--allow is for this computer too; the sentence on stderr says what is missing."""
    with command("master", "--port", "0", "--allow", "192.0.2.77") as process:
        assert first_line(process).startswith("http://127.0.0.1:")
        assert any("there is no /rosout_agg" in line for line in process.stderr)  # until it comes, or the end
        assert process.poll() is None
