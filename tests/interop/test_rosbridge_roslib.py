"""npm's `roslib` (roslibjs), unmodified, against real rospy nodes behind our bridge, and behind the original."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import ExitStack

import pytest

from rosproto.action import ActionClient, GoalStatus
from rosproto.gateway import Rosbridge
from rosproto.node import Node
from tests.interop.rosbridge_world import World
from tests.interop.web_page import Page, pages
from tests.support import rosbridge_suite
from tests.support.extras import needs
from tests.support.victim import eventually

needs("bridge")


@pytest.fixture
def page(web_world: World) -> Iterator[Callable[[str], Page]]:
    """`page(program)`: runs it in a page that is connected."""
    with pages(web_world.url) as opens:
        yield opens


TOPICS = """
const once = (name, type, more) => new Promise(done => {
  const it = topic(name, type, more); it.subscribe(m => { it.unsubscribe(); done(m); });
});
say('kept', (await once('/kept', 'std_msgs/String')).data);
for (const compression of ['none', 'png', 'cbor']) {
  const scan = await once('/scan', 'sensor_msgs/LaserScan', {compression});
  say('scan', compression, [...scan.ranges].map(x => Number.isFinite(x) ? x : null), scan.header.frame_id);
  const picture = await once('/picture', 'sensor_msgs/Image', {compression});
  const data = typeof picture.data === 'string' ? Buffer.from(picture.data, 'base64') : picture.data;
  say('picture', compression, picture.encoding, [...data]);
}
const raw = await once('/chatter', 'std_msgs/String', {compression: 'cbor-raw'});
say('raw', [...new Uint8Array(raw.bytes)], typeof raw.secs, typeof raw.nsecs);
topic('/heard', 'std_msgs/String').subscribe(m => say('heard', m.data));
const out = topic('/to_robot', 'std_msgs/String');
const drive = topic('/cmd_vel', 'geometry_msgs/Twist');
out.advertise(); drive.advertise();
setInterval(() => { out.publish({data: 'from a page ☃'}); drive.publish({linear: {x: 0.25}}); }, 100);
topic('/from_page', 'std_msgs/String', {latch: true}).publish({data: 'latched by a page'});
let slow = 0;
const begun = performance.now();
topic('/chatter', 'std_msgs/String', {throttle_rate: 400}).subscribe(() => { slow += 1; });
setTimeout(() => say('slow', slow, performance.now() - begun), 2000);
"""


def test_topics_both_ways(web_world: World, page: Callable[[str], Page]) -> None:
    """Latched ones, each compression, NaN as null, bytes as base64, what a page publishes, throttling."""
    opened = page(TOPICS)
    assert opened.said("kept") == [["kept äöü 地图"]]
    assert opened.said("scan", 3) == [
        [kind, [0.5, None, None, 2.0], "laser"] for kind in ("none", "png", "cbor")
    ]
    assert opened.said("picture", 3) == [[kind, "rgb8", list(range(18))] for kind in ("none", "png", "cbor")]
    assert opened.said("raw") == [[[5, 0, 0, 0, *b"hello"], "number", "number"]]
    eventually(lambda: ["from a page ☃!"] in opened.said("heard"), 20)
    eventually(lambda: ["0.25 0.0"] in opened.said("heard"), 20)
    assert web_world.node.wait_for_message("/from_page", timeout=20).data == "latched by a page"
    # More than 2,000 ms pass where the page has to wait for a processor.
    ((count, milliseconds),) = opened.said("slow")
    assert 3 <= count <= milliseconds / 400 + 1


AUTHENTICATED = """
ros.on('close', () => say('closed'));
ros.authenticate('MAC', '10.0.0.9', '10.0.0.7', 'xyz', 1000, 'admin', 2000);
ros.getTopics(found => say('topics', found.topics), why => say('refused', why));
"""


@pytest.fixture(params=["ours", "original"])
def authenticating(request: pytest.FixtureRequest, real_roscore: str) -> Iterator[str]:
    """URL of a bridge that asks for credentials, which a service as rosauth provides it checks."""
    with ExitStack() as stack:
        node = stack.enter_context(Node("/auth", master_uri=real_roscore, host="127.0.0.1"))
        node.service_server(
            "/authenticate",
            "rosauth/Authentication",
            lambda asked: {
                "authenticated": (asked.mac, asked.t.secs, asked.end.secs) == ("right", 1000, 2000)
            },
        )
        if request.param == "ours":
            yield stack.enter_context(Rosbridge(node, port=0, authenticate=True)).url
            return
        built = request.getfixturevalue("built_rosbridge")
        messages = request.getfixturevalue("genpy_packages")
        node.params["/rosbridge_websocket/authenticate"] = True
        suite = rosbridge_suite.served(rosbridge_suite.checkout(), built, real_roscore, messages=messages)
        yield stack.enter_context(suite)


@pytest.mark.parametrize(("mac", "word"), [("right", "topics"), ("wrong", "closed")])
def test_credentials(authenticating: str, mac: str, word: str) -> None:
    """`ros.authenticate`: the page is served, or cut off."""
    with pages(authenticating) as opens:
        assert opens(AUTHENTICATED.replace("MAC", mac)).said(word)


SERVICES = """
const service = (name, serviceType) => new ROSLIB.Service({ros, name, serviceType});
say('on', ...await call('/lamp', 'std_srvs/SetBool', {data: true}));
say('broken', ...await call('/lamp', 'std_srvs/SetBool', {data: false}));
say('none', ...await call('/nobody', 'std_srvs/SetBool', {data: true}));
say('wrong', ...await call('/lamp', 'std_srvs/SetBool', {data: 'text'}));
say('unknown', ...await call('/lamp', 'std_srvs/SetBool', {dota: true}));
await service('/browser', 'std_srvs/SetBool').advertise((request, response) => {
  response.success = request.data; response.message = 'by a page'; return true;
});
await service('/browser_async', 'std_srvs/SetBool').advertiseAsync(async request => {
  if (!request.data) throw new Error('not that');
  return {success: true, message: 'later'};
});
setTimeout(async () => say('round', ...await call('/ask', 'std_srvs/Trigger', {})), 500);
"""


def test_services_both_ways(web_world: World, page: Callable[[str], Page]) -> None:
    """A page calls rospy, and hears why it failed; rospy, and this node, call a service of the page."""
    opened = page(SERVICES)
    assert opened.said("on") == [[True, {"success": True, "message": "on"}]]
    ((worked, why),) = opened.said("broken")
    assert not worked
    assert "the lamp is broken" in why
    ((worked, why),) = opened.said("none")
    assert not worked
    assert "/nobody" in why
    for word in ("wrong", "unknown"):
        ((worked, why),) = opened.said(word)
        assert (worked, isinstance(why, str)) == (False, True)
    assert opened.said("round") == [[True, {"success": True, "message": "by a page"}]]
    client = web_world.node.service_client("/browser_async", "std_srvs/SetBool")
    answer = client.call(data=True, timeout=20)
    assert (answer.success, answer.message) == (True, "later")
    with pytest.raises(Exception, match=r"."):  # at the original's the call never ends
        client.call(data=False, timeout=20 if web_world.bridge == "ours" else 2)


QUESTIONS = """
const param = name => new ROSLIB.Param({ros, name});
const get = name => new Promise((yes, no) => param(name).get(yes, no));
say('speed', await get('/speed'), await get('/robot'), await get('/none'));
await new Promise((yes, no) => param('/set_here').set({a: [1, 'ö']}, yes, no));
say('set', await get('/set_here'));
await new Promise((yes, no) => param('/set_here').delete(yes, no));
say('deleted', await get('/set_here'));
say('params', await asked('getParams'));
say('topics', await asked('getTopics'));
say('type', await asked('getTopicType', '/chatter'), await asked('getTopicsForType', 'sensor_msgs/Image'));
say('services', await asked('getServices'), await asked('getServiceType', '/lamp'));
say('for type', await asked('getServicesForType', 'std_srvs/Trigger'));
say('request', await new Promise((y, n) => ros.getServiceRequestDetails('std_srvs/SetBool', y, n)));
say('response', await new Promise((y, n) => ros.getServiceResponseDetails('std_srvs/SetBool', y, n)));
say('details', ros.decodeTypeDefs(await asked('getMessageDetails', 'nav_msgs/Odometry')));
say('nodes', await asked('getNodes'));
say('node', await new Promise((y, n) => ros.getNodeDetails('/robot', y, n)));
say('actions', await asked('getActionServers'));
say('raw', await asked('getTopicsAndRawTypes'));
new ROSLIB.Topic({ros, name: '/chatter', messageType: 'std_msgs/String'}).getPublishers(v => say('who', v));
"""


def test_parameters_and_the_graph(web_world: World, page: Callable[[str], Page]) -> None:
    """Everything that roslib asks /rosapi."""
    opened = page(QUESTIONS)
    assert opened.said("speed") == [[0.5, {"name": "ö", "size": [1, 2.5, True]}, None]]
    assert opened.said("set") == [[{"a": [1, "ö"]}]]
    assert opened.said("deleted") == [[None]]
    assert "/robot/name" in opened.said("params")[0][0]
    ((topics,),) = opened.said("topics")
    types = dict(zip(topics["topics"], topics["types"], strict=True))
    assert (types["/scan"], types["/to_robot"]) == ("sensor_msgs/LaserScan", "std_msgs/String")
    assert opened.said("type") == [["std_msgs/String", ["/picture"]]]
    ((services, kind),) = opened.said("services")
    assert {"/lamp", "/ask", "/rosapi/topics"} <= set(services)
    assert kind == "std_srvs/SetBool"
    assert opened.said("for type") == [[["/ask"]]]
    assert opened.said("request")[0][0]["typedefs"][0]["fieldnames"] == ["data"]
    assert opened.said("response")[0][0]["typedefs"][0]["fieldnames"] == ["success", "message"]
    ((details,),) = opened.said("details")
    assert details["pose"]["covariance"] == ["float64"]
    assert details["pose"]["pose"]["position"]["x"] == "float64"
    assert "/robot" in opened.said("nodes")[0][0]
    ((node,),) = opened.said("node")
    assert "/chatter" in json.dumps(node)
    assert "/walk" in opened.said("actions")[0][0]
    ((raw,),) = opened.said("raw")
    assert "float32[] ranges" in dict(zip(raw["topics"], raw["typedefs_full_text"], strict=True))["/scan"]
    assert opened.said("who") == [[["/robot"]]]


ACTIONS = """
const client = new ROSLIB.ActionClient({ros, serverName: '/walk', actionName: 'actionlib/TestAction'});
const walk = goal => new Promise(done => {
  const it = new ROSLIB.Goal({actionClient: client, goalMessage: {goal}});
  it.on('feedback', f => { say('feedback', f.feedback); if (goal < 0) it.cancel(); });
  it.on('result', r => done([r.result, it.status.status, it.status.text]));
  it.send();
});
// The robot's side has to see the goal's publisher first: roslib itself does not wait for it.
const seen = name => new Promise(done => { const look = setInterval(async () => {
  const of = await new Promise((y, n) => ros.getNodeDetails('/robot', y, n));
  const who = await new Promise(y => new ROSLIB.Topic({ros, name, messageType: '*'}).getPublishers(y));
  if (who.length) { clearInterval(look); setTimeout(done, 500); } }, 50); });
await seen('/walk/goal');
say('walked', ...await walk(5));
say('too far', ...await walk(500));
say('cancelled', ...await walk(-3));
const server = new ROSLIB.SimpleActionServer({ros, serverName: '/page_act', actionName: 'actionlib/TestAction'});
server.on('goal', goal => { server.sendFeedback({feedback: goal.goal}); server.setSucceeded({result: goal.goal + 1}); });
"""


def test_actions_over_their_topics(web_world: World, page: Callable[[str], Page]) -> None:
    """A page sends goals to rospy's server, which succeeds, aborts, and is cancelled; and is a server itself."""
    opened = page(ACTIONS)
    assert opened.said("walked") == [[10, 3, "well"]]
    assert opened.said("too far") == [[0, 4, "too far"]]
    assert opened.said("cancelled") == [[-1, 2, "as you wish"]]
    assert [-3] in opened.said("feedback")  # which is what cancelled it
    with ActionClient(web_world.node, "/page_act", "actionlib/Test") as client:
        client.wait_for_server(20)
        handle = client.send_goal({"goal": 41})
        assert handle.wait(20).result == 42
        assert handle.status is GoalStatus.SUCCEEDED


@pytest.fixture
def our_world(web_world: World) -> World:
    """For what the original has not."""
    if web_world.bridge != "ours":
        pytest.skip("the original has no such operation, and no tf2_web_republisher")
    return web_world


TF = """
const first = Client => new Promise(done => {
  const client = new Client({ros, fixedFrame: 'map', angularThres: 0.01, transThres: 0.01, rate: 20});
  client.subscribe('base_link', tf => done([tf.translation.x, tf.rotation.w]));
});
say('tf', ...await first(ROSLIB.TFClient));
say('tf of ROS 2', ...await first(ROSLIB.ROS2TFClient));
"""


def test_tf_clients(our_world: World, page: Callable[[str], Page]) -> None:
    """Transforms through the action that the bridge provides, by either of roslib's clients."""
    opened = page(TF)
    assert opened.said("tf") == [[1.5, 1]]
    assert opened.said("tf of ROS 2") == [[1.5, 1]]


NEW_ACTIONS = """
const walk = actionType => new ROSLIB.Action({ros, name: '/walk', actionType});
const run = (actionType, goal, cancel) => new Promise(done => {
  const it = walk(actionType);
  const id = it.sendGoal({goal}, r => done(['result', r]), f => {
    say('feedback', f.feedback); if (cancel) it.cancelGoal(id);
  }, e => done(['failed', e]));
});
say('walked', ...await run('actionlib/Test', 5));
say('walked', ...await run('actionlib/action/Test', 6));
say('walked', ...await run('actionlib/TestAction', 7));
say('too far', ...await run('actionlib/Test', 500));
say('cancelled', ...await run('actionlib/Test', -3, true));
say('all cancelled', ...await new Promise(done => {
  const it = walk('actionlib/Test');
  it.sendGoal({goal: -4}, r => done(['result', r]), () => it.cancelAllGoals(), e => done(['failed', e]));
}));
say('nobody', ...await new Promise(done => new ROSLIB.Action({ros, name: '/nobody', actionType: 'actionlib/Test'})
  .sendGoal({goal: 1}, r => done(['result', r]), undefined, e => done(['failed', e]))));
"""


def test_the_newer_action_operations(our_world: World, page: Callable[[str], Page]) -> None:
    """roslib's Action, written for ROS 2, with an action server of rospy: done, aborted, cancelled, nobody there."""
    opened = page(NEW_ACTIONS)
    assert opened.said("walked", 3) == [["result", {"result": number}] for number in (10, 12, 14)]
    assert [-3] in opened.said("feedback")
    (too_far,), (cancelled,), (nobody,) = (opened.said(word) for word in ("too far", "cancelled", "nobody"))
    assert "canceled" in opened.said("all cancelled")[0][1]
    assert too_far[0] == cancelled[0] == nobody[0] == "failed"
    assert "aborted" in too_far[1]
    assert "canceled" in cancelled[1]
    assert '{"result":-1}' in cancelled[1]
    assert "/nobody" in nobody[1]


PROVIDED_ACTION = """
const stairs = new ROSLIB.Action({ros, name: '/stairs', actionType: 'actionlib/Test'});
stairs.advertise((goal, id) => {
  say('goal', goal.goal);
  stairs.sendFeedback(id, {feedback: goal.goal});
  if (goal.goal === 1) stairs.setSucceeded(id, {result: 10});
  if (goal.goal === 2) stairs.setFailed(id);
}, id => stairs.setCanceled(id, {result: -1}));
"""


def test_a_page_provides_an_action(our_world: World, page: Callable[[str], Page]) -> None:
    """roslib's `Action.advertise`: goals of ROS 1 that it ends, fails at, and gives up."""
    opened = page(PROVIDED_ACTION)
    with ActionClient(our_world.node, "/stairs", "actionlib/Test") as client:
        client.wait_for_server(20)
        heard: list[int] = []
        done, failed, given_up = (
            client.send_goal({"goal": i}, feedback=lambda _, f: heard.append(f.feedback)) for i in (1, 2, 3)
        )
        assert (done.wait(20).result, done.status) == (10, GoalStatus.SUCCEEDED)
        failed.wait(20)
        assert failed.status is GoalStatus.ABORTED
        eventually(lambda: 3 in heard, 20)
        given_up.cancel()
        assert (given_up.wait(20).result, given_up.status) == (-1, GoalStatus.PREEMPTED)
    assert sorted(opened.said("goal", 3)) == [[1], [2], [3]]
