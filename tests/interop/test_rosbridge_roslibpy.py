"""PyPI's `roslibpy`, unmodified, against real rospy nodes behind our bridge, and behind the original."""

from __future__ import annotations

import json
import subprocess
from typing import Any

import pytest

from rosproto.codec import message_class
from tests.interop.rosbridge_world import World
from tests.support import ros, web_peers
from tests.support.extras import needs

needs("bridge")

HEAD = """
import json, sys, threading, time
import roslibpy
from roslibpy.ros1 import actionlib
said = {}
ros = roslibpy.Ros(host='127.0.0.1', port=int(sys.argv[1]))
ros.run(timeout=20)
def once(name, kind, timeout=20, **options):
    done, got = threading.Event(), []
    topic = roslibpy.Topic(ros, name, kind, **options)
    topic.subscribe(lambda m: (got.append(m), done.set()))
    assert done.wait(timeout), name
    topic.unsubscribe()
    return got[0]
def failing(call):
    try:
        return [True, call()]
    except Exception as error:
        return [False, str(error)]
def wait_until(condition, seconds=20):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)
"""
FOOT = """
print('SAID ' + json.dumps(said, default=lambda v: dict(v) if hasattr(v, 'keys') else str(v)), flush=True)
ros.terminate()
"""


def run(world: World, program: str) -> dict[str, Any]:
    """What a program says."""
    python = web_peers.python_with("roslibpy")
    done = subprocess.run(
        [python, "-c", HEAD + program + FOOT, str(world.port)],
        capture_output=True, text=True, timeout=120, env=ros.clean_environment(),
    )  # fmt: skip
    lines = [line for line in done.stdout.splitlines() if line.startswith("SAID ")]
    assert lines, done.stderr[-3000:]
    said: dict[str, Any] = json.loads(lines[0][5:])
    return said


TOPICS = """
said['kept'] = once('/kept', 'std_msgs/String')['data']
said['scan'] = once('/scan', 'sensor_msgs/LaserScan', throttle_rate=10, queue_length=2)['ranges']
said['picture'] = once('/picture', 'sensor_msgs/Image')['data']
heard = []
ear = roslibpy.Topic(ros, '/heard', 'std_msgs/String')
ear.subscribe(lambda m: heard.append(m['data']))
mouth = roslibpy.Topic(ros, '/to_robot', 'std_msgs/String')
mouth.advertise()
def talked():
    mouth.publish(roslibpy.Message({'data': 'from Python'}))
    return 'from Python!' in heard
wait_until(talked)
said['heard'] = True
stamped = roslibpy.Topic(ros, '/stamped', 'geometry_msgs/PointStamped', latch=True)
stamped.publish({'header': roslibpy.Header(seq=0, stamp=roslibpy.Time(5, 6), frame_id='map'), 'point': {'x': 1, 'y': 2.5}})
wait_until(lambda: ros.get_param('/seen_stamped'))
"""


def test_topics(web_world: World) -> None:
    """Latched ones, numbers that JSON has not, what it publishes, stamps. (It reads neither png nor cbor.)"""
    web_world.node.params["/seen_stamped"] = False

    def seen(message: Any) -> None:
        got.append(message)
        web_world.node.params["/seen_stamped"] = True

    got: list[Any] = []
    with web_world.node.subscriber("/stamped", message_class("geometry_msgs/PointStamped"), seen):
        said = run(web_world, TOPICS)
    assert said["kept"] == "kept äöü 地图"
    assert said["scan"] == [0.5, None, None, 2.0]
    assert said["picture"] == "AAECAwQFBgcICQoLDA0ODxAR"
    assert said["heard"]
    stamp = got[0].header.stamp
    assert (stamp.secs, stamp.nsecs, got[0].header.frame_id, got[0].point.y) == (5, 6, "map", 2.5)


SERVICES = """
lamp = roslibpy.Service(ros, '/lamp', 'std_srvs/SetBool')
said['on'] = dict(lamp.call({'data': True}, timeout=20))
said['broken'] = failing(lambda: lamp.call({'data': False}, timeout=20))
said['nobody'] = failing(lambda: roslibpy.Service(ros, '/nobody', 'std_srvs/SetBool').call({}, timeout=20))
def answer(request, response):
    response['success'], response['message'] = request['data'], 'by Python'
    return True
browser = roslibpy.Service(ros, '/browser', 'std_srvs/SetBool')
browser.advertise(answer)
wait_until(lambda: '/browser' in ros.get_services())
said['round'] = dict(roslibpy.Service(ros, '/ask', 'std_srvs/Trigger').call({}, timeout=20))
browser.unadvertise()
wait_until(lambda: '/browser' not in ros.get_services())
"""


def test_services(web_world: World) -> None:
    """It calls rospy, is told why that failed, and provides one that rospy calls."""
    said = run(web_world, SERVICES)
    assert said["on"] == {"success": True, "message": "on"}
    assert said["broken"][0] is said["nobody"][0] is False
    assert "the lamp is broken" in said["broken"][1]
    assert said["round"] == {"success": True, "message": "by Python"}


QUESTIONS = """
said['time'] = ros.get_time()['secs']
said['topics'] = ros.get_topics()
said['type'] = ros.get_topic_type('/chatter')
said['for type'] = ros.get_topics_for_type('sensor_msgs/Image')
said['services'] = ros.get_services()
said['service type'] = ros.get_service_type('/lamp')
said['services for type'] = ros.get_services_for_type('std_srvs/Trigger')
said['request'] = ros.get_service_request_details('std_srvs/SetBool')
said['response'] = ros.get_service_response_details('std_srvs/SetBool')
said['details'] = ros.get_message_details('geometry_msgs/Twist')
said['params'] = ros.get_params()
said['nodes'] = ros.get_nodes()
said['node'] = ros.get_node_details('/robot')
param = roslibpy.Param(ros, '/from_python')
param.set([1, {'a': 'ö'}])
said['set'] = param.get()
param.delete()
said['deleted'] = param.get()
said['speed'] = ros.get_param('/speed')
"""


def test_questions_and_parameters(web_world: World) -> None:
    """Everything it asks /rosapi."""
    said = run(web_world, QUESTIONS)
    assert said["time"] > 1_000_000_000
    assert {"/chatter", "/scan", "/cmd_vel"} <= set(said["topics"])
    assert (said["type"], said["for type"]) == ("std_msgs/String", ["/picture"])
    assert {"/lamp", "/rosapi/nodes"} <= set(said["services"])
    assert (said["service type"], said["services for type"]) == ("std_srvs/SetBool", ["/ask"])
    assert said["request"]["typedefs"][0]["fieldtypes"] == ["bool"]
    assert said["response"]["typedefs"][0]["fieldtypes"] == ["bool", "string"]
    assert [d["type"] for d in said["details"]["typedefs"]] == [
        "geometry_msgs/Twist",
        "geometry_msgs/Vector3",
    ]
    assert "/robot/size" in said["params"]
    assert "/robot" in said["nodes"]
    assert "/lamp" in said["node"]["services"]
    assert said["set"] == [1, {"a": "ö"}]
    assert said["deleted"] is None
    assert said["speed"] == 0.5


ACTIONS = """
client = actionlib.ActionClient(ros, '/walk', 'actionlib/TestAction')
time.sleep(1.0)  # it does not wait until the server has seen its publisher
def walk(goal):
    it = actionlib.Goal(client, roslibpy.Message({'goal': goal}))
    seen = []
    it.on('feedback', lambda f: seen.append(f['feedback']))
    it.on('feedback', lambda f: goal < 0 and it.cancel())
    it.send()
    result = it.wait(20)['result']
    wait_until(lambda: seen)  # of another topic, and thus another connection: it may come after the result
    return [result, it.status['status'], it.status['text'], seen[:1]]
said['walked'], said['too far'], said['cancelled'] = walk(5), walk(500), walk(-3)
client.dispose()
"""


def test_actions(web_world: World) -> None:
    """Goals that succeed, fail and are cancelled."""
    said = run(web_world, ACTIONS)
    assert said["walked"] == [10, 3, "well", [5]]
    assert said["too far"] == [0, 4, "too far", [500]]
    result, status, _, feedback = said["cancelled"]
    assert (result, feedback) == (-1, [-3])
    assert status in (2, 6)  # PREEMPTED, unless the status topic, which it reads as well, came later


@pytest.mark.parametrize("transport", ["twisted", "asyncio"])
def test_each_transport_connects(web_world: World, transport: str) -> None:
    """Both of its WebSocket implementations."""
    python = web_peers.python_with("roslibpy")
    code = (
        "import roslibpy, sys\n"
        f"ros = roslibpy.Ros(host='127.0.0.1', port=int(sys.argv[1]), transport='{transport}')\n"
        "ros.run(timeout=20); print('/chatter' in ros.get_topics(), flush=True); ros.terminate()\n"
    )
    done = subprocess.run(
        [python, "-c", code, str(web_world.port)],
        capture_output=True, text=True, timeout=60, env=ros.clean_environment(),
    )  # fmt: skip
    assert done.stdout.strip() == "True", done.stderr[-2000:]


OURS_ALONE = """
import roslibpy.tf
client = roslibpy.tf.TFClient(ros, fixed_frame='map', angular_threshold=0.01, translation_threshold=0.01, rate=20)
done = threading.Event()
client.subscribe('base_link', lambda tf: (said.update(tf=tf), done.set()))
assert done.wait(20)
from roslibpy.core import ActionClient, Goal
walk = ActionClient(ros, '/walk', 'actionlib/action/Test')
results, failures = [], []
goal = walk.send_goal(Goal({'goal': 5}), results.append, lambda f: None, failures.append)
walk.wait_goal(goal, 20)
goal = walk.send_goal(Goal({'goal': -3}), results.append, lambda f: walk.cancel_goal(goal), failures.append)
walk.wait_goal(goal, 20)
said['actions'] = [[dict(r) for r in results], [str(f) for f in failures]]
"""


def test_tf_and_the_newer_actions(web_world: World) -> None:
    """What the original has not: transforms by /republish_tfs, and the action operations."""
    if web_world.bridge != "ours":
        pytest.skip("the original has no such operation, and no tf2_web_republisher")
    said = run(web_world, OURS_ALONE)
    assert said["tf"]["translation"]["x"] == 1.5
    results, failures = said["actions"]
    assert [(result["values"], result["status"]) for result in results] == [
        ({"result": 10}, "GoalStatus.SUCCEEDED"),
        ({"result": -1}, "GoalStatus.CANCELED"),  # by its feedback
    ]
    assert failures == []
