"""The connection headers of the four roles."""

from __future__ import annotations

import pytest

from rosproto.errors import LocalProtocolError, Md5sumMismatch, RemoteProtocolError
from rosproto.protocol import handshake as hs
from rosproto.protocol.handshake import decode_header, encode_header

STRING = "992ce8a1687cec8c8bd883ec73ca41d1"
TWIST = "9f195f881246fdfa2798d1d3eebca84a"


def over_the_wire(fields: dict[str, str]) -> dict[str, str]:
    return decode_header(encode_header(fields)[4:])


def subscriber(**changes: str) -> dict[str, str]:
    fields = hs.subscriber_header(topic="/t", type_name="std_msgs/String", md5sum=STRING, callerid="/sub")
    fields.update(changes)
    return over_the_wire({key: value for key, value in fields.items() if value != "-"})


def publisher(**changes: str) -> dict[str, str]:
    fields = hs.publisher_header(
        topic="/t",
        type_name="std_msgs/String",
        md5sum=STRING,
        callerid="/pub",
        message_definition="string data\n",
    )
    fields.update(changes)
    return over_the_wire({key: value for key, value in fields.items() if value != "-"})


def check_sub(fields: dict[str, str]) -> None:
    hs.check_subscriber_header(
        fields, topic="/t", type_name="std_msgs/String", md5sum=STRING, peer="1.2.3.4:5"
    )


def check_pub(
    fields: dict[str, str], md5sum: str = STRING, type_name: str = "std_msgs/String"
) -> hs.PublisherReply:
    return hs.check_publisher_header(fields, topic="/t", type_name=type_name, md5sum=md5sum, peer="1.2.3.4:5")


def test_subscriber_and_publisher_agree() -> None:
    check_sub(subscriber())
    assert check_pub(publisher()) == hs.PublisherReply("/pub", "std_msgs/String", STRING, "string data\n")


def test_a_subscriber_may_bring_its_definition() -> None:
    """rospy does; a publisher of another revision reads it. Without one the field is left out, as in roscpp."""
    fields = hs.subscriber_header(
        topic="/t",
        type_name="std_msgs/String",
        md5sum=STRING,
        callerid="/s",
        message_definition="string data\n",
    )
    sent = over_the_wire(fields)
    check_sub(sent)
    assert sent["message_definition"] == "string data\n"
    assert "message_definition" not in subscriber()


def test_a_probe_asks_for_the_reply_header_only() -> None:
    fields = hs.service_client_header(service="/s", md5sum="*", callerid="/n", probe=True)
    assert fields == {"callerid": "/n", "md5sum": "*", "service": "/s", "probe": "1"}
    asked = hs.check_service_client_header(
        over_the_wire(fields), service="/s", type_name="std_srvs/Empty", md5sum=STRING
    )
    assert (asked.probe, asked.persistent) == (True, False)


def test_a_client_of_another_service_is_refused() -> None:
    """The port belongs to somebody else since it looked the service up."""
    fields = hs.service_client_header(service="/other", md5sum="*", callerid="/n")
    with pytest.raises(RemoteProtocolError, match="wants service /other, this link is for /s"):
        hs.check_service_client_header(fields, service="/s", type_name="std_srvs/Empty", md5sum=STRING)


@pytest.mark.promise("rospy's subscriber wants `type` and `md5sum` in the")
def test_each_role_sends_the_fields_peers_require() -> None:
    assert sorted(publisher()) == ["callerid", "latching", "md5sum", "message_definition", "topic", "type"]
    assert sorted(subscriber()) == ["callerid", "md5sum", "tcp_nodelay", "topic", "type"]
    server = hs.service_server_header(service="/s", type_name="p/S", md5sum=STRING, callerid="/n")
    assert (server["request_type"], server["response_type"], server["type"]) == (
        "p/SRequest",
        "p/SResponse",
        "p/S",
    )


def test_roscpps_subscriber_without_definition_is_welcome() -> None:
    check_sub(subscriber(message_definition="-"))
    check_sub(subscriber(type="-"))


@pytest.mark.promise("A subscriber or service client may send `*`")
@pytest.mark.parametrize("md5sum", ["*", STRING])
def test_a_subscribers_wildcards_are_welcome(md5sum: str) -> None:
    check_sub(subscriber(md5sum=md5sum, type="*"))


@pytest.mark.promise("A subscriber or service client may send `*`")
def test_a_wildcard_subscriber_takes_over_the_publishers_type() -> None:
    reply = check_pub(publisher(), "*", "*")
    assert (reply.type_name, reply.md5sum) == ("std_msgs/String", STRING)


def test_a_publisher_of_any_type_and_a_subscriber_of_any_type_agree() -> None:
    """As with rospy's AnyMsg on both sides: relays and taps are built so."""
    fields = hs.publisher_header(topic="/t", type_name="*", md5sum="*", callerid="/p", message_definition="")
    reply = check_pub(over_the_wire(fields), "*", "*")
    assert (reply.type_name, reply.md5sum) == ("*", "*")
    hs.check_subscriber_header(
        subscriber(md5sum="*", type="*"), topic="/t", type_name="*", md5sum="*", peer="1.2.3.4:5"
    )


@pytest.mark.promise("A subscriber or service client may send `*`")
def test_a_publisher_of_any_type_refuses_those_that_want_one() -> None:
    """Nobody can say whether they would understand it; rospy's words."""
    with pytest.raises(Md5sumMismatch, match=r"types do not match: \[std_msgs/String\] vs\. \[\*\]"):
        hs.check_subscriber_header(subscriber(), topic="/t", type_name="*", md5sum="*", peer="1.2.3.4:5")


@pytest.mark.parametrize(("type_name", "md5sum"), [("*", STRING), ("std_msgs/String", "*"), ("", STRING)])
def test_a_publisher_may_not_use_half_a_wildcard(type_name: str, md5sum: str) -> None:
    with pytest.raises(LocalProtocolError, match="real"):
        hs.publisher_header(
            topic="/t", type_name=type_name, md5sum=md5sum, callerid="/p", message_definition=""
        )
    with pytest.raises(RemoteProtocolError, match="which type"):
        check_pub(publisher(md5sum="*", type="-"), "*", "*")


@pytest.mark.promise("rospy's subscriber wants `type` and `md5sum` in the")
@pytest.mark.parametrize("missing", ["topic", "md5sum", "callerid"])
def test_a_publisher_requires_topic_md5sum_and_callerid(missing: str) -> None:
    with pytest.raises(RemoteProtocolError, match=f"without {missing}"):
        check_sub(subscriber(**{missing: "-"}))


def test_an_empty_callerid_is_taken_as_by_rospy() -> None:
    """Of a subscriber and of a service client; the field itself must be there."""
    check_sub({**subscriber(), "callerid": ""})
    fields = {"service": "/s", "md5sum": "*", "callerid": ""}
    hs.check_service_client_header(fields, service="/s", type_name="p/S", md5sum=STRING)


def test_a_subscriber_requires_the_md5sum_and_fills_in_a_missing_type() -> None:
    with pytest.raises(RemoteProtocolError, match="without md5sum"):
        check_pub(publisher(md5sum="-"))
    assert check_pub(publisher(type="-")).type_name == "std_msgs/String"
    with pytest.raises(RemoteProtocolError, match="which type"):
        check_pub(publisher(type="-"), "*", "*")


def test_another_definition_is_told_on_the_publisher_with_both_sums_and_types() -> None:
    with pytest.raises(Md5sumMismatch) as caught:
        check_sub(subscriber(md5sum=TWIST, type="geometry_msgs/Twist", message_definition="Vector3 linear"))
    for word in ("/t", "/sub", "1.2.3.4:5", STRING, TWIST, "std_msgs/String", "geometry_msgs/Twist"):
        assert word in str(caught.value)
    error = caught.value
    assert (error.name, error.peer, error.type_name, error.md5sum) == (
        "/t",
        "1.2.3.4:5",
        "std_msgs/String",
        STRING,
    )
    assert (error.remote_type, error.remote_md5sum) == ("geometry_msgs/Twist", TWIST)
    assert error.message_definition == "Vector3 linear"


def test_another_definition_is_told_on_the_subscriber_with_the_publishers_text() -> None:
    with pytest.raises(Md5sumMismatch) as caught:
        check_pub(publisher(md5sum=TWIST, type="geometry_msgs/Twist", message_definition="Vector3 linear"))
    for word in ("/t", "/pub", STRING, TWIST, "std_msgs/String", "geometry_msgs/Twist"):
        assert word in str(caught.value)
    assert caught.value.message_definition == "Vector3 linear"


def test_equal_sums_fit_under_different_type_names() -> None:
    check_sub(subscriber(type="other_msgs/Text"))


ROSCPP_REFUSAL = (
    f"Client [/sub] wants topic /t to have datatype/md5sum [std_msgs/String/{STRING}], but our version has "
    f"[geometry_msgs/Twist/{TWIST}]. Dropping connection."
)


def test_a_refusal_that_names_another_sum_is_a_mismatch() -> None:
    with pytest.raises(Md5sumMismatch) as caught:
        check_pub(hs.error_header(ROSCPP_REFUSAL))
    assert caught.value.remote_md5sum == TWIST
    assert ROSCPP_REFUSAL in str(caught.value)


@pytest.mark.promise("A refusal is a header with the single")
def test_any_other_refusal_shows_the_peers_words() -> None:
    with pytest.raises(hs.HandshakeRefused, match="topic types do not match") as caught:
        check_pub(hs.error_header("topic types do not match"))
    assert (caught.value.name, caught.value.peer, caught.value.text) == (
        "/t",
        "1.2.3.4:5",
        "topic types do not match",
    )
    with pytest.raises(hs.HandshakeRefused):
        check_sub(hs.error_header("no"))


def test_another_topic_is_refused() -> None:
    with pytest.raises(RemoteProtocolError, match="/other"):
        check_sub(subscriber(topic="/other"))


@pytest.mark.promise("`persistent` is true as `1` or `true`")
@pytest.mark.parametrize(
    ("value", "meaning"),
    [("1", True), ("true", True), ("True", True), ("0", False), ("", False), ("yes", False)],
)
def test_flags_are_1_or_true(value: str, meaning: bool) -> None:
    fields = {"service": "/s", "md5sum": "*", "callerid": "/c", "persistent": value, "probe": value}
    request = hs.check_service_client_header(fields, service="/s", type_name="p/S", md5sum=STRING)
    assert (request.persistent, request.probe) == (meaning, meaning)


def test_service_client_and_server_agree() -> None:
    fields = hs.service_client_header(service="/s", md5sum=STRING, callerid="/c", persistent=True)
    request = hs.check_service_client_header(
        over_the_wire(fields), service="/s", type_name="p/S", md5sum=STRING
    )
    assert request == hs.ServiceRequest("/c", True, False)
    fields = hs.service_server_header(service="/s", type_name="p/S", md5sum=STRING, callerid="/n")
    assert (fields["request_type"], fields["response_type"]) == ("p/SRequest", "p/SResponse")
    hs.check_service_server_header(over_the_wire(fields), service="/s", type_name="*", md5sum="*")


def test_rospys_probe_is_understood() -> None:
    fields = {"probe": "1", "md5sum": "*", "callerid": "/rosservice", "service": "/s"}
    assert hs.check_service_client_header(fields, service="/s", type_name="p/S", md5sum=STRING).probe


def test_a_roscpp_server_without_type_is_understood() -> None:
    hs.check_service_server_header({"md5sum": STRING}, service="/s", type_name="p/S", md5sum=STRING)


def test_service_definitions_that_differ_are_told_on_both_sides() -> None:
    fields = hs.service_client_header(service="/s", md5sum=TWIST, callerid="/c", type_name="q/T")
    with pytest.raises(Md5sumMismatch, match=f"q/T.*{TWIST}.*p/S.*{STRING}"):
        hs.check_service_client_header(fields, service="/s", type_name="p/S", md5sum=STRING)
    fields = hs.service_server_header(service="/s", type_name="q/T", md5sum=TWIST, callerid="/n")
    with pytest.raises(Md5sumMismatch, match=f"q/T.*{TWIST}.*p/S.*{STRING}"):
        hs.check_service_server_header(fields, service="/s", type_name="p/S", md5sum=STRING)
    refusal = f"request from [/c]: md5sums do not match: [{STRING}] vs. [{TWIST}]"  # rospy's words
    with pytest.raises(Md5sumMismatch, match="md5sums do not match"):
        hs.check_service_server_header({"error": refusal}, service="/s", type_name="p/S", md5sum=STRING)


@pytest.mark.parametrize("missing", ["service", "md5sum", "callerid"])
def test_a_service_server_requires_service_md5sum_and_callerid(missing: str) -> None:
    fields = hs.service_client_header(service="/s", md5sum=STRING, callerid="/c")
    del fields[missing]
    with pytest.raises(RemoteProtocolError, match=f"without {missing}"):
        hs.check_service_client_header(fields, service="/s", type_name="p/S", md5sum=STRING)


@pytest.mark.parametrize(
    ("text", "meaning"),
    [("d41d8cd98f00b204e9800998ecf8427e", True), ("*", False), ("", False), ("D41D8CD98F00B204E9800998ECF8427E", False),
     ("d41d8cd98f00b204e9800998ecf8427e\n", False), ("d" * 10_000, False)],
)  # fmt: skip
def test_what_can_be_an_md5sum(text: str, meaning: bool) -> None:
    """32 small hexadecimal digits, nothing else."""
    assert hs.is_md5sum(text) is meaning
