"""Topics, services, parameters and actions with npm's rosnodejs, both ways, at our master and at Debian's."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import pytest

from rosproto.action import ActionClient, ActionServer
from rosproto.codec import message_class
from rosproto.errors import ServiceError
from rosproto.master import Master
from rosproto.node import Node
from tests.support import rosnodejs
from tests.support.victim import eventually


@pytest.fixture(scope="session")
def installed() -> Path:
    """Where rosnodejs is."""
    return rosnodejs.installed()


@pytest.fixture(scope="session")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its message packages."""
    return rosnodejs.package_tree(tmp_path_factory.mktemp("packages"))


TOPICS = """
  const pub = nh.advertise('/from_js', 'std_msgs/String');
  const kept = nh.advertise('/kept_js', 'geometry_msgs/PoseStamped', {latching: true});
  const back = nh.advertise('/scan_back', 'sensor_msgs/LaserScan');
  kept.publish({
    header: {seq: 0, stamp: {secs: 0, nsecs: 0}, frame_id: 'map'},
    pose: {position: {x: 1.5, y: -2, z: 1e-300}, orientation: {x: 0, y: 0, z: 0, w: 1}},
  });
  nh.subscribe('/to_js', 'std_msgs/String', m => { pub.publish({data: m.data + '!'}); });
  nh.subscribe('/kept_ours', 'std_msgs/String', m => { say({kept: m.data}); });
  nh.subscribe('/scan', 'sensor_msgs/LaserScan', m => { back.publish(m); });
  say('ready');
"""


def test_topics_both_ways(any_master: str, installed: Path, tree: Path) -> None:
    """Strings with any text, latched messages in both directions, arrays and headers there and back."""
    with Node("/ours", master_uri=any_master) as node:
        node.publisher("/kept_ours", "std_msgs/String", latch=True).publish(data="latched here")
        to_js, scans = (
            node.publisher("/to_js", "std_msgs/String", queue_size=100),
            node.publisher("/scan", "sensor_msgs/LaserScan"),
        )
        from_js = node.subscriber("/from_js", "std_msgs/String", queue_size=100)
        back = node.subscriber("/scan_back", "sensor_msgs/LaserScan")
        with rosnodejs.start(TOPICS, any_master, installed, tree) as js:
            js.wait_for('"ready"')
            kept = node.subscriber("/kept_js", None).next(60)
            assert (kept.pose.position.x, kept.pose.position.z, kept.header.frame_id) == (1.5, 1e-300, "map")
            js.wait_for('"kept":"latched here"')
            to_js.wait_for_connection(60)
            from_js.wait_for_connection(60)
            texts = ["plain", "", "ünïcödé ☃", "a" * 100_000, *map(str, range(50))]
            for text in texts:  # one after the other: its queues keep a single message
                to_js.publish(data=text)
                assert from_js.next(60).data == text + "!"
            scans.wait_for_connection(60)
            back.wait_for_connection(60)
            scan = message_class("sensor_msgs/LaserScan")(
                ranges=[0.5, 1.25, float("inf")], angle_min=-1.5, intensities=[]
            )
            scan.header.frame_id = "laser"
            scans.publish(scan)
            came = back.next(60)
            assert list(came.ranges) == [0.5, 1.25, float("inf")]
            assert (came.angle_min, came.header.frame_id) == (-1.5, "laser")


def test_a_restarted_rosnodejs_publisher_is_found_again(
    our_master: Master, installed: Path, tree: Path
) -> None:
    """Killed without a word, started again: connected by itself."""
    script = "const pub = nh.advertise('/tick_js', 'std_msgs/String'); setInterval(() => pub.publish({data: 'WORD'}), 50); say('ready');"
    with Node("/ours", master_uri=our_master.uri) as node:
        ticks = node.subscriber("/tick_js", "std_msgs/String")
        for word in ("before", "after"):
            with rosnodejs.start(script.replace("WORD", word), our_master.uri, installed, tree) as js:
                js.wait_for('"ready"')
                while ticks.next(60).data != word:
                    pass  # what came before the end
                js.kill()


SERVICES = """
  nh.advertiseService('/js_set', 'std_srvs/SetBool', (req, resp) => {
    resp.success = !req.data; resp.message = 'from js'; return true;
  });
  nh.advertiseService('/js_fails', 'std_srvs/Trigger', (req, resp) => false);
  say('ready');
  const set = rosnodejs.require('std_srvs').srv.SetBool, trigger = rosnodejs.require('std_srvs').srv.Trigger;
  for (const persist of [false, true]) {
    const client = nh.serviceClient('/our_set', 'std_srvs/SetBool', {persist});
    await nh.waitForService('/our_set', 20000);
    for (let n = 0; n < 5; ++n) { const r = await client.call(new set.Request({data: n % 2 == 1})); say({n, persist, r}); }
    client.close();
  }
  try { await nh.serviceClient('/our_fails', 'std_srvs/Trigger').call(new trigger.Request()); say('no error'); }
  catch (e) { say({error: String(e)}); }
  say('done');
"""


def test_services_both_ways(any_master: str, installed: Path, tree: Path) -> None:
    """Persistent and not, errors with their text; our client waits for its service and calls it a hundred times."""
    with Node("/ours", master_uri=any_master) as node:

        def fails(request: object) -> None:
            raise ServiceError("/our_fails", "we say no")

        node.service_server(
            "/our_set", "std_srvs/SetBool", lambda r: {"success": not r.data, "message": "from us"}
        )
        node.service_server("/our_fails", "std_srvs/Trigger", fails)
        with rosnodejs.start(SERVICES, any_master, installed, tree) as js:
            js.wait_for('"ready"')
            node.wait_for_service("/js_set", timeout=60)
            for persistent in (False, True):
                client = node.service_client("/js_set", "std_srvs/SetBool", persistent=persistent)
                for number in range(50):
                    answer = client.call(data=number % 2 == 1, timeout=60)
                    assert (answer.success, answer.message) == (number % 2 == 0, "from js")
            with pytest.raises(ServiceError):
                node.service_client("/js_fails", "std_srvs/Trigger", persistent=True).call(timeout=60)
            js.wait_for('"done"')
            assert js.output.count('"message":"from us"') == 10
            assert js.output.count('"success":true') == 6
            assert '"error":' in js.output
            assert "no error" not in js.output


# A call made right after the answer to the one before is sent twice by it, over connections of their own, and the
# answer that comes first counts (XmlrpcClient.js, _tryExecuteCall). What is deleted was therefore set long before,
# and deleted after a pause: the second of two deletions is refused.
PARAMETERS = """
  await nh.setParam('/js/gone', 5);
  await nh.setParam('/js/text', 'ünï <&> "quoted"');
  await nh.setParam('/js/tree', {a: 1, b: [1, 2.5, true, 'x'], c: {d: ''}});
  await new Promise(done => setTimeout(done, 50));
  await nh.deleteParam('/js/gone');
  say({read: await nh.getParam('/ours'), has: await nh.hasParam('/ours/n'), hasnt: await nh.hasParam('/nobody')});
  say('done');
"""


def test_parameters_both_ways(our_master: Master, installed: Path, tree: Path) -> None:
    """Trees, texts, types; what was deleted is gone."""
    with Node("/ours", master_uri=our_master.uri) as node:
        node.params["/ours"] = {"n": 7, "f": 0.5, "t": "ünï <&>", "l": [True, [1, 2]], "d": {"e": ""}}
        with rosnodejs.start(PARAMETERS, our_master.uri, installed, tree) as js:
            js.wait_for('"done"')
            assert '"read":{"n":7,"f":0.5,"t":"ünï <&>","l":[true,[1,2]],"d":{"e":""}}' in js.output
            assert '"has":true,"hasnt":false' in js.output
            assert node.params["/js/text"] == 'ünï <&> "quoted"'
            assert node.params["/js/tree"] == {"a": 1, "b": [1, 2.5, True, "x"], "c": {"d": ""}}
            assert "/js/gone" not in node.params


# Its waitForServer(time-out) gives up after 100 ms (ActionClientInterface.js, _waitForActionServerToStart: the comparison
# of times is the wrong way round), it ignores feedback that its loop takes up after the result, and of
# what comes while its loop is busy it keeps the last (ClientQueue.js): so this waits by itself, and answers each feedback.
CLIENT = """
  const saw = nh.advertise('/saw', 'std_msgs/Empty');
  const ac = new rosnodejs.SimpleActionClient({nh, type: 'actionlib/Test', actionServer: '/our_action'});
  while (!ac.isServerConnected() || saw.getNumSubscribers() < 1) await new Promise(done => setTimeout(done, 20));
  const goal = n => ({goal: n});
  for (const n of [3, -1]) {
    await new Promise(resolve => ac.sendGoal(goal(n), (state, result) => { say({n, state, result}); resolve(); },
      () => say({n, active: true}),
      feedback => { say({n, feedback: feedback.feedback}); saw.publish({}); }));
  }
  await new Promise(resolve => {
    ac.sendGoal(goal(1000), (state, result) => { say({n: 1000, state, result}); resolve(); }, () => ac.cancelGoal());
  });
  say('done');
"""


def test_its_action_client_with_our_server(our_master: Master, installed: Path, tree: Path) -> None:
    """A goal that succeeds with feedback, one that is aborted, one that is cancelled."""
    result, feedback = message_class("actionlib/TestResult"), message_class("actionlib/TestFeedback")
    saw = threading.Semaphore(0)
    ends = {"/our_action/feedback", "/our_action/result"}

    def count(goal) -> None:  # type: ignore[no-untyped-def]
        # It sends as soon as it has our answers to its headers, which may be a moment before we count its links.
        eventually(lambda: ends <= {link.topic for link in node.stats().links if link.connected})
        if goal.goal.goal < 0:
            goal.abort(result(result=-1), "negative")
            return
        for number in range(goal.goal.goal):
            goal.publish_feedback(feedback(feedback=number))
            if goal.goal.goal == 3:
                assert saw.acquire(timeout=60), f"it never saw feedback {number}"
            if goal.wait_for_cancel(0.05):
                goal.preempted(result(result=number))
                return
        goal.succeed(result(result=goal.goal.goal))

    with (
        Node("/ours", master_uri=our_master.uri) as node,
        node.subscriber("/saw", "std_msgs/Empty", lambda message: saw.release()),
        ActionServer(node, "/our_action", "actionlib/Test", count),
        rosnodejs.start(CLIENT, our_master.uri, installed, tree) as js,
    ):
        js.wait_for('"done"')
        for number in range(3):
            assert f'"feedback":{number}' in js.output
        assert '"result":{"result":3}' in js.output
        assert '"result":{"result":-1}' in js.output
        assert js.output.count('"state"') == 3, js.output


# rosnodejs 3.1.0 dies of any cancel, for want of a method; that is mended here.
SERVER = """
  const handle = require('rosnodejs/dist/actions/GoalHandle.js').prototype;
  handle.getStatus = handle.getStatus || handle.getGoalStatus;
  const result = rosnodejs.require('actionlib').msg.TestResult, feedback = rosnodejs.require('actionlib').msg.TestFeedback;
  const as = new rosnodejs.ActionServer({nh, type: 'actionlib/Test', actionServer: '/js_action'});
  let waiting = null;  // its feedback and its result have connections of their own: the result waits for a word
  nh.subscribe('/go_on', 'std_msgs/Empty', () => { if (waiting) waiting(); });
  as.on('goal', handle => {
    handle.setAccepted('go');
    const n = handle.getGoal().goal;
    handle.publishFeedback(new feedback({feedback: n}));
    if (n < 0) handle.setAborted(new result({result: n}), 'negative');
    else if (n < 100) waiting = () => { waiting = null; handle.setSucceeded(new result({result: n * 2}), 'fine'); };
  });
  as.on('cancel', handle => handle.setCanceled(new result({result: 0}), 'cancelled'));
  as.start();
  say('ready');
"""


def test_our_action_client_with_its_server(our_master: Master, installed: Path, tree: Path) -> None:
    """The same ends the other way round."""
    with (
        Node("/ours", master_uri=our_master.uri) as node,
        rosnodejs.start(SERVER, our_master.uri, installed, tree) as js,
    ):
        js.wait_for('"ready"')
        with ActionClient(node, "/js_action", "actionlib/Test") as client:
            client.wait_for_server(60)
            go_on = node.publisher("/go_on", "std_msgs/Empty")
            go_on.wait_for_connection(60)
            fed: list[int] = []

            def note(handle: object, message: Any) -> None:
                fed.append(message.feedback)
                go_on.publish()

            good = client.send_goal(client.type.goal(goal=21), feedback=note)
            assert good.wait(60).result == 42
            assert good.status.name == "SUCCEEDED"
            assert fed == [21]
            bad = client.send_goal(client.type.goal(goal=-3))
            assert bad.wait(60).result == -3
            assert bad.status.name == "ABORTED"
            long = client.send_goal(client.type.goal(goal=1000))
            next(iter(long.feedback(60)))
            long.cancel()
            long.wait(60)
            assert long.status.name in ("PREEMPTED", "RECALLED")


def test_it_runs_on_our_master_as_on_any(our_master: Master, installed: Path, tree: Path) -> None:
    """What it registers is there, and gone after an orderly end."""
    script = (
        "nh.advertise('/t_js', 'std_msgs/String'); nh.subscribe('/u_js', 'std_msgs/String', () => {});\n"
        "nh.advertiseService('/s_js', 'std_srvs/Empty', () => true); say('ready');\n"
        "nh.subscribe('/end', 'std_msgs/Empty', () => rosnodejs.shutdown().then(() => { say('over'); process.exit(0); }));"
    )
    with (
        Node("/ours", master_uri=our_master.uri) as node,
        rosnodejs.start(script, our_master.uri, installed, tree) as js,
    ):
        js.wait_for('"ready"')

        def registered() -> list[bool]:
            state = node.master.get_system_state()
            kinds = ((state.publishers, "/t_js"), (state.subscribers, "/u_js"), (state.services, "/s_js"))
            return ["/js" in names.get(name, []) for names, name in kinds]

        eventually(lambda: all(registered()), what="its registrations")
        end = node.publisher("/end", "std_msgs/Empty")
        end.wait_for_connection(60)
        end.publish()
        js.wait_for('"over"')
        eventually(lambda: not any(registered()), what="the end of its registrations")
