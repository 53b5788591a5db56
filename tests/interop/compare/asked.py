"""Answers to the cases of a comparison, by ROS's own Python packages: run by Debian's Python, or by `rosproto run`.

Each line of standard input is a JSON list [kind, case], each line of standard output the answer. What the
packages print is part of the answer. An error is {"error": its type, "says": its text}.
"""

import contextlib
import io
import json
import os
import sys

CHANNEL = os.fdopen(os.dup(1), "w", encoding="utf-8")  # what a package prints goes elsewhere


def plain(value):
    """A value with its types, as JSON has too few of them."""
    if isinstance(value, dict):
        return {"dict": sorted([str(key), plain(item)] for key, item in value.items())}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if hasattr(value, "data") and isinstance(value.data, bytes):
        value = value.data  # xmlrpc.client.Binary
    if isinstance(value, bytes):
        return "bytes " + value.hex()
    return f"{type(value).__name__} {value!r}"


def error_of(error):
    return {"error": type(error).__name__, "says": str(error)[:300]}


def run_main(main, argv):
    """The outcome of a tool's main function: whether it ended well, and what it printed."""
    out, err = io.StringIO(), io.StringIO()
    sys.argv[:] = argv
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            main(argv)
        code = 0
    except SystemExit as end:
        code = end.code or 0
    except Exception as error:
        return {"error": type(error).__name__, "says": (err.getvalue() + str(error))[:300]}
    if code:
        return {"error": "exit", "says": err.getvalue()[:300]}
    return {"out": out.getvalue(), "err": err.getvalue()[:300]}


# -- parameters ----------------------------------------------------------------------------------------------


def rosparam_command(case):
    """Run `rosparam` once for each step, then tell the whole tree."""
    import rosparam

    os.environ["ROS_NAMESPACE"] = case["namespace"]
    server = rosparam.get_param_server()
    server.setParam("/", case["before"])
    answers = []
    for step in case["steps"]:
        sys.stdin = io.StringIO(step["stdin"])
        answer = run_main(rosparam.yamlmain, ["rosparam", *step["words"]])
        answers.append({key: answer[key] for key in ("out", "error") if key in answer})
    return {"steps": answers, "tree": plain(server.getParam("/"))}


def rosparam_functions(case):
    """Call functions of the module, then tell the whole tree."""
    import rosparam

    os.environ["ROS_NAMESPACE"] = case["namespace"]
    sys.argv[:] = ["program"]
    server = rosparam.get_param_server()
    server.setParam("/", case["before"])
    answers = []
    for name, arguments in case["steps"]:
        try:
            if name == "load":
                for values, space in rosparam.load_str(arguments[0], "file", default_namespace=arguments[1]):
                    rosparam.upload_params(space, values)
                answers.append(None)
            else:
                answers.append(plain(getattr(rosparam, name)(*arguments)))
        except Exception as error:
            answers.append({"error": type(error).__name__})
    return {"steps": answers, "tree": plain(server.getParam("/"))}


# -- definitions ---------------------------------------------------------------------------------------------


def definition(case):
    """genmsg's reading of a definition."""
    from genmsg import MsgContext, gentools
    from genmsg.msg_loader import load_depends, load_msg_from_string, load_srv_from_string

    context = MsgContext.create_default()
    main = None
    for name, text in case["types"].items():
        if name == case["main"]:
            load = load_srv_from_string if case["kind"] == "srv" else load_msg_from_string
            main = load(context, text, name)
        else:
            load_msg_from_string(context, text, name)
    load_depends(context, main, {})
    parts = [main] if case["kind"] == "msg" else [main.request, main.response]
    return {
        "md5": gentools.compute_md5(context, main),
        "full_text": [gentools.compute_full_text(context, part) for part in parts],
        "fields": [[list(field) for field in part.fields()] for part in parts],
        "constants": [[[c.type, c.name, c.val_text, repr(c.val)] for c in part.constants] for part in parts],
        "header": [part.has_header() for part in parts],
    }


def full_text(case):
    """The classes of a text with sections, and what they make of some bytes."""
    from genpy.dynamic import generate_dynamic

    classes = generate_dynamic(case["main"], case["text"])
    found = {
        name: [cls._md5sum, list(cls.__slots__), list(cls._slot_types)]
        for name, cls in sorted(classes.items())
    }
    message = classes[case["main"]]()
    return {"classes": found, "read": _read(message, case["bytes"])}


def _read(message, data):
    try:
        message.deserialize(bytes.fromhex(data))
        buffer = io.BytesIO()
        message.serialize(buffer)
    except Exception as error:
        return {"error": type(error).__name__}
    return {"text": str(message), "bytes": buffer.getvalue().hex()}


# -- values --------------------------------------------------------------------------------------------------


def _message_class(name):
    from genpy.message import get_message_class

    return get_message_class(name)


def _fill(message, words):
    import yaml
    from genpy import Time
    from genpy.message import fill_message_args
    from std_msgs.msg import Header

    values = [yaml.safe_load(word or "''") for word in words]
    now = Time(7, 8)
    fill_message_args(message, values, keys={"now": now, "auto": Header(stamp=now)})
    buffer = io.BytesIO()
    message.serialize(buffer)
    return {"bytes": buffer.getvalue().hex(), "text": str(message)}


def values(case):
    """The message that the words of a command line make."""
    return _fill(_message_class(case["type"])(), case["words"])


def rosservice_command(case):
    import rosservice

    sys.stdin = io.StringIO(case["stdin"])
    answer = run_main(rosservice.rosservicemain, ["rosservice", "call", case["service"], *case["words"]])
    return {key: answer[key] for key in ("out", "error", "says") if key in answer}


def rostopic_echo(case):
    import rostopic

    answer = run_main(rostopic.rostopicmain, ["rostopic", "echo", *case["words"], "-b", case["bag"]])
    if "Traceback" in answer.get("err", ""):
        return {"error": "traceback", "says": answer["err"]}
    return {key: answer[key] for key in ("out", "error", "says") if key in answer}


def rostopic_live(case):
    import rostopic

    answer = run_main(rostopic.rostopicmain, ["rostopic", *case["words"]])
    if "Traceback" in answer.get("err", ""):
        return {"error": "traceback", "says": answer["err"]}
    return {key: answer[key] for key in ("out", "error", "says") if key in answer}


def rostopic_pub(case):
    import rostopic

    rostopic._ONCE_DELAY = 0.0  # 3 s, for subscribers that are still connecting: this node goes on
    return rostopic_live(case)


# -- what programs hand over ---------------------------------------------------------------------------------


def _names():
    import genpy
    import geometry_msgs.msg
    import rospy
    import std_msgs.msg
    import std_srvs.srv

    found = {"genpy": genpy, "rospy": rospy}
    for module in (std_msgs.msg, geometry_msgs.msg, std_srvs.srv):
        found.update({name: getattr(module, name) for name in dir(module) if name[:1].isupper()})
    return found


def _serialized(message):
    from rospy.msg import serialize_message

    buffer = io.BytesIO()
    serialize_message(buffer, 5, message)
    return {"bytes": buffer.getvalue().hex(), "type": message._type, "text": str(message)}


def reply(case):
    """What a service's handler returns, on its way to the wire."""
    from rospy.impl.tcpros_service import convert_return_to_response

    known = _names()
    response = convert_return_to_response(eval(case["value"], known), known[case["class"]])
    return _serialized(response)


def publish(case):
    """What a program passes to publish(), on its way to the wire."""
    from rospy.msg import args_kwds_to_message

    known = _names()
    arguments, keywords = eval(f"(lambda *a, **k: (a, k))({case['value']})", known)
    return _serialized(args_kwds_to_message(known[case["class"]], arguments, keywords))


# -- clouds --------------------------------------------------------------------------------------------------


def cloud(case):
    from sensor_msgs import point_cloud2
    from sensor_msgs.msg import PointCloud2, PointField
    from std_msgs.msg import Header

    fields = [PointField(*field) for field in case["fields"]]
    if "points" in case:
        made = point_cloud2.create_cloud(Header(frame_id="x"), fields, [tuple(p) for p in case["points"]])
    else:
        made = PointCloud2(fields=fields, data=bytes.fromhex(case["data"]), **case["shape"])
    buffer = io.BytesIO()
    made.serialize(buffer)
    read = {"field_names": case["names"], "skip_nans": case["skip_nans"], "uvs": case["uvs"]}
    return {
        "bytes": buffer.getvalue().hex(),
        "points": plain(list(point_cloud2.read_points(made, **read))),
        "named": plain([list(p._asdict().items()) for p in point_cloud2.read_points_list(made, **read)]),
    }


# -- bags ----------------------------------------------------------------------------------------------------


def bag_read(case):
    """The messages of a bag, and what there is to tell about it."""
    import genpy
    import rosbag

    getattr(rosbag.bag, "_message_types", {}).clear()  # by md5sum, of earlier bags
    times = [None if case.get(name) is None else genpy.Time(*case[name]) for name in ("start", "end")]
    with rosbag.Bag(case["bag"], allow_unindexed=case["allow_unindexed"]) as bag:
        facts = {}
        for name in (
            "get_message_count",
            "get_start_time",
            "get_end_time",
            "get_type_and_topic_info",
            "get_compression_info",
        ):
            try:
                facts[name] = plain(getattr(bag, name)())
            except Exception as error:
                facts[name] = {"error": type(error).__name__, "says": str(error)[:300]}
        messages = []
        error = None
        try:
            for topic, raw, t, header in bag.read_messages(
                topics=case.get("topics"),
                start_time=times[0],
                end_time=times[1],
                raw=True,
                return_connection_header=True,
            ):
                head = {k: v.decode() if isinstance(v, bytes) else v for k, v in header.items()}
                messages.append(
                    [topic, raw[0], raw[1].hex(), raw[2], [t.secs, t.nsecs], sorted(head.items())]
                )
        except Exception as problem:
            error = {"error": type(problem).__name__, "says": str(problem)[:300]}
    return {"facts": facts, "messages": messages, "ended": error}


def bag_command(case):
    from rosbag import rosbag_main

    sys.modules["rosbag.bag"]._message_types.clear()
    answer = run_main(rosbag_main.rosbagmain, ["rosbag", *case["words"]])
    return {key: answer[key] for key in ("out", "error", "says") if key in answer}


# -- links ---------------------------------------------------------------------------------------------------

LIVE = {}


def live(case):
    """A node with a latched publisher and a service; its address."""
    import rospy
    from std_msgs.msg import String
    from std_srvs.srv import SetBool

    def answer(request):
        if not request.data:
            raise ValueError("refused")
        return True, "yes"

    if not LIVE:
        rospy.init_node("live", disable_signals=True, disable_rosout=True)
        LIVE["publisher"] = rospy.Publisher("/said", String, latch=True, queue_size=10)
        LIVE["publisher"].publish("latched")
        LIVE["service"] = rospy.Service("/set", SetBool, answer)
    return {"uri": rospy.get_node_uri()}


def live_call(case):
    import rospy
    from std_srvs.srv import SetBool

    try:
        return {"reply": str(rospy.ServiceProxy(case["service"], SetBool)(True))}
    except Exception as error:
        return {"raised": type(error).__name__, "why": {"error": "", "says": str(error)[:300]}}


def live_subscribe(case):
    """Subscribe to a topic that nobody has subscribed to before, until the last message comes."""
    import rospy
    from std_msgs.msg import String

    if "subscriber" in LIVE:
        LIVE["subscriber"].unregister()
    LIVE["number"] = LIVE.get("number", 0) + 1
    LIVE["received"] = received = []
    topic = f"/in{LIVE['number']}"

    def take(message):
        received.append(message.data)
        if message.data == case["last"]:
            LIVE["subscriber"].unregister()

    LIVE["last"] = case["last"]
    LIVE["subscriber"] = rospy.Subscriber(topic, String, take)
    return {"topic": topic}


def live_received(case):
    import time

    count = -1
    while count != len(LIVE["received"]) and LIVE["last"] not in LIVE["received"]:
        count = len(LIVE["received"])
        time.sleep(0.05)
    return {"received": list(LIVE["received"])}


KINDS = {
    "rosparam_command": rosparam_command,
    "rosparam_functions": rosparam_functions,
    "definition": definition,
    "full_text": full_text,
    "values": values,
    "rosservice_command": rosservice_command,
    "rostopic_echo": rostopic_echo,
    "rostopic_live": rostopic_live,
    "rostopic_pub": rostopic_pub,
    "reply": reply,
    "publish": publish,
    "cloud": cloud,
    "live": live,
    "live_call": live_call,
    "live_subscribe": live_subscribe,
    "live_received": live_received,
    "bag_read": bag_read,
    "bag_command": bag_command,
}


def main():
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    orders = sys.stdin
    for line in orders:
        kind, case = json.loads(line)
        try:
            answer = KINDS[kind](case)
        except Exception as error:
            answer = error_of(error)
        CHANNEL.write(json.dumps(answer) + "\n")
        CHANNEL.flush()


if __name__ == "__main__":
    main()
