"""A web page (npm's roslib) and nodes of roscpp at Debian's roscore, with our bridge between them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.interop.rosbridge_world import our_bridge
from tests.interop.web_page import pages
from tests.support import ros
from tests.support.extras import needs

needs("bridge")


@pytest.fixture
def bridged(real_roscore: str) -> Iterator[tuple[str, str]]:
    """Debian's master, and the URL of our bridge at it."""
    with our_bridge(real_roscore) as url:
        yield real_roscore, url


GOALS = """
const act = (mode, cancel) => new Promise(done => {
  const action = new ROSLIB.Action({ros, name: '/act', actionType: 'woosh_msgs/StepControl'});
  const id = action.sendGoal({mode}, r => done(['result', r.percent]), f => { if (cancel) action.cancelGoal(id); },
    e => done(['failed', e]));
});
say('done', ...await act(1));
say('aborted', ...await act(4));
say('cancelled', ...await act(2, true));
"""


def test_goals_for_an_action_server_of_roscpp(bridged: tuple[str, str], roscpp_peer: Path) -> None:
    """Done, aborted, and cancelled by its feedback, with their results."""
    master, url = bridged
    with ros.start_program(roscpp_peer, master, "action_server") as server, pages(url) as open_page:
        server.wait_for("up")
        page = open_page(GOALS)
        assert page.said("done") == [["result", 7]]
        assert "aborted" in page.said("aborted")[0][1]
        assert '"percent":9' in page.said("cancelled")[0][1]


CALLS = """
say('set', ...await call('/set', 'std_srvs/SetBool', {data: true}));
say('off', ...await call('/set', 'std_srvs/SetBool', {data: false}));
say('type', await asked('getServiceType', '/set'));
"""


def test_calls_of_a_service_of_roscpp(bridged: tuple[str, str], roscpp_peer: Path) -> None:
    """Its answer, its failure, and its type, which only its provider knows."""
    master, url = bridged
    with ros.start_program(roscpp_peer, master, "service_server") as server, pages(url) as open_page:
        server.wait_for("ready")
        page = open_page(CALLS)
        assert page.said("set") == [[True, {"success": True, "message": "set"}]]
        assert page.said("off")[0][0] is False
        assert page.said("type") == [["std_srvs/SetBool"]]


PROVIDES = """
await new ROSLIB.Service({ros, name: '/ours', serviceType: 'std_srvs/SetBool'}).advertise((request, response) => {
  if (!request.data) return false;
  response.success = true; response.message = 'ours';
  return true;
});
"""


def test_roscpp_calls_a_service_of_a_page(bridged: tuple[str, str], roscpp_peer: Path) -> None:
    """One call at a time and over a kept connection; a failure in between."""
    master, url = bridged
    with pages(url) as open_page:
        open_page(PROVIDES)
        with ros.start_program(roscpp_peer, master, "service_client") as client:
            client.wait_for("^done")
            lines = client.output.splitlines()
    for kept in (0, 1):
        for number in range(4):
            expected = f"call {kept} {number} 0 " if number == 2 else f"call {kept} {number} 1 ours"
            assert expected in lines


TOPICS = """
topic('/cpp_chatter', 'std_msgs/String').subscribe(m => say('latched', m.data));
const mouth = topic('/chatter', 'std_msgs/String');
setInterval(() => mouth.publish({data: 'by a page ☃'}), 100);
"""


def test_topics_with_roscpp(bridged: tuple[str, str], roscpp_peer: Path) -> None:
    """A latched message of roscpp's, and what a page publishes."""
    master, url = bridged
    with ros.start_program(roscpp_peer, master, "cpp_node") as node, pages(url) as open_page:
        node.wait_for("cpp up")
        page = open_page(TOPICS)
        assert page.said("latched") == [["latched by cpp"]]
        node.wait_for("by a page ☃")
