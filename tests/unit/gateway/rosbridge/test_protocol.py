"""rosbridge's protocol: each operation becomes its effect, and whatever is wrong a sentence."""

from __future__ import annotations

import json
from typing import Any

import pytest

from rosproto.gateway import GatewayLimits
from rosproto.gateway.rosbridge import png
from rosproto.gateway.rosbridge.operations import (
    OPERATIONS,
    ActionFeedback,
    ActionResult,
    Advertise,
    AdvertiseAction,
    AdvertiseService,
    Auth,
    CallService,
    CancelActionGoal,
    Close,
    LongMessage,
    Publish,
    Reply,
    Request,
    SendActionGoal,
    ServiceResponse,
    SetLevel,
    Subscribe,
    Unadvertise,
    UnadvertiseAction,
    UnadvertiseService,
    Unsubscribe,
)
from rosproto.gateway.rosbridge.png import publish_png
from rosproto.gateway.rosbridge.protocol import Protocol, publish_text
from tests.test_layers import IMPURE_MODULES, ROOT, imports_of

LIMITS = GatewayLimits(message_bytes=100_000, nesting=10, text_length=50)

CONVERSATION: list[tuple[dict[str, Any], Request]] = [
    (
        {"op": "advertise", "id": "a", "topic": "/t", "type": "std_msgs/String"},
        Advertise("a", "/t", "std_msgs/String"),
    ),
    (
        {"op": "advertise", "topic": "/t", "type": "std_msgs/String", "latch": True, "queue_size": 5},
        Advertise(None, "/t", "std_msgs/String", True, 5),
    ),
    ({"op": "unadvertise", "topic": "/t", "id": 7}, Unadvertise(7, "/t")),
    ({"op": "publish", "topic": "/t", "msg": {"data": "x"}}, Publish(None, "/t", {"data": "x"})),
    ({"op": "publish", "topic": "/t"}, Publish(None, "/t", {})),
    ({"op": "publish", "topic": "/t", "msg": None}, Publish(None, "/t", None)),
    ({"op": "publish", "topic": "/t", "msg": {}, "latch": False}, Publish(None, "/t", {})),
    ({"op": "subscribe", "topic": "/t"}, Subscribe(None, "/t")),
    (
        {
            "op": "subscribe",
            "id": "subscribe:/t:1",
            "topic": "/t",
            "type": "a/B",
            "compression": "cbor-raw",
            "throttle_rate": 100.0,
            "queue_length": 3,
            "fragment_size": 1000,
        },
        Subscribe("subscribe:/t:1", "/t", "a/B", 100, 3, 1000, "cbor-raw"),
    ),
    ({"op": "subscribe", "topic": "/t", "type": None, "fragment_size": None}, Subscribe(None, "/t")),
    ({"op": "unsubscribe", "topic": "/t"}, Unsubscribe(None, "/t")),
    ({"op": "call_service", "service": "/s"}, CallService(None, "/s", "/s")),
    (
        {"op": "call_service", "id": "c", "service": "/s", "args": {"a": 1}, "type": "a/S", "timeout": 2},
        CallService("c", "/s", "/s", {"a": 1}, timeout=2.0),
    ),
    ({"op": "call_service", "id": 1.5, "service": "/s", "timeout": "5"}, CallService(1.5, "/s", "/s")),
    ({"op": "call_service", "service": "/s#33", "args": [1]}, CallService("33", "/s", "/s#33", [1])),
    ({"op": "call_service", "id": "c", "service": "/s#33"}, CallService("c", "/s", "/s#33")),
    ({"op": "call_service", "service": "/s", "timeout": -1}, CallService(None, "/s", "/s")),
    ({"op": "advertise_service", "service": "/s", "type": "a/S"}, AdvertiseService(None, "/s", "a/S")),
    ({"op": "unadvertise_service", "service": "/s"}, UnadvertiseService(None, "/s")),
    (
        {"op": "service_response", "id": "r", "service": "/s", "values": {"sum": 3}, "result": True},
        ServiceResponse("r", "/s", {"sum": 3}, True),
    ),
    (
        {"op": "service_response", "id": "r", "service": "/s", "result": False},
        ServiceResponse("r", "/s", None, False),
    ),
    ({"op": "service_response", "id": "r", "service": "/s"}, ServiceResponse("r", "/s", None, False)),
    (
        {
            "op": "send_action_goal",
            "id": "g",
            "action": "/a",
            "action_type": "p/A",
            "args": {"x": 1},
            "feedback": True,
        },
        SendActionGoal("g", "/a", "/a", "p/A", {"x": 1}, True),
    ),
    ({"op": "cancel_action_goal", "id": "g", "action": "/a"}, CancelActionGoal("g", "/a")),
    ({"op": "advertise_action", "action": "/a", "type": "a/B"}, AdvertiseAction(None, "/a", "a/B")),
    ({"op": "unadvertise_action", "action": "/a"}, UnadvertiseAction(None, "/a")),
    (
        {"op": "action_feedback", "id": "g", "action": "/a", "values": {"x": 1}},
        ActionFeedback("g", "/a", {"x": 1}),
    ),
    (
        {"op": "action_result", "id": "g", "action": "/a", "values": {}, "status": 4, "result": True},
        ActionResult("g", "/a", {}, 4, True),
    ),
    (
        {"op": "action_result", "id": "g", "action": "/a", "status": 6, "result": False},
        ActionResult("g", "/a", None, 6, False),
    ),
    (
        {
            "op": "auth",
            "mac": "m",
            "client": "1.2.3.4",
            "dest": "d",
            "rand": "r",
            "t": 5,
            "level": "l",
            "end": 9.5,
        },
        Auth(None, "m", "1.2.3.4", "d", "r", 5.0, "l", 9.5),
    ),
    ({"op": "auth", "mac": "token"}, Auth(None, "token")),
    ({"op": "set_level", "level": "warn", "id": "l"}, SetLevel("l", "warning")),
]


def status_of(requests: list[Request]) -> dict[str, Any]:
    """The one status that was answered."""
    assert len(requests) == 1, requests
    assert isinstance(requests[0], Reply)
    (payload,) = requests[0].payloads
    answer: dict[str, Any] = json.loads(payload)
    assert answer["op"] == "status"
    assert answer["level"] == "error"
    return answer


ANSWERS = {"call_service": ("service_response", "service"), "send_action_goal": ("action_result", "action")}


def answer_of(message: Any, limits: GatewayLimits = LIMITS) -> dict[str, Any]:
    """What answers a wrong message, as a status; a call and a goal have an answer of their own, and no status."""
    protocol = Protocol(limits)
    requests = protocol.receive(message if isinstance(message, (str, bytes)) else json.dumps(message))
    op = message.get("op") if isinstance(message, dict) else None
    if op in ("service_response", "action_result") and message.get("id") is not None:
        ended = requests.pop()  # the call or goal, whose caller would wait
        assert isinstance(ended, (ServiceResponse, ActionResult))
        assert (ended.id, ended.result) == (message["id"], False)
        assert str(ended.values).startswith("the client's answer is not valid: field ")
    if not (isinstance(op, str) and op in ANSWERS):
        return status_of(requests)
    assert len(requests) == 1, requests
    assert isinstance(requests[0], Reply)
    (payload,) = requests[0].payloads
    answer: dict[str, Any] = json.loads(payload)
    assert answer.pop("op") == ANSWERS[op][0]
    assert answer.pop("result") is False
    assert answer.pop("status", 0) == 0
    return {"msg": answer.pop("values"), **answer}


def refused(message: Any, limits: GatewayLimits = LIMITS) -> str:
    """The sentence that answers a wrong message."""
    text = answer_of(message, limits)["msg"]
    assert isinstance(text, str)
    return text


@pytest.mark.parametrize(("message", "request_"), CONVERSATION, ids=lambda value: str(value)[:60])
def test_operations(message: dict[str, Any], request_: Request) -> None:
    """Operations of roslib, roslibpy and ros-mcp are read, as text and as bytes."""
    assert Protocol(LIMITS).receive(json.dumps(message)) == [request_]
    assert Protocol(LIMITS).receive(json.dumps(message).encode()) == [request_]


def test_every_operation_is_shown() -> None:
    """No row of the table is without a conversation above."""
    assert {message["op"] for message, _ in CONVERSATION} == set(OPERATIONS)


@pytest.mark.promise("nothing it sends raises an exception outside the protocol code")
@pytest.mark.parametrize("op", sorted(OPERATIONS))
def test_a_required_field_is_missed(op: str) -> None:
    """Each required field left out, null, of a wrong kind, too long: named in the answer, with the message's id."""
    whole = next(message for message, _ in CONVERSATION if message["op"] == op)
    for field in OPERATIONS[op].fields:
        wrong: list[Any] = [[{"deep": [1]}], 10**400, "x" * 1000, -5, "", True, 1.5]
        if field.required:
            wrong.append(None)
            without = {name: value for name, value in whole.items() if name != field.name}
            assert f"field {field.name} is missing" in refused(without)
        for value in wrong:
            message = {**whole, field.name: value, "id": "the id"}
            if isinstance(Protocol(LIMITS).receive(json.dumps(message))[0], Reply):
                answer = answer_of(message)
                assert answer["id"] == "the id"
                assert answer["msg"].startswith(f"{op}: field {field.name} ")
                assert len(answer["msg"]) < 300


@pytest.mark.promise("nothing it sends raises an exception outside the protocol code")
@pytest.mark.parametrize(
    ("message", "sentence"),
    [
        ("", "the message is empty; expected a JSON object with an op"),
        ("   ", "the message is empty; expected a JSON object with an op"),
        ("[]", "the message is JSON, but an array; expected an object with an op"),
        ("3", "the message is JSON, but a number; expected an object with an op"),
        ("null", "the message is JSON, but null; expected an object with an op"),
        ('{"op": ', "the message is not JSON: Expecting value at character 7"),
        (b"\xff{}", "the message is not UTF-8 text: invalid start byte at byte 0"),
        ("9" * 5000, "the message is not JSON: a number has too many digits"),
        ("{}", "the message has no op; expected one of advertise, "),
        ({"op": 5}, "the operation a number is unknown; expected one of advertise, "),
        ({"op": ["publish"]}, "the operation an array is unknown; expected one of advertise, "),
        ({"op": "subscribe\n\x1b[2J"}, "the operation 'subscribe"),
        ({"receiver": "/t"}, "this is a message of rosbridge v1; expected v2, whose messages have an op"),
        ({"op": "publish", "topic": ""}, "publish: field topic is ''; expected a text of 1 to 50 characters"),
        (
            {"op": "subscribe", "topic": "/t", "compression": "zip"},
            "subscribe: field compression is 'zip'; expected",
        ),
        (
            {"op": "subscribe", "topic": "/t", "throttle_rate": 1.5},
            "subscribe: field throttle_rate is 1.5; expected a",
        ),
        (
            {"op": "subscribe", "topic": "/t", "fragment_size": 0},
            "subscribe: field fragment_size is 0; expected a",
        ),
        (
            {"op": "subscribe", "topic": "/t", "queue_length": True},
            "subscribe: field queue_length is true; expected",
        ),
        (
            {"op": "action_result", "action": "/a", "status": 7},
            "action_result: field status is 7; expected a status of a goal, from 0 to 6",
        ),
        (
            {"op": "set_level", "level": "loud"},
            "set_level: field level is 'loud'; expected one of none, error, ",
        ),
        (
            {"op": "publish", "topic": "/t", "id": {}},
            "publish: field id is an object of 0; expected a text of at most",
        ),
        ({"op": "publish", "topic": "/t", "id": "x" * 51}, "publish: field id is 'xxxx"),
        (
            {"op": "call_service", "service": "/s", "args": "x"},
            "call_service: field args is 'x'; expected an object",
        ),
    ],
)
def test_wrong_messages(message: Any, sentence: str) -> None:
    """The sentence has the error and the expectation, without the client's control characters."""
    text = refused(message)
    assert text.startswith(sentence)
    assert "\x1b" not in text


@pytest.mark.parametrize("op", sorted(ANSWERS))
def test_a_wrong_call_or_goal_is_answered_as_one_that_fails(op: str) -> None:
    """A wrong call or goal gets its answer, with its id if that is a text or a number."""
    name = ANSWERS[op][1]
    asked = {"op": op, name: "/s", "action_type": "p/A", "args": "x"}
    for id in ("a", 7, 1.5):
        assert answer_of({**asked, "id": id}) == {"msg": refused({**asked, "id": id}), name: "/s", "id": id}
    for id in ("x" * 51, {}, float("nan"), float("inf"), None):
        assert answer_of({**asked, "id": id}).keys() == {"msg", name}
    assert answer_of({**asked, name: "/s#33"})["id"] == "33"
    assert answer_of({**asked, name: 5})[name] == ""
    silent = Protocol(LIMITS)
    silent.receive('{"op": "set_level", "level": "none"}')
    assert isinstance(silent.receive(json.dumps(asked))[0], Reply)


def test_several_messages_at_once() -> None:
    """Objects behind one another are each done, as in the original; the rest of a broken one is not kept."""
    protocol = Protocol(LIMITS)
    one = '{"op": "subscribe", "topic": "/a"}'
    assert protocol.receive(f"{one}\n {one}") == [Subscribe(None, "/a")] * 2
    status_of(protocol.receive(one[:10]))
    status_of(protocol.receive(one[10:]))
    assert protocol.receive(one) == [Subscribe(None, "/a")]
    assert "more than 100 values in a row" in refused("{}" * 101)


@pytest.mark.promise("A message is bounded in bytes, in nesting, and in its values and keys")
def test_nesting_is_bounded() -> None:
    """As deep as allowed is taken; deeper, up to what breaks a JSON reader, is refused."""

    def deep(levels: int) -> str:
        return '{"op": "publish", "topic": "/t", "msg": ' + "[" * levels + "]" * levels + "}"

    assert isinstance(Protocol(LIMITS).receive(deep(9))[0], Publish)
    for levels in (10, 11, 400, 40_000):
        assert refused(deep(levels)) == "the message has more than 10 arrays and objects inside one another"
    wide = {"op": "publish", "topic": "/t", "msg": [{"a": [1]}] * 1000}
    assert isinstance(Protocol(LIMITS).receive(json.dumps(wide))[0], Publish)


@pytest.mark.promise("A message is bounded in bytes, in nesting, and in its values and keys")
def test_size_is_bounded() -> None:
    """A message beyond the limit ends the connection, and nothing more is read."""
    protocol = Protocol(LIMITS)
    assert protocol.receive(b"x" * 100_001) == [Close(1009, "a message may have 100000 bytes")]
    assert protocol.closed
    assert protocol.receive('{"op": "subscribe", "topic": "/t"}') == []


@pytest.mark.promise("A message is bounded in bytes, in nesting, and in its values and keys")
def test_values_are_bounded() -> None:
    """Refused before they are decoded, whatever they are; also when they come in fragments."""
    limits = GatewayLimits()
    for one in ("0,", "[],", '{"a":1},', '"x",'):
        text = '{"op":"publish","topic":"/t","msg":[' + one * 100_000 + "0]}"
        assert "values and keys, and at most 100000 are accepted" in refused(text, limits)
        assert "--message-bytes" in refused(text, limits)
    few = '{"op":"publish","topic":"/t","msg":[0,0,0,0,0]}'
    assert "at most 5 are accepted" in refused(few, GatewayLimits(message_values=5))


@pytest.mark.promise("of all clients' long messages one is decoded at a time")
def test_what_takes_long_is_left_to_a_rest() -> None:
    """In its place among the others; a short message, and a fragment, is read at once."""
    protocol = Protocol(LIMITS)
    short = '{"op": "subscribe", "topic": "/a"}'
    assert protocol.receive(short, at_once=True) == [Subscribe(None, "/a")]
    assert protocol.receive(short.encode(), at_once=True) == [Subscribe(None, "/a")]
    for long in (
        '{"op": "publish", "topic": "/t", "msg": {"data": "' + "x" * 20_000 + '"}}',
        '{"op": "publish", "topic": "/t", "msg": [' + "0," * 3000 + "0]}",
        ('{"op": "publish", "topic": "/t", "msg": "' + "x" * 20_000 + '"}').encode(),
    ):
        (rest,) = protocol.receive(long, at_once=True)
        assert isinstance(rest, LongMessage)
        assert isinstance(rest.read()[0], Publish)
    picture = publish_png(short)
    first, rest, last = protocol.receive(short + picture + short, at_once=True)
    assert first == last == Subscribe(None, "/a")
    assert isinstance(rest, LongMessage)
    assert rest.read() == [Subscribe(None, "/a")]


@pytest.mark.promise("of all clients' long messages one is decoded at a time")
def test_fragments_of_a_long_message_are_left_to_a_rest() -> None:
    """The last one is short; what they hold together is not."""
    protocol = Protocol(LIMITS)
    text = '{"op": "publish", "topic": "/t", "msg": [' + "0," * 3000 + "0]}"
    pieces = [text[at : at + 500] for at in range(0, len(text), 500)]
    requests = [
        request
        for num, data in enumerate(pieces)
        for request in protocol.receive(
            json.dumps({"op": "fragment", "id": "f", "data": data, "num": num, "total": len(pieces)}),
            at_once=True,
        )
    ]
    (rest,) = requests
    assert isinstance(rest, LongMessage)
    assert isinstance(rest.read()[0], Publish)


def test_levels_of_status() -> None:
    """Errors at first; each level includes those before it; `none` sends nothing."""
    protocol = Protocol(LIMITS)
    wanted = {"none": 0, "error": 1, "warning": 2, "info": 3}
    told = [level for level in ("error", "warning", "info") if protocol.status(level, "x")]  # type: ignore[arg-type]
    assert told == ["error"]
    for level, count in wanted.items():
        protocol.receive(json.dumps({"op": "set_level", "level": level}))
        told = [one for one in ("error", "warning", "info") if protocol.status(one, "x")]  # type: ignore[arg-type]
        assert len(told) == count
    protocol.receive('{"op": "set_level", "level": "none"}')
    assert protocol.receive("nonsense") == []


def test_status_has_the_id() -> None:
    """A status has the id of its message, of the same kind."""
    for given in ("x", 0, 7):
        (payload,) = Protocol(LIMITS).status("error", "a sentence", given)
        assert json.loads(payload) == {"op": "status", "level": "error", "msg": "a sentence", "id": given}
    (payload,) = Protocol(LIMITS).status("error", "a sentence")
    assert "id" not in json.loads(payload)


def test_fragments_of_a_client() -> None:
    """Fragments are joined in any order; an error in the joined message is reported."""
    message = {"op": "publish", "topic": "/t", "msg": {"data": "x" * 100}}
    text = json.dumps(message)
    pieces = [text[start : start + 40] for start in range(0, len(text), 40)]
    parts = [
        {"op": "fragment", "id": "f", "data": piece, "num": num, "total": len(pieces)}
        for num, piece in enumerate(pieces)
    ]
    for order in (parts, parts[::-1]):
        protocol = Protocol(LIMITS)
        requests = [request for part in order for request in protocol.receive(json.dumps(part))]
        assert requests == [Publish(None, "/t", message["msg"])]
    assert refused({**parts[0], "num": 99}).startswith("fragment: field num of a fragment must be")
    assert refused({"op": "fragment", "data": "x"}).startswith("fragment: field id of a fragment is missing")
    assert "not JSON" in refused({"op": "fragment", "id": "f", "num": 0, "total": 1, "data": "nonsense"})


def test_pictures_of_a_client() -> None:
    """A picture holds a message; a picture of a picture of a picture is refused."""
    text = '{"op": "subscribe", "topic": "/t"}'
    for wrapped in range(1, 4):
        text = json.dumps({"op": "png", "data": png.pack(text)})
        if wrapped <= 2:
            assert Protocol(LIMITS).receive(text) == [Subscribe(None, "/t")]
        else:
            assert refused(text) == "png: too many fragments and pictures inside one another"
    assert refused({"op": "png"}).startswith("png: field data is missing")
    assert refused({"op": "png", "data": "AAAA"}).startswith("png: not a PNG picture in base64: ")


@pytest.mark.promise("The size of a picture is checked before it is unpacked")
def test_pictures_in_one_message_are_bounded() -> None:
    """Each costs far more than its bytes: the fifth, also inside another one, is refused."""
    one = json.dumps({"op": "png", "data": png.pack('{"op": "subscribe", "topic": "/t"}')})
    requests = Protocol(LIMITS).receive(one * 6)
    assert [type(request) for request in requests] == [Subscribe] * 4 + [Reply] * 2
    inside = json.dumps({"op": "png", "data": png.pack(one * 4)})
    assert [type(request) for request in Protocol(LIMITS).receive(inside)] == [Subscribe] * 3 + [Reply]


def test_blanks_are_passed_over() -> None:
    """Around messages and between them; those that JSON does not know are refused."""
    one = '{"op": "subscribe", "topic": "/t"}'
    assert Protocol(LIMITS).receive(f" \r\n\t{one}{' ' * 50_000}{one}\n") == [Subscribe(None, "/t")] * 2
    assert "not JSON" in refused(f"\u2003{one}")


def test_a_picture_in_fragments() -> None:
    """The operation png with num and total: its data is cut, not its text."""
    data = png.pack('{"op": "subscribe", "topic": "/t"}')
    protocol = Protocol(LIMITS)
    first, second = (
        json.dumps({"op": "png", "id": "p", "data": part, "num": num, "total": 2})
        for num, part in enumerate((data[:30], data[30:]))
    )
    assert protocol.receive(first) == []
    assert protocol.receive(second) == [Subscribe(None, "/t")]


def test_answers() -> None:
    """Calls, goals and their ends have the fields that clients read."""
    protocol = Protocol(LIMITS)
    (call,) = protocol.receive('{"op": "call_service", "id": "c", "service": "/s#1"}')
    (goal,) = protocol.receive('{"op": "send_action_goal", "id": 5, "action": "/a", "action_type": "p/A"}')
    assert isinstance(call, CallService)
    assert isinstance(goal, SendActionGoal)
    answers = [
        protocol.service_response(call, '{"sum": 3}'),
        protocol.service_failure(call, "no \x07 such service"),
        protocol.call_service("id 1", "/mine", "{}"),
        protocol.action_feedback(goal, '{"n": 1}'),
        protocol.action_result(goal, '{"n": 2}', 4),
        protocol.action_failure(goal, "gone"),
    ]
    assert [json.loads(payload) for (payload,) in answers] == [
        {"op": "service_response", "service": "/s#1", "values": {"sum": 3}, "result": True, "id": "c"},
        {
            "op": "service_response",
            "service": "/s#1",
            "values": "no \\x07 such service",
            "result": False,
            "id": "c",
        },
        {"op": "call_service", "id": "id 1", "service": "/mine", "args": {}},
        {"op": "action_feedback", "action": "/a", "values": {"n": 1}, "id": 5},
        {"op": "action_result", "action": "/a", "values": {"n": 2}, "status": 4, "result": True, "id": 5},
        {"op": "action_result", "action": "/a", "values": "gone", "status": 0, "result": False, "id": 5},
    ]


def test_what_is_sent_in_fragments() -> None:
    """Texts longer than the client wants are cut; the fragments' ids are ones that roslib takes for ids."""
    protocol = Protocol(LIMITS)
    text = publish_text("/t", json.dumps({"data": "x" * 100}))
    assert protocol.split(text, None) == (text,)
    assert protocol.split(text, len(text)) == (text,)
    sent = [[json.loads(payload) for payload in protocol.split(text, 50)] for _ in range(2)]
    for fragments in sent:
        assert "".join(part["data"] for part in fragments) == text
        assert [part["num"] for part in fragments] == list(range(3))
        assert {part["total"] for part in fragments} == {3}
    assert sent[0][0]["id"] != sent[1][0]["id"]
    (call,) = protocol.receive('{"op": "call_service", "id": "c", "service": "/s", "fragment_size": 20}')
    assert isinstance(call, CallService)
    assert {json.loads(p)["id"] for p in protocol.service_response(call, '{"data": "0123456789"}')} == {"c"}
    (call,) = protocol.receive('{"op": "call_service", "id": 0, "service": "/s", "fragment_size": 20}')
    assert isinstance(call, CallService)
    ids = {json.loads(payload)["id"] for payload in protocol.service_response(call, '{"data": "0123456789"}')}
    assert len(ids) == 1
    assert all(ids)


@pytest.mark.parametrize(
    "name",
    [
        *"rosbridge.action_mapping rosbridge.cbor rosbridge.fragments rosbridge.operations rosbridge.png".split(),
        *"rosbridge.protocol json_writer values foxglove.messages handshake".split(),
    ],
)
def test_the_protocol_knows_no_sockets_threads_or_clocks(name: str) -> None:
    """The protocol imports no sockets, threads or clocks."""
    module = f"rosproto.gateway.{name}"
    path = ROOT.joinpath(*module.split(".")).with_suffix(".py")
    assert not {found.partition(".")[0] for found, _ in imports_of(module, path)} & IMPURE_MODULES
